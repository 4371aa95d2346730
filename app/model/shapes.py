"""What tools draw over the picture, as plain data in screen pixels; the window renders it.

Roles name the look, so that colours and line widths stand in one place, the theme.
"""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from core.arrays import Points

Role: TypeAlias = Literal[
    "pin",
    "pin-selected",
    "pin-rest",
    "source",
    "target",
    "passive",
    "edge",
    "faulty",
    "suggestion",
    "patch",
    "spine",
    "tick",
    "outline",
    "corner",
    "knot",
    "knot-selected",
    "handle",
    "link",
    "hover",
    "rubber-band",
    "box",
    "brush",
    "brush-core",
    "brush-erase",
    "lattice",
    "lattice-weak",
    "vertex",
]


@dataclass(frozen=True)
class Circle:
    """A circle of a fixed size on the screen, such as a pin or the brush's edge."""

    centre: tuple[float, float]
    radius_px: float
    role: Role
    filled: bool = False
    dashed: bool = False


@dataclass(frozen=True)
class Square:
    """An upright square of a fixed size on the screen, such as a corner point."""

    centre: tuple[float, float]
    half_px: float
    role: Role
    filled: bool = False


@dataclass(frozen=True, eq=False)
class Polyline:
    """Straight pieces through `points` (n, 2)."""

    points: Points
    role: Role
    closed: bool = False
    dashed: bool = False


@dataclass(frozen=True, eq=False)
class Bezier:
    """A piecewise cubic Bezier curve with control points (3k + 1, 2)."""

    points: Points
    role: Role
    dashed: bool = False


Shape: TypeAlias = Circle | Square | Polyline | Bezier
