"""Surfaces in space that the picture is laid on: by name, from a file, and as a picture of their own."""

from collections.abc import Callable
from pathlib import Path

from app.editor.editor import Editor
from app.files.document_io import ask_save_beside
from app.model.requests import ExportOptions, OpenFile
from core.files.text import legible
from core.progress import Job, Progress
from core.surfaces.mesh_file import SUFFIXES, read_mesh
from core.surfaces.shapes import make_shape
from core.surfaces.surface import Surface

VIEW_PX = 1024
"""Pixels a side of a view that is exported."""
VIEWS = ("png", "jpg", "tif", "webp")


def choose_shape(editor: Editor, name: str, number: float | None = None) -> None:
    """Lay the picture on a shape of a name."""
    _lay(editor, f"Lay on a {name}", lambda: make_shape(name, number))


def ask_open_mesh(editor: Editor) -> None:
    """Ask for a mesh, and lay the picture on it."""
    suffixes = tuple(suffix[1:] for suffix in SUFFIXES)
    title = "Open a mesh to lay the picture on"
    editor.requests.append(OpenFile(title, suffixes, lambda path: open_mesh(editor, path)))


def open_mesh(editor: Editor, path: Path) -> None:
    """Lay the picture on the surface in a file."""
    _lay(editor, f"Lay on {legible(path.name)}", lambda: read_mesh(path))


def _lay(editor: Editor, name: str, make: Callable[[], Surface]) -> None:
    """Lay the picture on the surface that `make` makes, once it is flattened."""

    def steps() -> Job[Surface]:
        yield Progress(0.0, "reading")
        surface = make()
        yield Progress(0.5, "flattening")
        surface.chart.size_px((1, 1))
        return surface

    editor.start(name, steps, lambda document, surface: document.changed(surface=surface, warp_map=None))


def ask_export_view(editor: Editor) -> None:
    """Ask where to write a picture of the surface as the camera sees it, and do it."""
    editor.finish()
    exporter, document, orbit = editor.exporter, editor.document.changed(mode="warp"), editor.session.orbit
    if exporter is None:
        return
    settled = editor.live.settled(document)
    ask_save_beside(
        editor,
        "Export the view",
        VIEWS,
        "view.png",
        lambda path: exporter(document, ExportOptions(path, (VIEW_PX, VIEW_PX), view=orbit, settled=settled)),
    )
