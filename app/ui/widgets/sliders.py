"""Sliders of one look: a slim track, a box to type into, an arrow to reset."""

from dataclasses import dataclass
from math import log

from imgui_bundle import ImVec2, imgui

from app.ui.widgets import theme
from app.ui.widgets.controls import colors, is_narrow, label, style_color, tip
from app.ui.widgets.theme import color, em, icon

NUMBER_EM, LEAST_NUMBER_EM, RESET_EM = 3.4, 2.7, 1.6
"""Width of the box to type into, in a narrow row, and of the arrow that resets."""
SLIDER_ROW_EM = 9.0
"""A row that is narrower than this after its label has a shorter box, too."""


@dataclass(frozen=True)
class Held:
    """What a slider says in one frame."""

    value: float | None = None
    """The new value, None where it did not change."""
    done: bool = False
    """Whether it was let go or typed in."""


def slider(
    name: str,
    value: float,
    low: float,
    high: float,
    *,
    default: float,
    digits: int = 0,
    logarithmic: bool = False,
    hint: str = "",
) -> Held:
    """Set a number of `digits` decimals: drag the track, double-click it to type; label and arrow reset."""
    imgui.push_id(name)
    narrow, end = is_narrow(), imgui.get_cursor_pos_x() + imgui.get_content_region_avail().x
    reset = label(name, f"{hint}\nDouble-click to reset." if hint else "Double-click to reset.", beside_em=RESET_EM)
    if narrow:
        imgui.same_line(end - em(RESET_EM), 0)
        reset = _reset(shown=value != default) or reset
    room = imgui.get_content_region_avail().x
    number_em = min(max(room / em(SLIDER_ROW_EM) * NUMBER_EM, LEAST_NUMBER_EM), NUMBER_EM)
    width = room - em(number_em + 0.4 + (0 if narrow else RESET_EM + 0.2))
    dragged = _track(value, low, high, default, width, logarithmic=logarithmic)
    types = imgui.is_item_hovered() and _asks_to_type()
    imgui.same_line(0, em(0.4))
    if types:
        imgui.set_keyboard_focus_here()
    typed = number_box(value, low, high, digits, width_em=number_em)
    if not narrow:
        imgui.same_line(0, em(0.2))
        reset = _reset(shown=value != default) or reset
    imgui.pop_id()
    if reset and value != default:
        return Held(default, done=True)
    held = typed if typed.done else dragged
    return Held(None if held.value is None else round(held.value, digits), held.done)


def bar_slider(
    name: str,
    value: float,
    low: float,
    high: float,
    *,
    unit: str = "",
    logarithmic: bool = False,
    width_em: float = 7.0,
) -> Held:
    """Set a whole number in one line: name, track, box to type into."""
    imgui.push_id(name)
    imgui.align_text_to_frame_padding()
    with colors(text=theme.FAINT):
        imgui.text(name)
    imgui.same_line(0, em(0.3))
    dragged = _track(value, low, high, low, em(width_em), logarithmic=logarithmic)
    imgui.same_line(0, em(0.3))
    typed = number_box(value, low, high, 0)
    if unit:
        imgui.same_line(0, em(0.3))
        with colors(text=theme.FAINT):
            imgui.text(unit)
    imgui.pop_id()
    return typed if typed.done else dragged


def bar_slider_width(name: str, unit: str, *, width_em: float) -> float:
    """Return how wide `bar_slider` is, in screen pixels."""
    return imgui.calc_text_size(name).x + imgui.calc_text_size(unit).x + em(width_em + NUMBER_EM + 0.9)


def _track(value: float, low: float, high: float, default: float, width: float, *, logarithmic: bool) -> Held:
    """Draw a slim slider, filled from the default to the value."""
    imgui.set_next_item_width(max(width, em(1)))
    flags = imgui.SliderFlags_.no_input | (imgui.SliderFlags_.logarithmic if logarithmic else 0)
    clear = ("frame_bg", "frame_bg_hovered", "frame_bg_active", "slider_grab", "slider_grab_active")
    for part in clear:
        imgui.push_style_color(style_color(part), theme.rgb(0, 0.0))
    changed, new = imgui.slider_float("##track", min(max(value, low), high), low, high, "", flags)
    imgui.pop_style_color(len(clear))
    held, hovered, done = imgui.is_item_active(), imgui.is_item_hovered(), imgui.is_item_deactivated_after_edit()
    _draw_track(_share(value, low, high, logarithmic), _share(default, low, high, logarithmic), held or hovered, held)
    return Held(float(new) if changed and not imgui.get_io().key_ctrl else None, done=done)


def _asks_to_type() -> bool:
    """Return whether the mouse asks for the box beside the slider: by a double click or by Ctrl."""
    return imgui.is_mouse_double_clicked(0) or (imgui.get_io().key_ctrl and imgui.is_mouse_clicked(0))


def _share(value: float, low: float, high: float, logarithmic: bool) -> float:
    """Return how far along its track a value lies, 0 to 1."""
    if logarithmic:
        low, high, value = log(low), log(high), log(max(value, 1e-9))
    return min(max((value - low) / (high - low), 0.0), 1.0)


def _draw_track(at: float, origin: float, near: bool, held: bool) -> None:
    low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
    sheet, middle, inset = imgui.get_window_draw_list(), (low.y + high.y) / 2, em(0.45)
    left, right, half = low.x + inset, high.x - inset, em(0.1)
    alpha = imgui.get_style().alpha
    x, x0 = left + at * (right - left), left + origin * (right - left)
    sheet.add_rect_filled((left, middle - half), (right, middle + half), color(theme.EDGE, alpha), half)
    sheet.add_rect_filled(
        (min(x, x0), middle - half), (max(x, x0), middle + half), color(theme.ACCENT, 0.9 * alpha), half
    )
    if 0 < origin < 1:
        sheet.add_line((x0, middle - 3 * half), (x0, middle + 3 * half), color(theme.EDGE, alpha), 1)
    sheet.add_circle_filled((x, middle), em(0.42), color(theme.LINE, 0.7 * alpha))
    sheet.add_circle_filled((x, middle), em(0.36), color(theme.ACCENT if near or held else theme.TEXT, alpha))


def number_box(
    value: float, low: float, high: float, digits: int, *, name: str = "number", width_em: float = NUMBER_EM
) -> Held:
    """Draw a box to type a number into."""
    imgui.set_next_item_width(em(width_em))
    entered, new = imgui.input_float(f"##{name}", value, 0, 0, f"%.{digits}f", imgui.InputTextFlags_.auto_select_all)
    if not imgui.is_item_deactivated_after_edit():
        return Held()
    return Held(min(max(float(new), low), high) if entered or new != value else None, done=True)


def _reset(*, shown: bool) -> bool:
    """Return whether the reset arrow was pressed; where nothing is to reset, keep its place."""
    side = imgui.get_frame_height()
    if not shown:
        imgui.dummy(ImVec2(side, side))
        return False
    with colors(button=theme.PANEL, text=theme.FAINT):
        # With its usual padding above the arrow stands on the line of the row, which is then no higher for it.
        imgui.push_style_var(imgui.StyleVar_.frame_padding, ImVec2(0, imgui.get_style().frame_padding.y))
        pressed = imgui.button(f"{icon('rotate-left')}##reset", ImVec2(side, side))
        imgui.pop_style_var()
    tip("Reset")
    return pressed
