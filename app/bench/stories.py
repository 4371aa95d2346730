"""The longest frames of five whole jobs in the real window: the `stories` list of `weft bench`.

People in a resized picture, letters on a flag, a wing lifted by two pins, a label on a mug, one feature rigid and one
similar; each up to the exported file. A step is what a hand does and all frames until the window is at rest again, with
draw calls as usual. A frame of over 100 ms is a stall.
"""

import itertools
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import cv2
import numpy as np

from app.bench.window import SIZE_PX, Frame, Hand, discs, open_window, split_frames
from app.files.document_io import export
from app.marking.applying import select
from app.marking.feature_list import rows_of, say
from app.marking.resizing import resize, with_ratio
from app.model.requests import ExportOptions
from app.window.shell import has_display
from core import tracing
from core.arrays import Bytes, InputError
from core.document.document import Document
from core.imaging.images import Image
from core.selection.shapes import ellipse_outline, fill_polygon

STALL_MS = 100.0
Step: TypeAlias = tuple[str, Callable[[Hand], object]]


def measure(stories: Sequence[str] = (), *, frames: int = 40) -> list[dict[str, Any]]:
    """Return a record for each step of each story: how many frames, the longest, and how many were stalls.

    `longest_ms` is by the clock, `longest_busy_ms` what the window's own thread used of the processor in a frame. A
    drag has so many `frames`. Without `stories` it is all of them.

    Raises
    ------
    InputError
        Where there is no display.
    """
    if not has_display():
        raise InputError("--only stories: needs a display; `xvfb-run -a weft bench --only stories` makes one")
    return [record for story in stories or STORIES for record in _tell(story, frames)]


def _tell(story: str, frames: int) -> Iterator[dict[str, Any]]:
    """Tell a story in a window of its own."""
    document, steps = STORIES[story](frames)
    with open_window(document) as hand, tempfile.TemporaryDirectory() as folder:
        hand.rest()
        path = Path(folder) / f"{story}.png"
        for name, deed in [*steps, ("export", lambda hand: _export(hand, path))]:
            tracing.start()
            deed(hand)
            hand.rest()
            yield {"story": story, "step": name, **find_longest(split_frames(tracing.events()))}


def find_longest(frames: list[Frame]) -> dict[str, Any]:
    """Return how many frames there were, the longest of them, and how many were stalls."""
    return {
        "frames": len(frames),
        "longest_ms": max((frame.ms for frame in frames), default=0.0),
        "longest_busy_ms": max((frame.busy_ms for frame in frames), default=0.0),
        "stalls": sum(frame.ms > STALL_MS for frame in frames),
    }


def _export(hand: Hand, path: Path) -> None:
    export(hand.editor, ExportOptions(path, hand.editor.document.result_px))


def _act(name: str) -> Callable[[Hand], object]:
    """Return what runs an action, as its menu or key does."""
    return lambda hand: hand.shell.workspace.table.run(name, hand.editor)


def _drag(tool: str, *places: tuple[float, float], frames: int) -> Callable[[Hand], None]:
    """Return what drags a tool from place to place of the canvas, as shares of its sides."""

    def deed(hand: Hand) -> None:
        hand.editor.choose_tool(tool)
        hand.draw()
        stops = [
            hand.on_screen(place) for place in places
        ]  # of the canvas as it is now: what is dragged may be its edge
        for _ in hand.press(stops[0]):
            hand.draw()
        for start, end in itertools.pairwise(stops):
            for share in np.linspace(0, 1, frames):
                hand.move(*np.add(start, share * np.subtract(end, start)).tolist())
                hand.draw()
        hand.let_go()

    return deed


def _click(tool: str, place: tuple[float, float]) -> Callable[[Hand], None]:
    return _drag(tool, place, frames=0)


def _slide(frames: int) -> Callable[[Hand], None]:
    """Return what drags the slider of the bend."""

    def deed(hand: Hand) -> None:
        for bend in np.linspace(0, 60, frames):
            hand.editor.slide("Bend", hand.editor.document.with_warp(bend=float(bend)))
            hand.draw()
        hand.editor.finish()

    return deed


def _picture(*ellipses: tuple[float, float, float, float, tuple[int, int, int]]) -> Document:
    """Return a sky over sand with coloured ellipses: centre and half axes as shares of the picture, and a colour."""
    width, height = SIZE_PX
    noise = np.random.default_rng(0).normal(0, 6, (height, width, 1))
    ground = np.where(np.arange(height)[:, None, None] < 0.4 * height, (150, 180, 210), (210, 190, 150))
    pixels = np.clip(ground + noise, 0, 255).astype(np.uint8)
    for x, y, a, b, colour in ellipses:
        box = round(x * width), round(y * height)
        cv2.ellipse(pixels, box, (round(a * width), round(b * height)), 0, 0, 360, colour, -1)
    return Document.of(Image(pixels))


def _people(frames: int) -> tuple[Document, list[Step]]:
    red, blue = (190, 60, 50), (60, 60, 160)
    document = _picture((0.35, 0.6, 0.05, 0.22, red), (0.55, 0.55, 0.05, 0.26, blue))
    square: Callable[[Hand], None] = lambda hand: resize(hand.editor, with_ratio(SIZE_PX, 1.0))  # noqa: E731
    steps: list[Step] = [
        ("square, with a proposal", square),
        ("paint", _drag("brush", (0.3, 0.9), (0.4, 0.92), frames=frames)),
        ("drag the frame", _drag("resize", (1.0, 0.5), (0.8, 0.5), frames=frames)),
    ]
    return document, steps


def _letters(frames: int) -> tuple[Document, list[Step]]:
    width, height = SIZE_PX
    pixels = np.zeros((height, width, 4), np.uint8)
    for number, letter in enumerate("LETTER"):
        place = 100 + 300 * number, height // 2 + 140
        cv2.putText(pixels, letter, place, cv2.FONT_HERSHEY_DUPLEX, 12.0, (200, 60, 30, 255), 40)
    steps: list[Step] = [
        ("from transparency", _act("mask.transparency")),
        ("flag", _act("warp.preset.flag")),
        ("drag the bend", _slide(frames)),
    ]
    return Document.of(Image(pixels)), steps


def _wing(frames: int) -> tuple[Document, list[Step]]:
    document = _picture((0.4, 0.6, 0.12, 0.32, (40, 40, 50)), (0.63, 0.6, 0.14, 0.05, (30, 120, 60)))
    steps: list[Step] = [
        ("wand", _click("wand", (0.68, 0.6))),
        ("shoulder", _click("pins", (0.54, 0.6))),
        ("tip", _click("pins", (0.75, 0.6))),
        ("lift", _drag("pins", (0.75, 0.6), (0.73, 0.42), frames=frames)),
    ]
    return document, steps


def _label(frames: int) -> tuple[Document, list[Step]]:
    steps: list[Step] = [
        ("select", lambda hand: select(hand.editor, "ellipse", _round(0.5, 0.5, 0.2), "add")),
        ("cylinder", _act("surface.cylinder")),
        ("paint", _drag("brush", (0.3, 0.8), (0.6, 0.85), frames=frames)),
    ]
    return _picture((0.5, 0.5, 0.12, 0.2, (190, 60, 50))), steps


def _two(frames: int) -> tuple[Document, list[Step]]:
    def keep(hand: Hand) -> None:
        say(hand.editor, "Keep feature as", frozenset({rows_of(hand.editor)[0].id}), keep="rigid")

    steps: list[Step] = [
        ("select", lambda hand: select(hand.editor, "mask", discs(2), "add")),
        ("rigid", keep),
        ("drag the frame", _drag("resize", (1.0, 0.5), (0.7, 0.5), frames=frames)),
    ]
    return _picture(), steps


def _round(x: float, y: float, radius: float) -> Bytes:
    """Return the mask of a disc, in shares of the picture's height."""
    width, height = SIZE_PX
    centre, arm = np.array([x * width, y * height]), radius * height
    return fill_polygon(SIZE_PX, ellipse_outline(centre - arm, centre + arm))


STORIES: dict[str, Callable[[int], tuple[Document, list[Step]]]] = {
    "people": _people,
    "letters": _letters,
    "wing": _wing,
    "label": _label,
    "rigid and similar": _two,
}
"""What makes the picture and the steps of each."""
