"""The mark of a key, on the timeline and beside what can have keys, where a press puts a key or takes it out."""

from imgui_bundle import ImVec2, imgui

from app.editor.editor import Editor
from app.marking.keying import has_key, name_of, toggle_key
from app.ui.widgets import theme
from app.ui.widgets.controls import tip
from app.ui.widgets.theme import color, em
from core.document.animated import Animated, tracks_of
from core.document.keys import Easing

SIDE_EM = 1.1


def key_button(editor: Editor, what: Animated, *, is_low: bool = False) -> None:
    """Draw the button, while the timeline shows, before what comes next; filled where a key is at this frame.

    What comes next is as high as a control or, where it `is_low`, as a line of text.
    """
    if not editor.session.timeline:
        return
    is_key, is_animated = has_key(editor, what), what in tracks_of(editor.document)
    size = ImVec2(em(SIDE_EM), imgui.get_text_line_height() if is_low else imgui.get_frame_height())
    pressed = imgui.invisible_button(f"key {what}", size)
    low, hovered = imgui.get_item_rect_min(), imgui.is_item_hovered()
    shade = theme.ACCENT if is_animated or hovered else theme.FAINT
    centre = low.x + size.x / 2 - em(0.1), low.y + size.y / 2
    draw_key(imgui.get_window_draw_list(), centre, em(0.34), color(shade), "linear", filled=is_key)
    name = name_of(editor.document, what)
    tip(f"{name}: take the key at this frame out" if is_key else f"{name}: put a key at this frame")
    if pressed:
        toggle_key(editor, what)
    imgui.same_line(0, em(0.2))


def draw_key(
    sheet: imgui.ImDrawList,
    centre: tuple[float, float],
    radius: float,
    shade: int,
    easing: Easing,
    *,
    filled: bool = True,
) -> None:
    """Draw a key by its easing: a diamond for linear, a square for hold, a disc for what is gentle."""
    x, y = centre
    if easing == "hold":
        half = 0.78 * radius
        draw = sheet.add_rect_filled if filled else sheet.add_rect
        draw((x - half, y - half), (x + half, y + half), shade)
    elif easing == "linear":
        corners = (x, y - radius), (x + radius, y), (x, y + radius), (x - radius, y)
        (sheet.add_quad_filled if filled else sheet.add_quad)(*corners, shade)
    elif filled:
        sheet.add_circle_filled(centre, 0.85 * radius, shade)
    else:
        sheet.add_circle(centre, 0.85 * radius, shade)
