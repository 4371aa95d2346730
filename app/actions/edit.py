"""Actions on the history and on jobs."""

from app.actions import Action
from app.actions.panels import make_toggle
from app.editor.editor import Editor
from app.model.requests import Panel

EDIT = (
    Action(
        "edit.undo",
        "Undo",
        "Edit",
        Editor.undo,
        "Ctrl+Z",
        "rotate-left",
        "Take back what was done last",
        enabled=lambda editor: editor.is_busy or editor.history.undo_label is not None,
    ),
    Action(
        "edit.redo",
        "Redo",
        "Edit",
        Editor.redo,
        "Ctrl+Shift+Z",
        "rotate-right",
        "Do again what was taken back",
        enabled=lambda editor: editor.history.redo_label is not None,
        more_chords=("Ctrl+Y",),
    ),
    Action(
        "edit.history",
        "History…",
        "Edit",
        make_toggle("history"),
        "Ctrl+H",
        "clock-rotate-left",
        "Show everything that was done, and go back to any of it",
    ),
    Action(
        "edit.cancel_job",
        "Cancel job",
        "Edit",
        lambda editor: editor.jobs.cancel_all(),
        "Ctrl+.",
        "ban",
        "Stop the work in the background",
        enabled=lambda editor: bool(editor.jobs.long_jobs),
        separated=True,
    ),
    Action(
        "edit.preferences",
        "Preferences…",
        "Edit",
        make_toggle("preferences"),
        "Ctrl+,",
        "gear",
        "Size of the text, memory for undo, recovery",
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
    Action(
        "help.palette",
        "Command palette…",
        "Help",
        make_toggle("palette"),
        "Ctrl+Shift+P",
        "terminal",
        "Find anything by its name",
        more_chords=("F3",),
    ),
    Action(
        "help.keys",
        "Keys…",
        "Help",
        make_toggle("keys"),
        "F1",
        "keyboard",
        "Show all keys",
    ),
    *(
        Action(
            f"help.tour.{mode}",
            f"{title}…",
            "Help/Tours",
            make_toggle(panel),
            icon="route",
            tooltip=f"{about}: a sample and a few steps",
        )
        for mode, title, about, panel in TOURS
    ),
    Action(
        "help.about",
        "About Weft",
        "Help",
        make_toggle("about"),
        icon="circle-info",
        tooltip="Version, papers and licence",
        separated=True,
    ),
)
