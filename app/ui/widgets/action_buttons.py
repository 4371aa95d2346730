"""Actions as buttons on a panel: grey where they cannot be done now, each in its place whatever is done."""

from collections.abc import Sequence

from imgui_bundle import ImVec2, imgui

from app.actions import Action
from app.editor.editor import Editor
from app.ui.widgets.controls import shorten, tip
from app.ui.widgets.theme import em

GAP_EM = 0.3


def action_button(editor: Editor, action: Action, *, text: str = "", width: float = 0.0, height: float = 0.0) -> None:
    """Draw the button of an action, in screen pixels; as wide as the panel and as high as a line by default."""
    imgui.begin_disabled(not action.enabled(editor))
    size = ImVec2(width or imgui.get_content_region_avail().x, height)
    label = text or action.label
    shown = shorten(label, size.x - 2 * imgui.get_style().frame_padding.x)
    if imgui.button(shown if shown == label else f"{shown}###{label}", size):
        action.run(editor)
    imgui.end_disabled()
    tip(action.tooltip if shown == label else f"{label}\n{action.tooltip}", action.chord)


def action_buttons(editor: Editor, actions: Sequence[Action]) -> None:
    """Draw the buttons of actions side by side, or below one another where their labels have no room for that."""
    room, count = imgui.get_content_region_avail().x, len(actions)
    width = (room - em(GAP_EM) * (count - 1)) / count
    padding = 2 * imgui.get_style().frame_padding.x
    fits = all(imgui.calc_text_size(action.label).x + padding <= width for action in actions)
    for number, action in enumerate(actions):
        if fits and number:
            imgui.same_line(0, em(GAP_EM))
        action_button(editor, action, width=width if fits else 0.0)
