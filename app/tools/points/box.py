"""The box around several selected points: drag it to move, its corners to scale, its knob or near them to turn."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.model.events import Position
from app.model.shapes import Circle, Polyline, Shape, Square
from app.tools.points.grips import REACH_PX, held_to_axis
from core.arrays import Floats, Points

MARGIN_PX = 14.0
"""The box stands so far off the points."""
TURN_PX = 26.0
"""Beside a corner, up to so far from it, the box is turned."""
KNOB_PX = 24.0
"""The knob that turns the box stands so far above it."""
STEP_RAD = np.pi / 12
"""With Shift the box is turned by whole steps."""


@dataclass(frozen=True)
class Grip:
    """What of a box was gripped."""

    kind: Literal["move", "scale", "turn"]
    corner: int = 0


@dataclass(frozen=True, eq=False)
class Box:
    """An upright box on the screen."""

    low: Points
    high: Points

    @classmethod
    def around(cls, points: Points) -> "Box | None":
        """Return the box around two or more points (n, 2); None around fewer."""
        if len(points) < 2:
            return None
        return cls(points.min(axis=0) - MARGIN_PX, points.max(axis=0) + MARGIN_PX)

    @property
    def corners(self) -> Points:
        """Corners (4, 2), clockwise from the top left."""
        (left, top), (right, bottom) = self.low, self.high
        return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])

    @property
    def knob(self) -> Position:
        """Where the knob is that turns the box."""
        return float(self.low[0] + self.high[0]) / 2, float(self.low[1]) - KNOB_PX

    def grip(self, pos: Position) -> Grip | None:
        """Return what is under `pos`."""
        away = np.hypot(*(self.corners - pos).T)
        corner = int(np.argmin(away))
        inside = bool((self.low <= pos).all() and (pos <= self.high).all())
        if away[corner] <= REACH_PX:
            return Grip("scale", corner)
        if np.hypot(*np.subtract(self.knob, pos)) <= REACH_PX:
            return Grip("turn", corner)
        if inside:
            return Grip("move")
        return Grip("turn", corner) if away[corner] <= TURN_PX else None

    def transform(self, grip: Grip, start: Position, pos: Position, *, held: bool) -> Floats:
        """Return the affine map (2, 3) of the screen that dragging `grip` from `start` to `pos` means.

        `held`, with Shift: moves keep to an axis, scales keep the proportions, turns go by whole steps.
        """
        if grip.kind == "move":
            x, y = held_to_axis(start, pos) if held else pos
            return np.array([[1.0, 0.0, x - start[0]], [0.0, 1.0, y - start[1]]])
        if grip.kind == "scale":
            fixed = self.corners[(grip.corner + 2) % 4]
            factors = (np.array(pos) - fixed) / (np.array(start) - fixed)
            matrix = np.diag(np.full(2, factors.mean()) if held else factors)
            return _about(matrix, fixed)
        middle = (self.low + self.high) / 2
        angle = _angle(pos, middle) - _angle(start, middle)
        angle = round(angle / STEP_RAD) * STEP_RAD if held else angle
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        return _about(turn, middle)

    def shapes(self) -> Sequence[Shape]:
        """Return the box, its corners and its knob, to draw."""
        corners = [Square((float(x), float(y)), 3.5, "box", filled=True) for x, y in self.corners]
        x, y = self.knob
        stem = Polyline(np.array([[x, y + KNOB_PX], [x, y]]), "box")
        return [Polyline(self.corners, "box", closed=True), stem, *corners, Circle(self.knob, 4.5, "box", filled=True)]


def apply(matrix: Floats, points: Points) -> Points:
    """Return `points` (n, 2) under an affine map (2, 3)."""
    moved: Points = points @ matrix[:, :2].T + matrix[:, 2]
    return moved


def _about(matrix: Floats, fixed: Points) -> Floats:
    """Return the affine map (2, 3) that is `matrix` (2, 2) about a fixed point."""
    return np.column_stack([matrix, fixed - matrix @ fixed])


def _angle(pos: Position, middle: Points) -> float:
    return float(np.arctan2(pos[1] - middle[1], pos[0] - middle[0]))
