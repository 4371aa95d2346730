"""What helps to lay an outline exactly: it snaps to the frame and to its corners, and is edited on both sides alike."""

from collections.abc import Sequence

import numpy as np

from app.editor.editor import Editor
from app.model.events import Move, Press
from app.model.session import OutlineAids
from app.model.shapes import Polyline, Shape
from app.tools.points.grips import aim, screen_from_places
from core.arrays import Ints, Points

SNAP_PX = 6.0
"""On the screen: from so far away a place comes onto the line that it snaps to."""
BEYOND_PX = 40.0
"""By so much lines to what it snaps to go on, so that they are seen beside a side of the outline."""
FRAME = np.array([(x, y) for y in (0.0, 0.5, 1.0) for x in (0.0, 0.5, 1.0)])
"""Corners, middles of sides and centre of the frame, in normalised places."""


class Snapping:
    """Moves of a place that come to lie level with, or plumb over, points of the frame and corners that stay.

    Parameters
    ----------
    place
        Where it is gripped (2,), on the screen.
    corners
        Corners (n, 2) of the outline that stay, on the screen.
    """

    def __init__(self, editor: Editor, place: Points, corners: Points) -> None:
        self._editor, self._place = editor, place
        self._points = np.concatenate([corners, screen_from_places(editor, FRAME)])

    def shift(self, press: Press, event: Move) -> Points:
        """Return by how much a drag moves the place, (2,), and show what it snaps to; with Ctrl held it does not."""
        free = np.subtract(aim(press.pos, event), press.pos, dtype=np.float64)
        found, lines = free.copy(), []
        for axis in (0, 1):
            apart = self._points - self._place - free
            if event.mods.ctrl or not self._editor.session.outline.snaps or free[axis] == 0:
                continue
            on_line = np.abs(apart[:, axis]) <= np.abs(apart[:, axis]).min() + 0.5
            best = int(np.argmin(np.where(on_line, np.abs(apart[:, 1 - axis]), np.inf)))
            if abs(apart[best, axis]) <= SNAP_PX:
                found[axis] += apart[best, axis]
                lines.append(self._points[best])
        self._editor.show(guides=tuple((line, self._place + found) for line in lines))
        return np.asarray(found)


def shapes(editor: Editor) -> Sequence[Shape]:
    """Return a line from what a place snaps to, to the place, and a little beyond both."""
    found = []
    for a, b in editor.session.guides:
        beyond = BEYOND_PX * (b - a) / max(float(np.hypot(*(b - a))), BEYOND_PX)
        found.append(Polyline(np.stack([a - beyond, b + beyond]), "rubber-band", dashed=True))
    return found


def mirror(before: Points, after: Points, aids: OutlineAids) -> Points:
    """Return a ring (12 or 13, 2) that was edited, with the same done to what is opposite in the chosen ways.

    Moves are mirrored, not places: an outline that was not symmetric stays as it was, but for the edit. Where a point
    and its opposite both move, each gets the mean of its own move and the other's.
    """
    own = (after - before)[:12]
    moves, count = np.zeros_like(own), np.zeros((12, 1))
    for opposite, sign in _ways(aids):
        there = own[opposite] * sign
        moves += there
        count += np.any(there != 0, axis=1, keepdims=True)
    moved = before[:12] + moves / np.maximum(count, 1)
    return np.concatenate([moved, moved[: len(before) - 12]])


def opposites(corners: frozenset[int], aids: OutlineAids) -> frozenset[int]:
    """Return these corners and those that move with them, 0 to 3 clockwise from the top left."""
    return frozenset(int(way[3 * corner]) // 3 for way, _ in _ways(aids) for corner in corners)


def _ways(aids: OutlineAids) -> list[tuple[Ints, Points]]:
    """Return for each way of mirroring, and for none, what is opposite to each point of a ring, and the axes' signs."""
    ring = np.arange(12)
    ways = [(ring, np.array([1.0, 1.0]))]
    if aids.across:
        ways.append(((3 - ring) % 12, np.array([-1.0, 1.0])))
    if aids.down:
        ways.append(((9 - ring) % 12, np.array([1.0, -1.0])))
    if aids.across and aids.down:
        ways.append(((ring + 6) % 12, np.array([-1.0, -1.0])))
    return ways
