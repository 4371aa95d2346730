"""The timeline: what plays it and goes from frame to frame, over the chart of the keys."""

from imgui_bundle import imgui

from app.actions.table import ActionTable
from app.actions.timeline import EASING_LABELS
from app.editor.editor import Editor
from app.marking import keying
from app.ui.panels.timeline_chart import TimelineChart
from app.ui.widgets import theme
from app.ui.widgets.controls import colors, faint, icon_button, tip
from app.ui.widgets.sliders import number_box
from app.ui.widgets.theme import em
from core.document.animated import is_animated
from core.document.keys import EASINGS, MOST_FRAMES

STEPS = (
    *("timeline.first", "timeline.previous_key", "timeline.previous", "timeline.play"),
    *("timeline.next", "timeline.next_key", "timeline.last", "timeline.loop"),
)
ON_KEYS = ("timeline.set_keys", "timeline.remove_keys")
SIDE_EM, BOX_EM = 1.8, 3.6
EMPTY = (
    "No keys yet. Go to a frame and press a diamond beside a slider, a size or a pin, or Shift+K with pins selected. "
    "From then on what you change at another frame becomes a key there."
)


class TimelinePanel:
    """Draws the panel."""

    def __init__(self, editor: Editor, table: ActionTable) -> None:
        self._editor = editor
        self._table = table
        self.chart = TimelineChart(editor)

    def draw(self) -> None:
        """Draw the buttons, and below them the chart."""
        for name in STEPS:
            self._draw_button(name)
        imgui.same_line(0, em(0.8))
        self._draw_frame()
        for name in ON_KEYS:
            self._draw_button(name)
        self._draw_easing()
        self._draw_span()
        imgui.new_line()
        if is_animated(self._editor.document):
            self.chart.draw()
        else:
            self.chart.draw_ruler()
            faint(EMPTY)

    def _draw_button(self, name: str) -> None:
        action, editor = self._table.by_name[name], self._editor
        is_on = action.checked is not None and action.checked(editor)
        glyph = "pause" if name == "timeline.play" and is_on else action.icon
        imgui.begin_disabled(not action.enabled(editor))
        hint = f"{action.label}\n{action.tooltip}"
        if icon_button(name, glyph, on=is_on, quiet=True, hint=hint, key=action.chord, size_em=SIDE_EM):
            action.run(editor)
        imgui.end_disabled()
        imgui.same_line(0, em(0.15))

    def _draw_frame(self) -> None:
        typed = self._box("Frame", self._editor.session.frame, "The frame that is shown")
        if typed is not None:
            self._editor.animation.go_to(typed)

    def _draw_easing(self) -> None:
        """Draw the choice of how values go on from the selected keys."""
        editor, chosen = self._editor, keying.find_chosen_keys(self._editor)
        easing = keying.find_easing(editor)
        imgui.begin_disabled(not chosen)
        imgui.set_next_item_width(em(6.5))
        if imgui.begin_combo("##easing", EASING_LABELS[easing][0] if easing else "Easing"):
            for choice in EASINGS:
                label, hint = EASING_LABELS[choice]
                if imgui.selectable(label, choice == easing)[0]:
                    keying.ease_keys(editor, chosen, choice)
                tip(hint)
            imgui.end_combo()
        imgui.end_disabled()
        tip("How the values go from the selected keys to those after them")
        imgui.same_line(0, em(0.9))

    def _draw_span(self) -> None:
        """Draw the first and the last frame, and the frames a second."""
        span = self._editor.document.span
        first = self._box("From", span.first, "The first frame of the timeline")
        last = self._box("to", span.last, "The last frame of the timeline")
        rate = self._box("fps", span.rate, "Frames a second, for playing and for videos", digits=3)
        if first is not None:
            keying.set_span(self._editor, first=round(first))
        elif last is not None:
            keying.set_span(self._editor, last=round(last))
        elif rate is not None:
            keying.set_span(self._editor, rate=rate)

    def _box(self, name: str, value: float, hint: str, *, digits: int = 0) -> float | None:
        """Draw a number with its name before it, and return what was typed."""
        imgui.align_text_to_frame_padding()
        with colors(text=theme.FAINT):
            imgui.text(name)
        imgui.same_line(0, em(0.3))
        shown = 0 if value == round(value) else digits
        held = number_box(value, -MOST_FRAMES, MOST_FRAMES, shown, name=name, width_em=BOX_EM)
        tip(hint)
        imgui.same_line(0, em(0.6))
        return held.value if held.done else None
