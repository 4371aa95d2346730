"""What becomes of a file that is dropped on the window."""

from pathlib import Path

from app.actions.overlay import has_layers, in_mode, lay
from app.editor.editor import Editor
from app.files import document_io
from core.document.map import with_warp_map
from core.files.text import legible
from core.imaging.images import load
from core.progress import Job, Progress
from core.warps.map_file import WarpMap, is_st_map, warp_map_in


def take(editor: Editor, path: Path) -> None:
    """Lay a picture on cloth that was found, or is looked for; bend by an ST map in Warp mode; open anything else."""
    if (has_layers(editor) or (in_mode(editor) and editor.overlay.is_running)) and not document_io.is_project(path):
        lay(editor, path)
    elif editor.session.mode == "warp" and path.suffix.lower() == ".exr":
        _bend_or_open(editor, path)
    else:
        document_io.open_path(editor, path)


def _bend_or_open(editor: Editor, path: Path) -> None:
    """Look into a float picture: an ST map becomes the warp, which can be undone, and a picture is opened."""
    name = legible(path.name)

    def steps() -> Job[WarpMap | None]:
        yield Progress(0.0, "reading")
        image = load(path)
        return warp_map_in(image) if is_st_map(image) else None

    def deliver(found: WarpMap | None) -> None:
        if found is None:
            document_io.open_path(editor, path)
        else:
            editor.edit(f"Warp {name}", with_warp_map(editor.document, found))
            editor.notify(f"{name} is an ST map: it bends this picture")

    editor.background(f"Open {name}", steps, deliver)
