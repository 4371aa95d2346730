"""Open the editor on a picture, a project, or the sample."""

import argparse
import itertools
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from app.console import run_shown
from app.editor.editor import Editor
from app.files.document_io import is_project, recent_files, remember, settings_file
from app.files.rescue_offers import offer_rescues
from app.model.jobs import Jobs
from app.model.requests import ExportOptions
from app.state.preferences import load_preferences, preferences_file
from app.state.recovery import Recovery
from app.tools.all import TOOLS
from app.tours.samples import warp_sample
from app.window.loading import loading
from core.document.document import Document
from core.document.project import load_project
from core.files.journal import tidy
from core.files.litter import sweep_scratch
from core.files.text import legible
from core.imaging.images import load
from core.linalg.jobs_beside import use_all_processors
from core.notices import hear_notices

if TYPE_CHECKING:
    from app.live.gpu_frames import MakeSolver
    from app.render.solver.choice import GpuSolver
    from core.progress import Job

WITHOUT_WINDOW = Path("weft-sample.png")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `weft`."""
    parser.add_argument("file", nargs="?", type=Path, help="a picture or a project")


def run(arguments: argparse.Namespace) -> None:
    """Open the window; where there is no display, render to a file and say so."""
    document = warp_sample() if arguments.file is None else open_up(arguments.file)
    with loading():
        import imgui_bundle  # noqa: F401  glfw takes its library, else it starts Python once more to find one

        from app.window import shell

    if not shell.has_display():
        render_without_window(bent(document) if arguments.file is None else document, arguments.file)
        return
    editor = editor_on(document, arguments.file, Jobs(wake=shell.wake))
    with keep_at_an_end(editor), use_all_processors():
        shell.show(editor, welcomes=arguments.file is None)


@contextmanager
def keep_at_an_end(editor: Editor) -> Iterator[None]:
    """Keep unsaved work when the block ends in any other way than by the artist closing the window."""
    try:
        yield
    finally:
        if not editor.is_closing:
            editor.keep_unsaved()


def open_up(path: Path) -> Document:
    """Read a project, or begin one with a picture."""
    return load_project(path) if is_project(path) else Document.of(load(path))


def bent(document: Document) -> Document:
    """Return `document` under an arc, for those who see only the file."""
    return document.changed(warp=replace(document.warp, preset="arc", bend=35.0))


def editor_on(document: Document, path: Path | None, jobs: Jobs) -> Editor:
    """Return an editor as the window wants it: it remembers what was opened and keeps what is not saved."""
    sweep_scratch()
    with hear_notices() as heard:
        editor = _editor_on(document, path, jobs)
    for text in heard:
        editor.notify(text)
    return editor


def _editor_on(document: Document, path: Path | None, jobs: Jobs) -> Editor:
    preferences = load_preferences(preferences_file())
    recovery = Recovery(jobs, every_s=preferences.keep_every_s)
    editor = Editor(
        document,
        TOOLS,
        jobs=jobs,
        recovery=recovery,
        exporter=_exporting,
        grid_solver=_GridSolvers(),
        preferences=preferences,
    )
    editor.preferences_file = preferences_file()
    editor.recent_file = settings_file()
    editor.session = replace(editor.session, recent=recent_files())
    if path is not None:
        editor.project_path, editor.source_path = (path, None) if is_project(path) else (None, path)
        editor.on_disk.note(path)
        remember(editor, path)
        tidy(path.absolute().parent)
    offer_rescues(editor)
    return editor


def free_name(path: Path) -> Path:
    """Return `path`, or the first of its name with a number behind it that no file has."""
    numbered = (path.with_name(f"{path.stem}-{number}{path.suffix}") for number in itertools.count(2))
    return path if not path.exists() else next(name for name in numbered if not name.exists())


def _exporting(document: Document, options: ExportOptions) -> "Job[None]":
    """Export by the renderer, which is imported only now: the window shows sooner."""
    from app.render.picture_file import exporting

    return exporting(document, options)


class _GridSolvers:
    """Finds what solves large grids by the renderer, which is imported only when one is asked for."""

    def __init__(self) -> None:
        self._solver: GpuSolver | None = None

    def __call__(self, preferred: str) -> "MakeSolver | None":
        if self._solver is None:
            from app.render.solver.choice import GpuSolver

            self._solver = GpuSolver()
        return self._solver.find(preferred)


def render_without_window(document: Document, file: Path | None) -> None:
    """Render `document` to a new file in the working folder, and say where it is and what a window needs."""
    from app.render.picture_file import writing

    path = free_name(WITHOUT_WINDOW if file is None else Path(f"{file.stem}-weft.png"))
    run_shown(writing(document, path, frame="warp"))
    print(f"weft: no display: rendered to {legible(str(path.resolve()))}")  # noqa: T201
    print("weft: a window needs an X11 display (DISPLAY; XWayland will do) and OpenGL 3.3")  # noqa: T201
