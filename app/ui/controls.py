"""The rows that panels are built of: a label, a control, a number to type into, a reset; one look for all."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from imgui_bundle import ImVec2, imgui

from app.ui import theme
from app.ui.theme import color, em, icon

LABEL_EM, NUMBER_EM, RESET_EM = 6.2, 3.4, 1.6


@dataclass(frozen=True)
class Held:
    """What a slider says in one frame."""

    value: float | None = None
    """The new value, None where it did not change."""
    done: bool = False
    """Whether it was let go or typed in."""


@contextmanager
def colors(**codes: int) -> Iterator[None]:
    """Draw the block with some of Dear ImGui's colours changed: `text=theme.FAINT`."""
    for name, code in codes.items():
        imgui.push_style_color(int(getattr(imgui.Col_, name)), theme.rgb(code))
    try:
        yield
    finally:
        imgui.pop_style_color(len(codes))


@contextmanager
def disabled(when: bool) -> Iterator[None]:
    """Grey out the block."""
    imgui.begin_disabled(when)
    try:
        yield
    finally:
        imgui.end_disabled()


def faint(text: str) -> None:
    """Write a line that stands back."""
    with colors(text=theme.FAINT):
        imgui.text_wrapped(text)


def tip(text: str, key: str = "") -> None:
    """Explain the last item when the pointer rests on it, with the key that does the same."""
    if not text or not imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip | imgui.HoveredFlags_.allow_when_disabled):
        return
    if imgui.begin_tooltip():
        imgui.push_text_wrap_pos(em(22))
        imgui.text(text)
        if key:
            imgui.same_line(0, em(0.8))
            with colors(text=theme.ACCENT):
                imgui.text(key)
        imgui.pop_text_wrap_pos()
        imgui.end_tooltip()


def heading(text: str, glyph: str = "") -> None:
    """Begin a part of a panel."""
    imgui.dummy(ImVec2(0, em(0.1)))
    with colors(text=theme.FAINT):
        imgui.push_font(None, theme.SMALL_PX)
        imgui.text(f"{icon(glyph)}  {text.upper()}" if glyph else text.upper())
        imgui.pop_font()
    imgui.dummy(ImVec2(0, 0))


def section(text: str, *, opened: bool = True) -> bool:
    """Begin a part of a panel that folds; return whether it is open."""
    flags = imgui.TreeNodeFlags_.default_open if opened else 0
    imgui.dummy(ImVec2(0, em(0.05)))
    return imgui.collapsing_header(text, flags)


def label(text: str, hint: str = "") -> bool:
    """Write a row's label and move on to its control; return whether it was double-clicked."""
    left = imgui.get_cursor_pos_x()
    imgui.align_text_to_frame_padding()
    shown = shortened(text, em(LABEL_EM - 0.4))
    with colors(text=theme.FAINT):
        imgui.text(shown)
    tip(hint if shown == text else f"{text}\n{hint}".strip())
    reset = imgui.is_item_hovered() and imgui.is_mouse_double_clicked(0)
    imgui.same_line(left + em(LABEL_EM), 0)
    return reset


def shortened(text: str, width: float) -> str:
    """Return `text`, cut and with an ellipsis where it is wider than `width` screen pixels."""
    if imgui.calc_text_size(text).x <= width:
        return text
    kept = len(text)
    while kept and imgui.calc_text_size(f"{text[:kept].rstrip()} …").x > width:
        kept -= 1
    return f"{text[:kept].rstrip()} …"


def icon_button(
    name: str,
    glyph: str,
    *,
    on: bool = False,
    quiet: bool = False,
    hint: str = "",
    key: str = "",
    size_em: float = 2.0,
) -> bool:
    """Return whether a square button with an icon was pressed; `on` shows it chosen, `quiet` less loudly."""
    side = em(size_em)
    lit, dark = (theme.BUTTON, theme.ACCENT) if quiet else (theme.ACCENT, theme.ON_ACCENT)
    off = theme.FAINT if quiet else theme.TEXT
    imgui.push_style_color(imgui.Col_.button, theme.rgb(lit, 1.0 if on else 0.0))
    imgui.push_style_color(imgui.Col_.button_hovered, theme.rgb(lit if on else theme.BUTTON_HOVERED))
    imgui.push_style_color(imgui.Col_.text, theme.rgb(dark if on else off))
    imgui.push_style_var(imgui.StyleVar_.frame_padding, ImVec2(0, 0))
    pressed = imgui.button(f"{icon(glyph)}###{name}", ImVec2(side, side))
    imgui.pop_style_var()
    imgui.pop_style_color(3)
    tip(hint or name, key)
    return pressed


def primary_button(text: str, width_em: float = 0.0) -> bool:
    """Return whether the button that does what a dialog is for was pressed."""
    with colors(
        button=theme.ACCENT, button_hovered=theme.ACCENT_BRIGHT, button_active=theme.ACCENT, text=theme.ON_ACCENT
    ):
        return imgui.button(text, ImVec2(em(width_em), em(2.0)))


def plain_button(text: str, width_em: float = 0.0) -> bool:
    """Return whether a dialog's other button was pressed."""
    return imgui.button(text, ImVec2(em(width_em), em(2.0)))


def segments(name: str, choices: Sequence[tuple[str, str, str]], chosen: str) -> str | None:
    """Choose one of (value, label, tooltip) in a row of joined buttons; return the value that was pressed."""
    width = imgui.get_content_region_avail().x / len(choices)
    pressed: str | None = None
    imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(1, imgui.get_style().item_spacing.y))
    for number, (value, text, hint) in enumerate(choices):
        if number:
            imgui.same_line()
        on = value == chosen
        with colors(
            button=theme.ACCENT if on else theme.BUTTON,
            button_hovered=theme.ACCENT if on else theme.BUTTON_HOVERED,
            text=theme.ON_ACCENT if on else theme.TEXT,
        ):
            if imgui.button(f"{text}##{name}", ImVec2(width - 1, 0)):
                pressed = value
        tip(hint)
    imgui.pop_style_var()
    return pressed


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
    reset = label(name, f"{hint}\nDouble-click to reset." if hint else "Double-click to reset.")
    width = imgui.get_content_region_avail().x - em(NUMBER_EM + RESET_EM + 0.6)
    dragged = _track(value, low, high, default, width, logarithmic=logarithmic)
    types = imgui.is_item_hovered() and _asks_to_type()
    imgui.same_line(0, em(0.4))
    if types:
        imgui.set_keyboard_focus_here()
    typed = _number(value, low, high, digits)
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
    typed = _number(value, low, high, 0)
    if unit:
        imgui.same_line(0, em(0.3))
        with colors(text=theme.FAINT):
            imgui.text(unit)
    imgui.pop_id()
    return typed if typed.done else dragged


def _track(value: float, low: float, high: float, default: float, width: float, *, logarithmic: bool) -> Held:
    """Draw a slim slider, filled from the default to the value."""
    imgui.set_next_item_width(max(width, em(3)))
    flags = imgui.SliderFlags_.no_input | (imgui.SliderFlags_.logarithmic if logarithmic else 0)
    clear = ("frame_bg", "frame_bg_hovered", "frame_bg_active", "slider_grab", "slider_grab_active")
    for part in clear:
        imgui.push_style_color(int(getattr(imgui.Col_, part)), theme.rgb(0, 0.0))
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
        from math import log

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


def _number(value: float, low: float, high: float, digits: int) -> Held:
    """Type a number."""
    imgui.set_next_item_width(em(NUMBER_EM))
    entered, new = imgui.input_float("##number", value, 0, 0, f"%.{digits}f", imgui.InputTextFlags_.auto_select_all)
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
        imgui.push_style_var(imgui.StyleVar_.frame_padding, ImVec2(0, 0))
        pressed = imgui.button(f"{icon('rotate-left')}##reset", ImVec2(side, side))
        imgui.pop_style_var()
    tip("Reset")
    return pressed


def check(name: str, on: bool, hint: str = "", key: str = "") -> bool | None:
    """Switch something; return its new state when it was switched."""
    changed, now = imgui.checkbox(name, on)
    tip(hint, key)
    return now if changed else None
