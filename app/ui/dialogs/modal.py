"""What lies over the window and holds it until it is closed: never larger than it, nor beyond its edge."""

from collections.abc import Iterator
from contextlib import contextmanager

from imgui_bundle import ImVec2, imgui

from app.ui.widgets.theme import em, ems

LEAST_EM = 24
"""No dialog is narrower; what it holds is laid out in this width in the frame that it opens in."""
SETTLING_FRAMES = 3
"""So many frames after it has opened, a window has the size of what it holds."""


@contextmanager
def modal(title: str) -> Iterator[bool]:
    """Open the popup called `title` where it is not open yet; yield whether its inside is to be drawn.

    It is put in the middle of the window as it opens and where that or the text gets another size, and stays there
    whatever it holds then.
    """
    kept, frames, width = imgui.get_state_storage(), imgui.get_id(f"{title}##frames"), imgui.get_id(f"{title}##width")
    viewport = imgui.get_main_viewport()
    if not imgui.is_popup_open(title):
        imgui.open_popup(title)
        kept.set_int(frames, 0)
    elif kept.get_int(width) != round(100 * viewport.size.x / em(1)):
        kept.set_int(frames, 0)
    kept.set_int(width, round(100 * viewport.size.x / em(1)))
    age = kept.get_int(frames)
    if age < SETTLING_FRAMES:
        imgui.set_next_window_pos(viewport.get_center(), imgui.Cond_.always, ImVec2(0.5, 0.5))
        kept.set_int(frames, age + 1)
    imgui.set_next_window_size(ImVec2(within(LEAST_EM), 0), imgui.Cond_.appearing)
    imgui.set_next_window_size_constraints(ImVec2(0, 0), ImVec2(viewport.size.x - em(1), viewport.size.y - em(1)))
    imgui.push_style_var(imgui.StyleVar_.window_padding, ems(1.2, 0.9))
    flags = imgui.WindowFlags_.always_auto_resize | imgui.WindowFlags_.no_saved_settings
    shown = imgui.begin_popup_modal(title, None, flags)[0]
    yield shown
    if shown:
        _stay_inside(viewport.size)
        imgui.end_popup()
    imgui.pop_style_var()


def is_confirmed() -> bool:
    """Return whether Enter is pressed in the present dialog: not held, nor by the press that opened it."""
    keys = (imgui.Key.enter, imgui.Key.keypad_enter)
    return not imgui.is_window_appearing() and any(imgui.is_key_pressed(key, False) for key in keys)


def _stay_inside(room: ImVec2) -> None:
    """Move the present window back where some of it, dragged or grown, lies beyond the window's edge.

    Its content must be drawn by then: what is drawn after a move has the wrong width.
    """
    place, size = imgui.get_window_pos(), imgui.get_window_size()
    x, y = (max(min(place.x, room.x - size.x), 0), max(min(place.y, room.y - size.y), 0))
    if (x, y) != (place.x, place.y):
        imgui.set_window_pos(ImVec2(x, y))


def within(width_em: float) -> float:
    """Return `width_em` in screen pixels, or what the window has room for."""
    return min(em(width_em), imgui.get_main_viewport().size.x - em(5))


def within_height(height_em: float, around_em: float) -> float:
    """Return `height_em` in screen pixels, or what the window has room for beside `around_em` over and below it."""
    return max(min(em(height_em), imgui.get_main_viewport().size.y - em(around_em)), em(5))
