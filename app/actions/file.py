"""Actions on files."""

from pathlib import Path

from app.actions import Action, ActionGroup, in_warp
from app.editor.editor import Editor
from app.files import document_io, warp_files
from core.files.text import legible

_FILE = ActionGroup("file", "File")
_OPEN_WARP = ActionGroup("file", "File/Open warp", in_warp)
_RECENT = ActionGroup("file.recent", "File/Open recent")


def recent_actions(editor: Editor) -> tuple[Action, ...]:
    """Return an action for each of the files opened last."""
    return tuple(
        _RECENT.action(
            str(number),
            legible(Path(path).name),
            lambda editor, path=path: document_io.open_path(editor, Path(path)),  # type: ignore[misc]
            tooltip=legible(path),
        )
        for number, path in enumerate(editor.session.recent)
    )


FILE = (
    _FILE.action(
        "new", "New from picture…", document_io.ask_new, "file-circle-plus", "Begin a project with a picture", "Ctrl+N"
    ),
    _FILE.action("open", "Open…", document_io.ask_open, "folder-open", "Open a picture or a project", "Ctrl+O"),
    _OPEN_WARP.action(
        "open_st_map",
        "ST map…",
        lambda editor: warp_files.ask_open_warp(editor, "st"),
        "bezier-curve",
        "Bend the picture by an ST map (EXR) of another program",
    ),
    _OPEN_WARP.action(
        "open_displacement",
        "Displacement…",
        lambda editor: warp_files.ask_open_warp(editor, "displacement"),
        "arrows-up-down-left-right",
        "Bend the picture by a displacement (EXR): pixels to the right and up, of the picture's own size",
    ),
    _OPEN_WARP.removal(
        "remove_warp",
        "Remove opened warp",
        "trash-can",
        "Take the ST map or the displacement out",
        {"warp_map": None},
    ),
    _FILE.action(
        "save",
        "Save",
        document_io.save,
        "floppy-disk",
        "Save the project",
        "Ctrl+S",
        enabled=lambda editor: not editor.history.is_saved or editor.project_path is None,
        separated=True,
    ),
    _FILE.action(
        "save_as", "Save as…", document_io.save_as, tooltip="Save the project under another name", chord="Ctrl+Shift+S"
    ),
    _FILE.action(
        "export",
        "Export picture…",
        document_io.ask_export,
        "file-export",
        "Write the picture as it is now to a file",
        "Ctrl+E",
        enabled=lambda editor: editor.exporter is not None,
    ),
    _FILE.action(
        "export_again",
        "Export again",
        document_io.export_again,
        "rotate-right",
        "Write the picture as it is now to the file of the last export, in the same way",
        "Ctrl+Shift+E",
        enabled=document_io.was_exported,
    ),
    _FILE.action(
        "replace_picture",
        "Replace picture…",
        document_io.ask_picture,
        "image",
        "Do to another picture what was done to this one",
        separated=True,
    ),
    _FILE.action("quit", "Quit", document_io.quit_editor, "power-off", "Close Weft", "Ctrl+Q", separated=True),
)
