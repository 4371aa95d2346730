"""What panels and bars are built of: labels, tooltips, sections, buttons, switches; one look for all."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache

from imgui_bundle import ImVec2, imgui

from app.ui.widgets import theme
from app.ui.widgets.fallback_fonts import writable
from app.ui.widgets.theme import em, icon
from core.files.text import begin_sentence

LABEL_EM, ROW_EM = 6.2, 15.5
"""Width of a row's label, and of the row that is wide enough for it; in a narrower one the label is shorter too."""

NARROW_EM = 12.5
"""In a row that is narrower than this the label stands over its control."""


HOVERED = int(imgui.HoveredFlags_.allow_when_disabled)
LONG_HOVERED = HOVERED | int(imgui.HoveredFlags_.for_tooltip)


@cache
def style_color(name: str) -> int:
    """Return the number of a colour of Dear ImGui's style."""
    return int(getattr(imgui.Col_, name))


@contextmanager
def colors(**codes: int) -> Iterator[None]:
    """Draw the block with some of Dear ImGui's colours changed: `text=theme.FAINT`."""
    for name, code in codes.items():
        imgui.push_style_color(style_color(name), theme.rgb(code))
    try:
        yield
    finally:
        imgui.pop_style_color(len(codes))


def faint(text: str) -> None:
    """Write a line that stands back."""
    with colors(text=theme.FAINT):
        imgui.text_wrapped(writable(text))


def fault(text: str) -> None:
    """Say what is wrong, as a sentence."""
    with colors(text=theme.FAULT):
        imgui.text_wrapped(f"{begin_sentence(text)}.")


@contextmanager
def disabled(now: bool) -> Iterator[None]:
    """Grey out what is drawn inside, where that is so `now`."""
    imgui.begin_disabled(now)
    yield
    imgui.end_disabled()


@contextmanager
def at_least(*texts: str) -> Iterator[None]:
    """Give the block the height of the highest of `texts`, so that what follows stays in its place.

    They are wrapped as `faint` wraps them; at a line break a new line of its own begins.
    """
    room, top, gap = imgui.get_content_region_avail().x, imgui.get_cursor_pos_y(), imgui.get_style().item_spacing.y
    high = max(imgui.calc_text_size(text, wrap_width=room).y + gap * text.count("\n") for text in texts)
    yield
    bottom = imgui.get_cursor_pos_y() - gap
    if bottom < top + high:
        imgui.set_cursor_pos_y(bottom)
        imgui.dummy(ImVec2(0, top + high - bottom))


class Hinted:
    """What the item under the pointer is, for the status bar: said at once, while its tooltip waits."""

    text = ""
    """Of this frame so far."""

    @classmethod
    def take(cls) -> str:
        """Return what was said since the last call."""
        text, cls.text = cls.text, ""
        return text


def end_popup() -> None:
    """End a popup; Escape closes it."""
    if imgui.is_key_pressed(imgui.Key.escape):
        imgui.close_current_popup()
    imgui.end_popup()


def tip(text: str, key: str = "") -> None:
    """Explain the last item when the pointer rests on it, with the key that does the same."""
    if not text or not imgui.is_item_hovered(HOVERED):
        return
    Hinted.text = " · ".join([*text.split("\n"), *([key] if key else [])])
    if not imgui.is_item_hovered(LONG_HOVERED):
        return
    at = imgui.get_window_pos()
    if at.x > imgui.get_main_viewport().get_center().x:
        # Beside a panel: over it, what the panel says of a button that was pressed could not be read.
        beside = ImVec2(at.x - em(0.5), imgui.get_item_rect_min().y)
        imgui.set_next_window_pos(beside, imgui.Cond_.always, ImVec2(1, 0))
    if imgui.begin_tooltip():
        imgui.push_text_wrap_pos(em(22))
        imgui.text(writable(text))
        imgui.pop_text_wrap_pos()
        if key:
            if imgui.calc_text_size(text).x < em(18):
                imgui.same_line(0, em(0.8))
            with colors(text=theme.ACCENT):
                imgui.text(key)
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


def is_narrow() -> bool:
    """Return whether the row that begins here has no room for a label beside its control."""
    return imgui.get_content_region_avail().x < em(NARROW_EM)


def label(text: str, hint: str = "", *, beside_em: float = 0.0) -> bool:
    """Write a row's label and move on to its control; return whether it was double-clicked.

    In a narrow row the control comes below; the label then leaves room for what is `beside_em` wide.
    """
    left, room, narrow = imgui.get_cursor_pos_x(), imgui.get_content_region_avail().x, is_narrow()
    imgui.align_text_to_frame_padding()
    width = room - em(beside_em) if narrow else em(LABEL_EM) * min(room / em(ROW_EM), 1)
    shown = shorten(text, width - em(0.4))
    with colors(text=theme.FAINT):
        imgui.text(shown)
    tip(hint if shown == text else f"{text}\n{hint}".strip())
    reset = imgui.is_item_hovered() and imgui.is_mouse_double_clicked(0)
    if not narrow:
        imgui.same_line(left + width, 0)
    return reset


def shorten(text: str, width: float, *, keeps_end: bool = False) -> str:
    """Return `text`, cut and with an ellipsis where it is wider than `width` screen pixels."""
    text = writable(text)
    if imgui.calc_text_size(text).x <= width:
        return text
    cuts = (f"… {text[-n:].lstrip()}" if keeps_end else f"{text[:n].rstrip()} …" for n in range(len(text) - 1, 0, -1))
    return next((cut for cut in cuts if imgui.calc_text_size(cut).x <= width), "…")


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


def move_right(*widths_em: float) -> None:
    """Go on in the same line so far right that buttons of these widths end with the window's content."""
    style = imgui.get_style()
    room = sum(em(width) for width in widths_em) + (len(widths_em) - 1) * style.item_spacing.x
    bar = style.scrollbar_size if imgui.get_scroll_max_y() > 0 else 0
    imgui.same_line(imgui.get_window_width() - room - style.window_padding.x - bar)


def segments(name: str, choices: Sequence[tuple[str, str, str]], chosen: str) -> str | None:
    """Choose one of (value, label, tooltip) in a row of joined buttons; return the value that was pressed.

    They have one width, or where a label is longer each its label's and an even share of the rest.
    """
    texts = [imgui.calc_text_size(text).x for _, text, _ in choices]
    room = imgui.get_content_region_avail().x
    even = room / len(choices)
    widths = [even if max(texts) < even - em(0.4) else text + (room - sum(texts)) / len(choices) for text in texts]
    pressed: str | None = None
    imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(1, imgui.get_style().item_spacing.y))
    imgui.push_style_var(imgui.StyleVar_.frame_padding, ImVec2(0, imgui.get_style().frame_padding.y))
    for number, (value, text, hint) in enumerate(choices):
        if number:
            imgui.same_line()
        if toggle_button(f"{text}##{name}", widths[number] - 1, on=value == chosen):
            pressed = value
        tip(hint)
    imgui.pop_style_var(2)
    return pressed


def toggle_button(name: str, width: float, *, on: bool) -> bool:
    """Return whether a button was pressed that is lit while it is `on`; it is `width` screen pixels wide."""
    with colors(
        button=theme.ACCENT if on else theme.BUTTON,
        button_hovered=theme.ACCENT if on else theme.BUTTON_HOVERED,
        text=theme.ON_ACCENT if on else theme.TEXT,
    ):
        return imgui.button(name, ImVec2(width, 0))


def check(name: str, on: bool, hint: str = "", key: str = "") -> bool | None:
    """Switch something; return its new state when it was switched."""
    changed, now = imgui.checkbox(name, on)
    tip(hint, key)
    return now if changed else None
