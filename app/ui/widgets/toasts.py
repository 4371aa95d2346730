"""Messages that come up over the canvas and go by themselves; faults stay longer, and go at a click.

A fault goes only once the pointer has moved: a long job may fail while nobody is there.
"""

from dataclasses import dataclass
from math import inf

from imgui_bundle import ImVec2, imgui

from app.editor.editor import Editor
from app.editor.errands import Notice
from app.ui.canvas.input import Area
from app.ui.widgets import theme
from app.ui.widgets.controls import colors, icon_button
from app.ui.widgets.fallback_fonts import writable
from app.ui.widgets.theme import em, icon, rgb

SECONDS = {"info": 4.0, "error": 12.0}
FADE_S = 0.3


@dataclass
class Toast:
    """A notice and until when it shows, in seconds of Dear ImGui's clock."""

    notice: Notice
    ends: float


class Toasts:
    """The notices that show at present."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._shown: list[Toast] = []

    @property
    def texts(self) -> tuple[str, ...]:
        """What can be read at present, the oldest first."""
        return tuple(toast.notice.text for toast in self._shown)

    def draw(self, area: Area) -> float | None:
        """Draw them at the canvas's lower edge; return seconds until something is to change."""
        now = imgui.get_time()
        for notice in self._editor.notices:
            self._shown = [toast for toast in self._shown if toast.notice != notice]
            self._shown.append(Toast(notice, inf if notice.level == "error" else now + SECONDS[notice.level]))
        self._editor.notices.clear()
        moved = imgui.get_io().mouse_delta
        if (moved.x, moved.y) != (0, 0) or imgui.is_any_mouse_down():
            for toast in self._shown:
                toast.ends = min(toast.ends, now + SECONDS[toast.notice.level])
        self._shown = [toast for toast in self._shown[-4:] if toast.ends > now and toast.notice.still_holds]
        bottom = area.y + area.height - em(1)
        for number, toast in reversed(list(enumerate(self._shown))):
            bottom = self._draw_one(number, toast, area, bottom, now) - em(0.5)
        if not self._shown:
            return None
        least = min(toast.ends for toast in self._shown) - now
        if least == inf:
            return None
        return 0.0 if least < FADE_S else least - FADE_S

    def _draw_one(self, number: int, toast: Toast, area: Area, bottom: float, now: float) -> float:
        """Draw one above `bottom` and return its upper edge."""
        fault = toast.notice.level == "error"
        imgui.set_next_window_pos(ImVec2(area.x + area.width / 2, bottom), imgui.Cond_.always, ImVec2(0.5, 1))
        imgui.push_style_var(imgui.StyleVar_.alpha, min((toast.ends - now) / FADE_S, 1.0))
        imgui.push_style_var(imgui.StyleVar_.window_border_size, 1.0)
        imgui.push_style_color(imgui.Col_.window_bg, rgb(theme.RAISED, 0.97))
        imgui.push_style_color(imgui.Col_.border, rgb(theme.FAULT if fault else theme.EDGE))
        flags = imgui.WindowFlags_.no_decoration | imgui.WindowFlags_.always_auto_resize
        flags |= imgui.WindowFlags_.no_docking | imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_move
        imgui.begin(f"##toast{number}", None, flags | imgui.WindowFlags_.no_focus_on_appearing)
        with colors(text=theme.FAULT if fault else theme.ACCENT):
            imgui.align_text_to_frame_padding()
            imgui.text(icon("triangle-exclamation" if fault else "circle-info"))
        imgui.same_line()
        imgui.push_text_wrap_pos(min(max(area.width * 0.7, em(16)), em(40)))
        imgui.text(writable(toast.notice.text))
        imgui.pop_text_wrap_pos()
        imgui.same_line(0, em(1))
        if icon_button(f"close toast {number}", "xmark", hint="Dismiss", size_em=1.5):
            toast.ends = now
        top = imgui.get_window_pos().y
        imgui.end()
        imgui.pop_style_color(2)
        imgui.pop_style_var(2)
        return top
