"""Surfaces by name, on which the whole picture is laid."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from core.arrays import Floats, InputError
from core.grid import Grid
from core.surfaces.surface import Surface

ROUND, HIGH = 96, 64
"""Quads across and down by which a shape is drawn."""
TIP = 0.02
"""A cone ends so far, as a share of its height, before its tip, where a picture has no room."""


@dataclass(frozen=True)
class Shape:
    """A surface with one number that says what it looks like."""

    place: Callable[[Floats, Floats, float], tuple[Floats, Floats, Floats]]
    """Where places of the picture are in space, x, y up and z, from shares of its width and height and the number."""
    number: str
    """What the number is."""
    usual: float
    least: float
    most: float


def _plane(u: Floats, v: Floats, wide: float) -> tuple[Floats, Floats, Floats]:
    return wide * (u - 0.5), 0.5 - v, 0 * u


def _cylinder(u: Floats, v: Floats, high: float) -> tuple[Floats, Floats, Floats]:
    a = 2 * np.pi * (u - 0.5)
    return np.sin(a), 2 * high * (0.5 - v), np.cos(a)


def _sphere(u: Floats, v: Floats, high: float) -> tuple[Floats, Floats, Floats]:
    a, b = 2 * np.pi * (u - 0.5), np.pi * (0.5 - v)
    return np.sin(a) * np.cos(b), high * np.sin(b), np.cos(a) * np.cos(b)


def _cone(u: Floats, v: Floats, high: float) -> tuple[Floats, Floats, Floats]:
    a, out = 2 * np.pi * (u - 0.5), TIP + (1 - TIP) * v
    return out * np.sin(a), 2 * high * (0.5 - out), out * np.cos(a)


def _torus(u: Floats, v: Floats, thick: float) -> tuple[Floats, Floats, Floats]:
    a, b = 2 * np.pi * (u - 0.5), 2 * np.pi * (0.5 - v)
    out = 1 + thick * np.cos(b)
    return out * np.sin(a), thick * np.sin(b), out * np.cos(a)


def _flag(u: Floats, v: Floats, wave: float) -> tuple[Floats, Floats, Floats]:
    return 1.5 * (u - 0.5), 0.5 - v - 0.2 * wave * u**2, wave * u * np.sin(9 * u + 2 * v)


SHAPES = {
    "plane": Shape(_plane, "width over height", 1.0, 0.1, 10.0),
    "cylinder": Shape(_cylinder, "height over width", 1.0, 0.1, 10.0),
    "sphere": Shape(_sphere, "height over width", 1.0, 0.2, 5.0),
    "cone": Shape(_cone, "height over width", 1.0, 0.1, 10.0),
    "torus": Shape(_torus, "thickness over radius", 0.4, 0.05, 0.95),
    "cube": Shape(_plane, "width over height", 1.0, 0.1, 10.0),
    "flag": Shape(_flag, "height of its waves", 0.15, 0.0, 0.5),
}
"""By name. A cube shows the picture on each of its faces."""


def make_shape(name: str, number: float | None = None) -> Surface:
    """Return the surface of a name; raise `InputError` for another name, or a number out of its range."""
    if name not in SHAPES:
        raise InputError(f"surface {name!r}: not one of " + ", ".join(SHAPES))
    shape = SHAPES[name]
    number = shape.usual if number is None else number
    if not shape.least <= number <= shape.most:
        raise InputError(f"surface {name}: a {shape.number} of {number:g} is not {shape.least:g} to {shape.most:g}")
    grid = Grid(ROUND, HIGH, cell_px=1)
    share = ((grid.nodes + 0.5) / (ROUND, HIGH)).reshape(-1, 2)
    places = np.stack(shape.place(share[:, 0], share[:, 1], number), axis=-1)
    if name == "cube":
        return _fold_cube(places + [0, 0, number / 2], share, grid)
    return Surface(name, places, share, grid.triangles, number)


def _fold_cube(front: Floats, share: Floats, grid: Grid) -> Surface:
    """Return six faces from one whose middle lies on the z axis, of a cube as wide as it."""
    wide = 2 * front[0, 2]
    level = np.stack([front[:, 0], wide * front[:, 1], front[:, 2]], axis=-1)
    turns = [
        np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]]) for a in np.arange(4) * np.pi / 2
    ]
    tilts = [np.array([[1, 0, 0], [0, 0, -s], [0, s, 0]]) for s in (-1.0, 1.0)]
    faces = [front @ turn.T for turn in turns] + [level @ tilt.T / [1, wide, 1] for tilt in tilts]
    count = len(share)
    triangles = np.concatenate([grid.triangles + k * count for k in range(len(faces))])
    return Surface("cube", np.concatenate(faces), np.tile(share, (len(faces), 1)), triangles, wide)
