"""What the real window takes for a frame while someone works in it: the `window` list of `weft bench`.

A script of mouse events is played to the window, one for every frame, at a display's rate: a pin is dragged, a stroke
painted, the wheel turned, and then nothing is done. Each is played twice: as the window draws, and with the draw calls
left out, which leaves the processor's part. Every frame is split by the spans that the program records anyway.
"""

import statistics
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from imgui_bundle import hello_imgui, imgui

from app.editor.editor import Editor
from app.model.jobs import Jobs
from app.model.spaces import screen_from_canvas
from app.render.picture_file import exporting
from app.tools.all import TOOLS
from app.window.shell import SWITCH_S, Shell, has_display, wake
from core import tracing
from core.arrays import Bytes, InputError
from core.document.document import Document, Pin, pixels_from_places
from core.imaging.images import Image
from core.rasters.raster import Raster

SIZE_PX = (1920, 1080)
"""Of the picture, and of the window."""
FEATURES = (4, 200)
FRAMES = 60
"""Of each of the things that are done."""
FRAME_S = 1 / 60
"""From the beginning of a frame to that of the next one, as a display has it, where it is not late."""
SETTLING_S = 60.0
"""How long the window may take at most to come to rest."""
BEND = 20.0
PINS = ((0.2, 0.45), (0.45, 0.4), (0.8, 0.6), (0.7, 0.25))
"""Places of the picture, the first of them dragged."""
PARTS = ("input", "solve", "place", "upload", "draw", "imgui")
"""What a frame is split into: what the tools do with mouse and keys, bringing the map up to date, placing the mesh,
sending nodes and texels to the GPU, the rest of drawing the picture, and the rest of the frame, in which Dear ImGui
lays out and draws what is around it."""

Events = Iterator[None]


def measure(features: Sequence[int] = FEATURES, *, frames: int = FRAMES) -> list[dict[str, Any]]:
    """Return a record for each number of features, deed and way of drawing: frames, medians and 95th percentiles.

    `ms` is by the clock, `busy_ms` what the window's own thread has used of the processor; the parts are medians of
    the latter.

    Raises
    ------
    InputError
        Where there is no display.
    """
    if not has_display():
        raise InputError("--only window: needs a display; `xvfb-run -a weft bench --only window` makes one")
    return [
        {"features": count, "draws": draws, **record}
        for count in features
        for draws in (True, False)
        for record in _in_window(count, frames, draws=draws)
    ]


def _in_window(features: int, frames: int, *, draws: bool) -> list[dict[str, Any]]:
    """Open a window and play all deeds in it."""
    with open_window(_document(features), draws=draws) as hand:
        return [_played(hand, deed, frames) for deed in ("drag", "brush", "zoom", "idle")]


@contextmanager
def open_window(document: Document, *, draws: bool = True) -> Iterator["Hand"]:
    """Open a window on a document, whose frames are drawn by whoever works in it."""
    jobs = Jobs(wake=wake)
    shell = Shell(Editor(document, TOOLS, jobs=jobs, exporter=exporting), keeps_settings=False, draws=draws)
    shell.params.app_window_params.window_geometry.size = SIZE_PX
    render, switch_before = hello_imgui.manual_render, sys.getswitchinterval()
    render.setup_from_runner_params(shell.params)
    sys.setswitchinterval(SWITCH_S)
    try:
        yield Hand(shell)
    finally:
        sys.setswitchinterval(switch_before)
        jobs.close()
        render.tear_down()


def _played(hand: "Hand", deed: str, frames: int) -> dict[str, Any]:
    """Let the window come to rest, play a deed, and return what its frames took."""
    hand.rest()
    events = {"drag": hand.drag, "brush": hand.brush, "zoom": hand.zoom, "idle": hand.idle}[deed](frames)
    next(events)
    tracing.start()
    for _ in events:
        begun = time.perf_counter()
        hand.draw()
        time.sleep(max(begun + FRAME_S - time.perf_counter(), 0.0))
    found = split_frames(tracing.events())
    hand.let_go()
    return {"deed": deed, **summarise(found)}


class Hand:
    """The mouse, and a little patience."""

    def __init__(self, shell: Shell) -> None:
        self.shell, self.editor = shell, shell.editor

    def rest(self) -> None:
        """Draw frames until nothing is left to do."""
        until = time.monotonic() + SETTLING_S
        calm = 0
        while calm < 10 and time.monotonic() < until:
            self.draw()
            is_calm = self.shell.is_drawn and self.editor.live.is_settled and self.editor.jobs.is_idle
            calm = calm + 1 if is_calm else 0
            time.sleep(0.0 if is_calm else 0.01)

    def draw(self) -> None:
        """Draw a frame."""
        hello_imgui.manual_render.render()

    def drag(self, frames: int) -> Events:
        """Move a pin along an arc."""
        self.editor.choose_tool("pins")
        start = self.on_screen(PINS[0])
        yield from self.press(start)
        for angle in np.linspace(0, np.pi, frames):
            self.move(start[0] + 60 * np.sin(angle), start[1] + 40 * (1 - np.cos(angle)))
            yield

    def brush(self, frames: int) -> Events:
        """Paint around where a pin is."""
        self.editor.choose_tool("brush")
        x, y = self.on_screen((0.5, 0.55))
        yield from self.press((x, y))
        for angle in np.linspace(0, 2 * np.pi, frames):
            self.move(x + 90 * np.sin(angle), y + 60 * (1 - np.cos(angle)))
            yield

    def zoom(self, frames: int) -> Events:
        """Turn the wheel, in and out again."""
        self.move(*self.on_screen((0.5, 0.5)))
        yield
        for number in range(frames):
            imgui.get_io().add_mouse_wheel_event(0.0, 0.5 if number < frames // 2 else -0.5)
            yield

    def idle(self, frames: int) -> Events:
        """Do nothing."""
        for _ in range(frames + 1):
            yield

    def let_go(self) -> None:
        """Release the button."""
        imgui.get_io().add_mouse_button_event(0, False)
        hello_imgui.manual_render.render()

    def press(self, place: tuple[float, float]) -> Events:
        """Move there, press, and show that; the first stop is before any of it counts."""
        self.move(*place)
        hello_imgui.manual_render.render()
        imgui.get_io().add_mouse_button_event(0, True)
        hello_imgui.manual_render.render()
        yield

    def move(self, x: float, y: float) -> None:
        """Move the pointer to a place of the canvas's widget."""
        imgui.get_io().add_mouse_pos_event(*self.shell.workspace.canvas.area.in_window(x, y))

    def on_screen(self, place: tuple[float, float]) -> tuple[float, float]:
        """Return where a place of the canvas is, in pixels of the canvas's widget."""
        pixels = pixels_from_places(self.editor.canvas_px, np.array([place]))
        x, y = screen_from_canvas(self.editor.session.view, pixels)[0].tolist()
        return x, y


def _document(features: int) -> Document:
    """Return a picture with so many discs painted, under a swirl, with pins."""
    width, height = SIZE_PX
    noise = np.random.default_rng(0).integers(0, 256, (height // 8, width // 8, 3), dtype=np.uint8)
    pixels = np.asarray(cv2.resize(noise, SIZE_PX, interpolation=cv2.INTER_CUBIC), np.uint8)
    document = Document.of(Image(pixels)).with_warp(preset="swirl", bend=BEND)
    pins = tuple(Pin(place, place) for place in PINS)
    return document.changed(mask=Raster.from_array(discs(features)), pins=pins)


def discs(count: int) -> Bytes:
    """Return a mask with so many discs in rows, that cover an eighth of the picture together."""
    width, height = SIZE_PX
    columns = max(round(np.sqrt(count * width / height)), 1)
    rows = -(-count // columns)
    radius = round(np.sqrt(width * height / 8 / count / np.pi))
    mask = np.zeros((height, width), np.uint8)
    for number in range(count):
        row, column = divmod(number, columns)
        cv2.circle(mask, (round((column + 0.5) * width / columns), round((row + 0.5) * height / rows)), radius, 255, -1)
    return mask


@dataclass(frozen=True)
class Frame:
    """What one frame took, in milliseconds."""

    ms: float
    busy_ms: float
    parts: Mapping[str, float]
    """Of `busy_ms`, by name."""


def split_frames(events: Sequence[Mapping[str, Any]]) -> list[Frame]:
    """Return every frame that `core.tracing` has recorded, split into `PARTS`."""
    frames = [event for event in events if event["name"] == "frame"]
    return [_split(frame, [event for event in events if _is_within(event, frame)]) for frame in frames]


def _is_within(event: Mapping[str, Any], frame: Mapping[str, Any]) -> bool:
    started = frame["ts"] <= event["ts"] and event["ts"] + event["dur"] <= frame["ts"] + frame["dur"]
    return bool(started and event["tid"] == frame["tid"] and event is not frame)


def _split(frame: Mapping[str, Any], within: Sequence[Mapping[str, Any]]) -> Frame:
    """Split a frame by the spans within it; sending nodes is a part of placing the mesh, and both of the canvas."""

    def taken(name: str, **arguments: object) -> float:
        chosen = [event for event in within if event["name"] == name and arguments.items() <= event["args"].items()]
        return float(sum(event["tdur"] for event in chosen)) / 1e3

    busy, upload = frame["tdur"] / 1e3, taken("upload")
    found = {
        "input": taken("event"),
        "solve": taken("update"),
        "place": taken("place") - taken("upload", what="nodes"),
        "upload": upload,
    }
    found["draw"] = taken("canvas") - found["place"] - upload
    return Frame(frame["dur"] / 1e3, busy, {**found, "imgui": busy - sum(found.values())})


def summarise(frames: Sequence[Frame]) -> dict[str, Any]:
    """Return how many frames there were, and what they took."""
    return {
        "frames": len(frames),
        "ms": _median([frame.ms for frame in frames]),
        "p95_ms": _late([frame.ms for frame in frames]),
        "busy_ms": _median([frame.busy_ms for frame in frames]),
        "busy_p95_ms": _late([frame.busy_ms for frame in frames]),
        "parts": {name: _median([frame.parts[name] for frame in frames]) for name in PARTS},
    }


def _median(values: Sequence[float]) -> float:
    return statistics.median(values) if values else 0.0


def _late(values: Sequence[float]) -> float:
    """Return the 95th percentile."""
    return float(np.percentile(values, 95)) if values else 0.0
