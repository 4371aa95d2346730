"""Turns what Dear ImGui saw of mouse and keyboard into `app.model.events`, for the canvas."""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from imgui_bundle import imgui

from app.model.events import Button, Event, Key, KeyUp, Modifiers, Move, Position, Press, Release, Wheel


@dataclass(frozen=True)
class Area:
    """Where the canvas lies in the window, in pixels of the window."""

    x: float
    y: float
    width: float
    height: float
    unit: float = 1.0
    """Pixels of the window per screen pixel of the canvas (`app.model.spaces`)."""

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in screen pixels of the canvas."""
        return self.width / self.unit, self.height / self.unit

    def on_canvas(self, x: float, y: float) -> Position:
        """Return the place on the canvas, in its screen pixels, of a place of the window."""
        return (x - self.x) / self.unit, (y - self.y) / self.unit

    def in_window(self, x: float, y: float) -> Position:
        """Return the place in the window of a place on the canvas, in its screen pixels."""
        return self.x + x * self.unit, self.y + y * self.unit

    def holds(self, x: float, y: float) -> bool:
        """Whether a place of the window is on the canvas."""
        return self.x <= x < self.x + self.width and self.y <= y < self.y + self.height


_NAMED = {
    "left_arrow": "left",
    "right_arrow": "right",
    "up_arrow": "up",
    "down_arrow": "down",
    "page_up": "pageup",
    "page_down": "pagedown",
    "home": "home",
    "end": "end",
    "delete": "delete",
    "backspace": "backspace",
    "space": "space",
    "tab": "tab",
    "enter": "enter",
    "keypad_enter": "enter",
    "escape": "escape",
    "apostrophe": "'",
    "comma": ",",
    "minus": "-",
    "keypad_subtract": "-",
    "period": ".",
    "slash": "/",
    "semicolon": ";",
    "equal": "=",
    "keypad_add": "+",
    "left_bracket": "[",
    "right_bracket": "]",
    "backslash": "\\",
    "grave_accent": "`",
}

KEYS: dict[imgui.Key, str] = (
    {getattr(imgui.Key, name): text for name, text in _NAMED.items()}
    | {getattr(imgui.Key, letter): letter for letter in "abcdefghijklmnopqrstuvwxyz"}
    | {getattr(imgui.Key, f"_{digit}"): digit for digit in "0123456789"}
    | {getattr(imgui.Key, f"keypad{digit}"): digit for digit in "0123456789"}
    | {getattr(imgui.Key, f"f{number}"): f"f{number}" for number in range(1, 13)}
)
"""Names of the keys as `app.model.events` and the action table call them."""

MOST_WAY = 24
"""At most so many places on the way are looked at in one frame."""
WAY_PX = 3.0
"""And none so close to the one before."""
WAY_S = 0.012
"""What they may take of a frame: with a large brush they are fewer."""
BUTTONS: tuple[tuple[int, Button], ...] = ((0, "left"), (2, "middle"), (1, "right"))


def modifiers() -> Modifiers:
    """Return which modifier keys are held; the Mac's command key counts as Ctrl."""
    io = imgui.get_io()
    return Modifiers(shift=io.key_shift, ctrl=io.key_ctrl or io.key_super, alt=io.key_alt)


def space_out(trail: Sequence[Position], start: Position | None, most: int = MOST_WAY) -> list[Position]:
    """Return at most so many of the places of `trail` that say where it goes, seen from `start`; none too close."""
    kept: list[Position] = []
    before = start
    for place in trail:
        if before is None or math.dist(before, place) >= WAY_PX:
            kept.append(place)
            before = place
    return kept[:: -(-len(kept) // most)] if kept else []


class Pointer:
    """Follows the mouse from press to release, also when it leaves the canvas meanwhile."""

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._place_s = 0.0
        """What a place on the way takes."""
        self._held: int | None = None
        self._last: Position | None = None
        self.trail: list[Position] = []
        """Where the mouse has been since the last frame, in pixels of the window; whoever hears of it adds to this."""

    def events(self, area: Area) -> Iterator[Event]:
        """Yield what the mouse did since the last frame, in screen pixels of the canvas."""
        io = imgui.get_io()
        pos = area.on_canvas(io.mouse_pos.x, io.mouse_pos.y)
        over = not io.want_capture_mouse and area.holds(io.mouse_pos.x, io.mouse_pos.y)
        mods = modifiers()
        yield from self._way(area, mods)
        if pos != self._last and (over or self._held is not None):
            self._last = pos
            yield Move(pos, mods)
        if self._held is not None and not imgui.is_mouse_down(self._held):
            self._held = None
            yield Release(pos, mods)
        if over:
            yield from self._presses(pos, mods)
            if io.mouse_wheel:
                yield Wheel(pos, io.mouse_wheel, mods)

    def _way(self, area: Area, mods: Modifiers) -> Iterator[Event]:
        """Yield the places on the way while a button is held, so that a fast stroke is as smooth as the hand."""
        trail, self.trail = self.trail[:-1], []
        if self._held is not None and imgui.is_mouse_down(self._held):
            start = self._last and area.in_window(*self._last)
            most = min(max(int(WAY_S / max(self._place_s, 1e-6)), 1), MOST_WAY)
            for x, y in space_out(trail, start, most):
                started = self._clock()
                yield Move(area.on_canvas(x, y), mods)
                self._place_s = (self._place_s + self._clock() - started) / 2

    @property
    def is_held(self) -> bool:
        """Whether a button that went down on the canvas is down."""
        return self._held is not None

    def _presses(self, pos: Position, mods: Modifiers) -> Iterator[Event]:
        for number, button in BUTTONS:
            if self._held is None and imgui.is_mouse_clicked(number):
                self._held = number
                yield Press(pos, button, mods, clicks=max(imgui.get_mouse_clicked_count(number), 1))


def awaits_more() -> bool:
    """Return whether there is input for further frames: Dear ImGui takes one press of a key, or none, in a frame."""
    return len(imgui.get_current_context().input_events_queue) > 0


class Chords:
    """Which modifiers were held when keys went down.

    A chord that is struck and let go within one slow frame is the same chord, and so is one that is struck several
    times before the next frame, of which Dear ImGui tells in as many frames.
    """

    def __init__(self) -> None:
        self._heard: list[Modifiers] = []
        self._may_be_down = False
        """Whether a key may be down, and repeat itself."""

    def hear(self, held: Modifiers) -> None:
        """Take note of what was held when a key went down."""
        self._heard.append(held)

    def take(self) -> Modifiers:
        """Return what was held when the keys of this frame went down; once a frame."""
        if not self._heard:
            return modifiers()
        count = sum(imgui.is_key_pressed(code, False) for code in KEYS)
        of_frame, self._heard = self._heard[:count], self._heard[count:] if awaits_more() else []
        return of_frame[0] if len(set(of_frame)) == 1 else modifiers()

    def events(self, held_at_press: Modifiers) -> Iterator[Key | KeyUp]:
        """Yield the keys that went down, with what was held then, or up; none while a text field takes them."""
        heard = imgui.get_current_context().input_events_trail
        if not self._may_be_down and all(event.type != imgui.internal.InputEventType.key for event in heard):
            return  # to ask for every key would take as long as a panel
        self._may_be_down = imgui.get_io().want_text_input or any(imgui.is_key_down(code) for code in KEYS)
        if imgui.get_io().want_text_input:
            return
        mods = modifiers()
        for code, name in KEYS.items():
            if imgui.is_key_pressed(code, True):
                is_new = imgui.is_key_pressed(code, False)
                yield Key(name, held_at_press) if is_new else Key(name, mods, repeated=True)
            if imgui.is_key_released(code):
                yield KeyUp(name)
