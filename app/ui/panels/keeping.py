"""How the features that are chosen in the list are kept: similar or rigid or by their lines, upright, within sizes."""

from collections.abc import Sequence

from app.editor.editor import Editor
from app.marking.feature_list import say
from app.ui.widgets.controls import check, disabled, label, segments
from app.ui.widgets.sliders import slider
from core.document.feature import Feature

AS_ALL = "all"
KEEPS = (
    (AS_ALL, "As all", "As the panel of the warp says of all features"),
    ("similarity", "Similar", "It moves, turns and scales as a whole"),
    ("rigid", "Rigid", "It only moves and turns: its size stays"),
    ("lines", "Lines", "It bends with the warp, but its long straight lines stay straight"),
)
LEAST, MOST = 5.0, 2000.0
"""Per cent at which the sliders of sizes end, and stand for no bound."""


class Keeping:
    """Choices over `Document.features`, for all features that are chosen; shown is what is said of the first."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor

    def draw(self, chosen: Sequence[Feature]) -> None:
        """Draw the choices, where any feature is chosen."""
        if not chosen:
            return
        first, warp = chosen[0], self._editor.document.warp
        with disabled(warp.keep == "none" or not any(feature.kept for feature in chosen)):
            self._draw_keep(first)
            self._draw_upright(first)
            self._draw_protection(first)
            self._draw_sizes(first, is_rigid=(first.keep or warp.keep) == "rigid")

    def _draw_keep(self, first: Feature) -> None:
        label("Keep", "How the chosen features keep their shape")
        keep = segments("keep one", KEEPS, first.keep or AS_ALL)
        if keep is not None:
            self._say("Keep feature as", keep=None if keep == AS_ALL else keep)

    def _draw_upright(self, first: Feature) -> None:
        lines = first.keep == "lines"
        upright = check("Upright", first.upright, "Their lines keep their angle" if lines else "They do not turn")
        if upright is not None:
            self._say("Upright feature", upright=upright)

    def _draw_protection(self, first: Feature) -> None:
        what = "of the bends of their lines is taken away" if first.keep == "lines" else "of their shape is kept"
        held = slider("Protection", 100 * first.weight, 0, 100, default=100, hint=f"How much {what}, per cent")
        if held.value is not None:
            self._say("Protection of feature", slides=True, weight=held.value / 100)
        if held.done:
            self._editor.finish()

    def _draw_sizes(self, first: Feature, *, is_rigid: bool) -> None:
        """Draw the bounds of the size; one that is pushed beyond the other takes it along."""
        least = LEAST if first.least is None else 100 * first.least
        most = MOST if first.most is None else 100 * first.most
        what = "Length that their lines have" if first.keep == "lines" else "Size that they have"
        hint = f"{what} at least and at most, in per cent of that in the picture"
        if is_rigid:
            hint = "A rigid feature keeps the size that it has in the picture: there is nothing to bound"
        for name, value, default in (("Size from", least, LEAST), ("Size to", most, MOST)):
            with disabled(is_rigid):
                held = slider(name, value, LEAST, MOST, default=default, logarithmic=True, hint=hint)
            if held.value is not None:
                low = held.value if default == LEAST else min(least, held.value)
                high = held.value if default == MOST else max(most, held.value)
                bounds = {"least": low / 100 if low > LEAST else None, "most": high / 100 if high < MOST else None}
                self._say("Size of feature", slides=True, **bounds)
            if held.done:
                self._editor.finish()

    def _say(self, what: str, *, slides: bool = False, **changes: object) -> None:
        say(self._editor, what, self._editor.session.features, slides=slides, **changes)
