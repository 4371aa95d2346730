"""Actions on the history and on jobs."""

from app.actions import ActionGroup, make_toggle
from app.editor.editor import Editor
from app.model.requests import Panel

_EDIT, _HELP = ActionGroup("edit", "Edit"), ActionGroup("help", "Help")
_TOURS = ActionGroup("help.tour", "Help/Tours")

EDIT = (
    _EDIT.action(
        "undo",
        "Undo",
        Editor.undo,
        "rotate-left",
        "Take back what was done last",
        "Ctrl+Z",
        enabled=lambda editor: editor.is_busy or editor.history.undo_label is not None,
    ),
    _EDIT.action(
        "redo",
        "Redo",
        Editor.redo,
        "rotate-right",
        "Do again what was taken back",
        "Ctrl+Shift+Z",
        enabled=lambda editor: editor.history.redo_label is not None,
        more_chords=("Ctrl+Y",),
    ),
    _EDIT.action(
        "history",
        "History…",
        make_toggle("history"),
        "clock-rotate-left",
        "Show everything that was done, and go back to any of it",
        "Ctrl+H",
    ),
    _EDIT.action(
        "cancel_job",
        "Cancel job",
        lambda editor: editor.jobs.cancel_all(),
        "ban",
        "Stop the work in the background",
        "Ctrl+.",
        enabled=lambda editor: bool(editor.jobs.long_jobs),
        separated=True,
    ),
    _EDIT.action(
        "preferences",
        "Preferences…",
        make_toggle("preferences"),
        "gear",
        "Size of the text, memory for undo, recovery",
        "Ctrl+,",
        separated=True,
    ),
)

TOURS: tuple[tuple[str, str, str, Panel], ...] = (
    ("warp", "Bend a picture", "Balloons stay round while the sky bends", "tour-warp"),
    ("retexture", "Move a tail", "Fur is regrown along a curve", "tour-retexture"),
    ("overlay", "Dress a cloth", "A new pattern in photographed folds", "tour-overlay"),
)
"""By mode, title of its tour, what it is about, and what the window is asked for."""

HELP = (
    _HELP.action(
        "palette",
        "Command palette…",
        make_toggle("palette"),
        "terminal",
        "Find anything by its name",
        "Ctrl+Shift+P",
        more_chords=("F3",),
    ),
    _HELP.action("keys", "Keys…", make_toggle("keys"), "keyboard", "Show all keys", "F1"),
    *(
        _TOURS.action(mode, f"{title}…", make_toggle(panel), "route", f"{about}: a sample and a few steps")
        for mode, title, about, panel in TOURS
    ),
    _HELP.action(
        "about", "About Weft", make_toggle("about"), "circle-info", "Version, papers and licence", separated=True
    ),
)
