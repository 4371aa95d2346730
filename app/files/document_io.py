"""Opening, saving and exporting: between the editor and the disk. Long work is jobs, questions are requests."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from weakref import WeakKeyDictionary

import platformdirs

from app.editor.editor import Editor
from app.files.warp_files import SUFFIXES as WARP_SUFFIXES
from app.files.warp_files import write_warp
from app.marking.feature_list import with_orders
from app.model.requests import (
    PICTURES,
    PROJECTS,
    AskChanged,
    AskUnsaved,
    AskWriting,
    Changed,
    ExportOptions,
    ExportPicture,
    OpenFile,
    SaveFile,
    Unsaved,
    Writing,
    complete,
)
from app.state.project_file import ChangedOnDiskError, keep_backup
from app.state.state_files import read_state
from core.arrays import InputError
from core.canvas import Canvas, has_gaps
from core.document.document import Document
from core.document.overlay import UNSOUGHT
from core.document.overlay_texture import is_changed
from core.document.project import SUFFIX, load_project, save_project
from core.files.atomic import write_text
from core.files.text import legible
from core.imaging.images import load
from core.imaging.writing import SUFFIXES
from core.progress import Job, Progress, in_one_step

_exported: WeakKeyDictionary[Editor, tuple[Path | None, tuple[int, int], ExportOptions]] = WeakKeyDictionary()
"""The last export of each editor: of which file, how large its result was, and the options."""
RECENT = 12


def is_project(path: Path) -> bool:
    """Return whether `path` is named like a project."""
    return path.suffix.lower() == SUFFIX


def guard(editor: Editor, then: Callable[[], None]) -> None:
    """Do `then`, which gives up the document; if it is not saved, ask first."""
    editor.finish()
    if editor.history.is_saved:
        then()
        return

    def answered(choice: Unsaved) -> None:
        if choice == "discard":
            then()
        elif choice == "save":
            save(editor, then=then)

    editor.requests.append(AskUnsaved(editor.name, answered))


def ask_open(editor: Editor) -> None:
    """Ask for a picture or a project and open it."""
    editor.requests.append(OpenFile("Open", PROJECTS + PICTURES, lambda path: open_path(editor, path)))


def ask_new(editor: Editor) -> None:
    """Ask for a picture and begin a project with it."""
    editor.requests.append(OpenFile("New from picture", PICTURES, lambda path: open_path(editor, path)))


def open_path(editor: Editor, path: Path) -> None:
    """Open a picture or a project in place of the present document."""
    guard(editor, lambda: _open(editor, path))


def _open(editor: Editor, path: Path) -> None:
    def steps() -> Job[Document]:
        yield Progress(0.0, "reading")
        editor.on_disk.note(path)
        return load_project(path) if is_project(path) else Document.of(load(path))

    before = editor.document

    def deliver(document: Document) -> None:
        def replace_document() -> None:
            project, source = (path, None) if is_project(path) else (None, path)
            editor.replace_document(document, project=project, source=source)
            remember(editor, path)

        # What was done while the file was read is not to be lost either.
        replace_document() if editor.document is before else guard(editor, replace_document)

    editor.background(f"Open {legible(path.name)}", steps, deliver)


def save(editor: Editor, *, then: Callable[[], None] | None = None) -> None:
    """Save the project where it is, or ask where to; do `then` once it is on the disk."""
    editor.finish()
    if editor.project_path is None:
        save_as(editor, then=then)
    else:
        _save_to(editor, editor.project_path, then)


def save_as(editor: Editor, *, then: Callable[[], None] | None = None) -> None:
    """Ask where to save the project."""
    editor.finish()
    near = editor.project_path or editor.source_path or Path("Untitled")
    chosen = lambda path: _save_to(editor, complete(path, PROJECTS), then)  # noqa: E731
    editor.requests.append(SaveFile("Save project as", PROJECTS, near.with_suffix(SUFFIX), chosen))


def _save_to(editor: Editor, path: Path, then: Callable[[], None] | None, *, overwrites: bool = False) -> None:
    """Write the project to `path`; ask first where somebody else has written it, unless it `overwrites` that."""
    document, backups = editor.history.document, editor.preferences.backups
    saved = with_orders(editor, document)

    def steps() -> Job[None]:
        yield Progress(0.0, "writing")
        if not overwrites:
            editor.on_disk.check(path)
        if backups:
            keep_backup(path)
        save_project(saved, path)
        editor.on_disk.note(path)

    def deliver(_: None) -> None:
        editor.history.mark_saved(document)
        editor.project_path = path
        remember(editor, path)
        editor.notify(f"Saved {legible(path.name)}")
        if then is not None:
            then()

    def failed(fault: Exception) -> None:
        if isinstance(fault, ChangedOnDiskError):
            editor.requests.append(AskChanged(legible(path.name), answered))
        else:
            editor.fail(fault)

    def answered(choice: Changed) -> None:
        if choice == "overwrite":
            _save_to(editor, path, then, overwrites=True)
        elif choice == "save_as":
            save_as(editor, then=then)
        elif choice == "reload":
            _open(editor, path)

    editor.background(f"Save {legible(path.name)}", steps, deliver, failed=failed, writes=True)


def ask_export(editor: Editor) -> None:
    """Ask how to export the picture, and do it; what is laid on cloth waits until its pattern is found."""
    editor.finish()
    if editor.session.mode == "overlay" and not editor.overlay.is_final and is_changed(editor.document.cloth):
        is_sought = editor.document.cloth.search is not None
        why = editor.overlay.fault or ("the pattern of the cloth is still being looked for" if is_sought else UNSOUGHT)
        editor.fail(InputError(f"Nothing to export yet: {why}"))
        return
    document = editor.document.changed(mode=editor.session.mode)
    options = ExportOptions(propose_export(editor), document.result_px)
    editor.requests.append(ExportPicture(document, options, lambda chosen: export(editor, chosen)))


def propose_export(editor: Editor) -> Path:
    """Return the file to export to: that of the last export, or one beside the project that is called like it.

    It has the picture's ending, but that of a PNG where JPEG would show the gaps beside a bent picture as white. A file
    that is there, such as the picture itself, is not proposed.
    """
    if was_exported(editor):
        return _exported[editor][2].path
    near = editor.project_path or editor.source_path or Path("Untitled")
    ending = (editor.source_path or near).suffix.lower()
    has_no_alpha = ending in (".jpg", ".jpeg")
    if ending not in SUFFIXES or (has_no_alpha and _has_gaps(editor)):
        ending = ".png"
    path = near.with_suffix(ending)
    is_free = editor.project_path is not None and not path.exists()
    return path if is_free else path.with_stem(f"{path.stem}-weft")


def _has_gaps(editor: Editor) -> bool:
    """Return whether a rectangle around the result shows something beside it."""
    if editor.session.mode != "warp":
        return False
    try:
        canvas = Canvas.around(editor.map.warped)
    except InputError:
        return True
    return has_gaps(canvas.placed(editor.map.warped), canvas.size)


def export(editor: Editor, options: ExportOptions) -> None:
    """Write the present mode's result to a file, as a job."""
    exporter, document = editor.exporter, editor.document.changed(mode=editor.session.mode)
    if exporter is None:
        return
    _exported[editor] = (editor.project_path or editor.source_path, document.result_px, options)
    done = lambda _: editor.notify(f"Exported {legible(options.path.name)}")  # noqa: E731
    known = replace(options, settled=editor.live.settled(document))
    editor.background(f"Export {legible(options.path.name)}", lambda: exporter(document, known), done, writes=True)


def was_exported(editor: Editor) -> bool:
    """Return whether this project or picture has been exported since the program began."""
    return editor in _exported and _exported[editor][0] == (editor.project_path or editor.source_path)


def export_again(editor: Editor) -> None:
    """Write the present result where and as the last export did, at the same scale; without one, ask."""
    editor.finish()
    if not was_exported(editor):
        ask_export(editor)
        return
    _, before, options = _exported[editor]
    now = editor.document.changed(mode=editor.session.mode).result_px
    width, height = (max(1, round(s * n / b)) for s, n, b in zip(options.size_px, now, before, strict=True))
    export(editor, replace(options, size_px=(width, height)))


def ask_export_warp(editor: Editor) -> None:
    """Ask where to write the warp itself, as an ST map or as a mesh, and do it."""
    editor.finish()
    document, settled = editor.document, editor.live.settled(editor.document)
    title = "Export warp: ST map (.exr) or mesh (.obj)"
    ask_save_beside(editor, title, WARP_SUFFIXES, "warp.exr", lambda path: write_warp(document, path, settled))


def ask_save_beside(
    editor: Editor, title: str, suffixes: tuple[str, ...], ending: str, writing: Callable[[Path], Job[None]]
) -> None:
    """Ask where to write a file, beside the project and named after it and `ending` unless chosen otherwise."""
    near = editor.project_path or editor.source_path or Path("Untitled")

    def write(path: Path) -> None:
        done = lambda _: editor.notify(f"Saved {legible(path.name)}")  # noqa: E731
        editor.background(f"Save {legible(path.name)}", lambda: writing(path), done, writes=True)

    editor.requests.append(SaveFile(title, suffixes, near.with_name(f"{near.stem}-{ending}"), write))


def quit_editor(editor: Editor) -> None:
    """Close the editor; if there is unsaved work, or a file is being written, ask first."""
    guard(editor, lambda: _close_when_written(editor))


def _close_when_written(editor: Editor) -> None:
    writing = [ticket for ticket in editor.jobs.long_jobs if ticket.task.writes and not ticket.cancelled]

    def answered(choice: Writing) -> None:
        if choice == "stop":
            _close(editor)
        elif choice == "wait":
            # It takes its turn behind what is being written.
            editor.background("Quit", lambda: in_one_step("waiting", lambda: None), leave)

    def leave(_: None) -> None:
        if all(ticket.state == "finished" for ticket in writing):
            quit_editor(editor)

    if writing:
        editor.requests.append(AskWriting(tuple(ticket.name for ticket in writing), answered))
    else:
        _close(editor)


def _close(editor: Editor) -> None:
    if editor.recovery is not None:
        editor.recovery.forget()
    editor.is_closing = True


def ask_picture(editor: Editor) -> None:
    """Ask for another picture to do to what was done to this one."""
    editor.requests.append(OpenFile("Replace picture", PICTURES, lambda path: replace_picture(editor, path)))


def replace_picture(editor: Editor, path: Path) -> None:
    """Put another picture in place of the document's, and keep all that was done to it."""
    steps = lambda: in_one_step("reading", load, path)  # noqa: E731
    editor.start("Replace picture", steps, lambda document, image: document.with_image(image))


def settings_file() -> Path:
    """Return the file of what the editor remembers from run to run."""
    return Path(platformdirs.user_config_path("weft")) / "recent.json"


def recent_files(file: Path | None = None) -> tuple[str, ...]:
    """Return the paths opened last, the newest first; none where there is no record."""
    paths = read_state(file or settings_file(), list) or ()
    return tuple(path for path in paths if isinstance(path, str) and "\0" not in path)[:RECENT]


def remember(editor: Editor, path: Path) -> None:
    """Put `path` first among the files opened last."""
    newest = str(path.resolve())
    recent = (newest, *(old for old in editor.session.recent if old != newest))[:RECENT]
    editor.session = replace(editor.session, recent=recent)
    if editor.recent_file is not None:
        _keep_recent(editor.recent_file, recent)


def _keep_recent(file: Path, recent: tuple[str, ...]) -> None:
    """Write the record; a place that cannot be written to costs the artist nothing but the list."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_text(file, json.dumps(recent))
    except (OSError, InputError):
        return
