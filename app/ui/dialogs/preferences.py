"""The sheet of preferences; what is changed there holds at once and in later runs."""

from imgui_bundle import ImVec2, imgui

from app.editor.editor import Editor
from app.state.preferences import LIMITS, Preferences
from app.ui.dialogs.modal import within
from app.ui.widgets.controls import check, faint, label, segments
from app.ui.widgets.sliders import slider
from app.ui.widgets.theme import em

SCALES = (0.8, 1.0, 1.25, 1.5, 2.0)

SOLVERS = (
    ("auto", "Automatic", "The GPU, where it has a driver of its own and OpenGL 4.3"),
    ("gpu", "GPU", "Wherever there is OpenGL 4.3"),
    ("processor", "Processor", ""),
)


class PreferencesSheet:
    """Draws the sheet's inside."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor

    def draw(self) -> None:
        """Draw a row for each preference."""
        imgui.dummy(ImVec2(within(29), 0))
        preferences = self._editor.preferences
        label("Text size", "Of text and controls, over what the display asks for")
        choices = [(f"{scale:g}", f"{scale:.0%}", "") for scale in SCALES]
        chosen = segments("scale", choices, f"{preferences.scale:g}")
        if chosen is not None:
            self._editor.prefer(preferences.changed(scale=float(chosen)))
        hint = "Memory for what can be undone, in megabytes; the oldest steps go first"
        self._slide("Undo, MB", "undo_mb", hint, logarithmic=True)
        self._slide("Autosave, s", "keep_every_s", "Unsaved work is kept for recovery at most so many seconds later")
        label("While moving")
        drafts = check("Draw faster, less sharp", preferences.drafts, "The picture is drawn at its best once it rests")
        if drafts is not None:
            self._editor.prefer(preferences.changed(drafts=drafts))
        label("Large grids", "What answers while something moves; files are always made from the processor's answer")
        solver = segments("solver", SOLVERS, preferences.solver)
        if solver is not None:
            self._editor.prefer(preferences.changed(solver=solver))
        label("When saving")
        hint = "The version before stays beside the project, as its name with ~ behind it"
        backups = check("Keep the version before", preferences.backups, hint)
        if backups is not None:
            self._editor.prefer(preferences.changed(backups=backups))
        imgui.dummy(ImVec2(0, em(0.2)))
        faint(
            "Kept in the user's settings."
            if self._editor.preferences_file is None
            else f"Kept in {self._editor.preferences_file}"
        )

    def _slide(self, name: str, part: str, hint: str, *, logarithmic: bool = False) -> None:
        value: float = getattr(self._editor.preferences, part)
        low, high = LIMITS[part]
        default: float = getattr(Preferences(), part)
        held = slider(name, value, low, high, default=default, hint=hint, logarithmic=logarithmic)
        if held.value is not None:
            self._editor.prefer(self._editor.preferences.changed(**{part: held.value}), keep=False)
        if held.done:
            self._editor.prefer(self._editor.preferences)
