"""What tools with points to grip share: finding the point under the pointer, clicks against drags, held axes."""

from collections.abc import Generator

import numpy as np

from app.editor.editor import Editor
from app.model.events import Event, Key, Move, Position
from app.model.spaces import canvas_from_screen, screen_from_canvas
from core.arrays import Ints, Points
from core.document.document import pixels_from_places, places_from_pixels

REACH_PX = 9.0
"""A point is gripped from so far away."""
CLICK_PX = 3.0
"""A pointer that moved no farther since the press has clicked."""

NUDGES = {"left": (-1, 0), "right": (1, 0), "up": (0, -1), "down": (0, 1)}
FAR_NUDGE = 10
"""Canvas pixels of a nudge with Shift."""


def nudge_px(key: Key) -> Points | None:
    """Return the canvas pixels (2,) by which an arrow key moves what is selected; None for other keys."""
    if key.name not in NUDGES or key.mods.ctrl or key.mods.alt:
        return None
    return np.array(NUDGES[key.name], float) * (FAR_NUDGE if key.mods.shift else 1)


def nearest(points: Points, pos: Position, *, reach_px: float = REACH_PX) -> int | None:
    """Return the number of the point (n, 2) nearest to `pos`, the last of equals; None if none is within reach."""
    if not len(points):
        return None
    away = np.hypot(*(points - pos).T)
    best = len(away) - 1 - int(np.argmin(away[::-1]))
    return best if away[best] <= reach_px else None


def within(points: Points, a: Position, b: Position) -> Ints:
    """Return the numbers of the points (n, 2) in the rectangle with corners `a` and `b`."""
    low, high = np.minimum(a, b), np.maximum(a, b)
    return np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))


def held_to_axis(start: Position, pos: Position) -> Position:
    """Return `pos` moved onto the horizontal or the vertical through `start`, whichever is nearer."""
    across, down = abs(pos[0] - start[0]), abs(pos[1] - start[1])
    return (pos[0], start[1]) if across >= down else (start[0], pos[1])


def is_click(start: Position, pos: Position) -> bool:
    """Return whether the pointer has hardly moved."""
    return bool(np.hypot(pos[0] - start[0], pos[1] - start[1]) <= CLICK_PX)


def drag_from(start: Position) -> Generator[None, Event, Move | None]:
    """Wait until the pointer has really moved and return that move; None if it was a click."""
    while isinstance(event := (yield), Move):
        if not is_click(start, event.pos):
            return event
    return None


def aim(start: Position, move: Move) -> Position:
    """Return where a move leads, on an axis through `start` while Shift is held."""
    return held_to_axis(start, move.pos) if move.mods.shift else move.pos


def screen_from_places(editor: Editor, places: Points) -> Points:
    """Return screen positions of normalised places (n, 2) on the canvas."""
    pixels = pixels_from_places(editor.canvas_px, np.reshape(places, (-1, 2)))
    return screen_from_canvas(editor.session.view, pixels)


def places_from_screen(editor: Editor, points: Points) -> Points:
    """Return normalised places (n, 2) on the canvas of screen positions."""
    pixels = canvas_from_screen(editor.session.view, np.reshape(points, (-1, 2)))
    return places_from_pixels(editor.canvas_px, pixels)
