"""Actions on files."""

from pathlib import Path

from app.actions import Action
from app.actions.removal import removal
from app.editor.editor import Editor
from app.files import document_io, warp_files
from core.files.text import legible


def recent_actions(editor: Editor) -> tuple[Action, ...]:
    """Return an action for each of the files opened last."""
    return tuple(
        Action(
            f"file.recent.{number}",
            legible(Path(path).name),
            "File/Open recent",
            lambda editor, path=path: document_io.open_path(editor, Path(path)),  # type: ignore[misc]
            tooltip=legible(path),
        )
        for number, path in enumerate(editor.session.recent)
    )


FILE = (
    Action(
        "file.new",
        "New from picture…",
        "File",
        document_io.ask_new,
        "Ctrl+N",
        "file-circle-plus",
        "Begin a project with a picture",
    ),
    Action("file.open", "Open…", "File", document_io.ask_open, "Ctrl+O", "folder-open", "Open a picture or a project"),
    Action(
        "file.open_st_map",
        "ST map…",
        "File/Open warp",
        lambda editor: warp_files.ask_open_warp(editor, "st"),
        icon="bezier-curve",
        tooltip="Bend the picture by an ST map (EXR) of another program",
        enabled=lambda editor: editor.session.mode == "warp",
    ),
    Action(
        "file.open_displacement",
        "Displacement…",
        "File/Open warp",
        lambda editor: warp_files.ask_open_warp(editor, "displacement"),
        icon="arrows-up-down-left-right",
        tooltip="Bend the picture by a displacement (EXR): pixels to the right and up, of the picture's own size",
        enabled=lambda editor: editor.session.mode == "warp",
    ),
    removal(
        "file.remove_warp",
        "Remove opened warp",
        "File/Open warp",
        "warp",
        "trash-can",
        "Take the ST map or the displacement out",
        {"warp_map": None},
    ),
    Action(
        "file.save",
        "Save",
        "File",
        document_io.save,
        "Ctrl+S",
        "floppy-disk",
        "Save the project",
        enabled=lambda editor: not editor.history.is_saved or editor.project_path is None,
        separated=True,
    ),
    Action(
        "file.save_as",
        "Save as…",
        "File",
        document_io.save_as,
        "Ctrl+Shift+S",
        tooltip="Save the project under another name",
    ),
    Action(
        "file.export",
        "Export picture…",
        "File",
        document_io.ask_export,
        "Ctrl+E",
        "file-export",
        "Write the picture as it is now to a file",
        enabled=lambda editor: editor.exporter is not None,
    ),
    Action(
        "file.export_again",
        "Export again",
        "File",
        document_io.export_again,
        "Ctrl+Shift+E",
        "rotate-right",
        "Write the picture as it is now to the file of the last export, in the same way",
        enabled=document_io.was_exported,
    ),
    Action(
        "file.replace_picture",
        "Replace picture…",
        "File",
        document_io.ask_picture,
        icon="image",
        tooltip="Do to another picture what was done to this one",
        separated=True,
    ),
    Action("file.quit", "Quit", "File", document_io.quit_editor, "Ctrl+Q", "power-off", "Close Weft", separated=True),
)
