"""The file of handles: pins, inner curves and the outline, in pixels.

    {"pins": [{"at": [x, y], "to": [x, y], "turn": degrees, "scale": factor, "stiff": radius}],
     "curves": [{"source": [[x, y], ...], "target": [[x, y], ...]}],
     "outline": {"top": [[x, y] x 4], "right": ..., "bottom": ..., "left": ...}}

Every key is optional. With "turn" (clockwise) or "scale", or both, a pin has a ring: the picture is turned and scaled
by so much around it, against what it is without handles. Up to "stiff" around it the picture keeps its shape, as a
feature does. The outline's sides are cubic Bezier segments, clockwise from the top left.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from core.arrays import InputError, Points, as_points
from core.curves import feature_curves
from core.curves.feature_curves import FeatureCurve
from core.document.ring import Ring
from core.files.faults import faults_named
from core.files.json_file import read_json

_SIDES = ("top", "right", "bottom", "left")
_JOINT_PX = 1e-3
"""Sides may miss one another by so much in their common corner."""


@dataclass(frozen=True, eq=False)
class HandleFile:
    """What a file of handles holds."""

    pins_at: Points
    """(k, 2), pixels of the picture."""
    pins_to: Points
    """(k, 2), where they are to go."""
    rings: tuple[Ring | None, ...] = ()
    """The ring of each pin (k)."""
    stiff_px: tuple[float, ...] = ()
    """So far around each pin (k) the picture keeps its shape."""
    curves: tuple[FeatureCurve, ...] = ()
    outline: Points | None = None
    """(12, 2), a ring of control points clockwise from the top left corner, or None."""


def read(path: Path, size_px: tuple[int, int]) -> HandleFile:
    """Return the handles in `path` for a picture of `size_px`, (width, height).

    Raises `InputError` that names the file, the handle and the fault.
    """
    data = read_json(path)
    with faults_named(path):
        return from_data(data, size_px)


def from_data(data: object, size_px: tuple[int, int]) -> HandleFile:
    """Return the handles of a parsed file; raise `InputError` that names the handle and the fault."""
    entries = _object(data, "handles", {"pins", "curves", "outline"})
    pins = entries.get("pins", [])
    if not isinstance(pins, list):
        raise InputError('"pins" is not a list')
    places = [_pin(pin, f"pins[{i}]") for i, pin in enumerate(pins)]
    at, to = (np.reshape([place[end] for place in places], (-1, 2)) for end in (0, 1))
    curves = feature_curves.from_data({"curves": entries.get("curves", [])})
    for i, pin_at in enumerate(at):
        _check_inside(pin_at[None], size_px, f"pins[{i}]")
    for i, curve in enumerate(curves, 1):
        if curve.passive:
            raise InputError(f"curve {i}: is passive, which has no meaning for a warp")
        _check_inside(curve.source.box.reshape(2, 2), size_px, f"curve {i}")
    rings = tuple(_ring_of(pin, f"pins[{i}]") for i, pin in enumerate(pins))
    stiff = tuple(_radius(pin, f"pins[{i}]: stiff") for i, pin in enumerate(pins))
    outline = _outline(entries["outline"]) if "outline" in entries else None
    return HandleFile(at, to, rings, stiff, tuple(curves), outline)


def _object(data: object, name: str, keys: set[str]) -> dict[str, object]:
    """Return `data` if it is an object with none but `keys`."""
    if not isinstance(data, dict):
        raise InputError(f"{name}: not an object with {', '.join(sorted(keys))}")
    unknown = sorted(set(data) - keys)
    if unknown:
        raise InputError(f"{name}: unknown key {unknown[0]!r}; known are {', '.join(sorted(keys))}")
    return data


def _pin(entry: object, name: str) -> tuple[Points, Points]:
    """Return place and target of one pin."""
    pin = _object(entry, name, {"at", "to", "turn", "scale", "stiff"})
    for key in ("at", "to"):
        if key not in pin:
            raise InputError(f'{name}: has no "{key}"')
    return as_points([pin["at"]], f"{name}: at")[0], as_points([pin["to"]], f"{name}: to")[0]


def _check_inside(points: Points, size_px: tuple[int, int], name: str) -> None:
    """Raise `InputError` if one of `points` lies outside the picture's area."""
    if ((points < -0.5) | (points > np.array(size_px) - 0.5)).any():
        raise InputError(f"{name}: lies outside the picture of {size_px[0]}x{size_px[1]} pixels")


def _ring_of(pin: dict[str, object], name: str) -> Ring | None:
    """Return the ring of one pin, None if it has neither a turn nor a scale."""
    if "turn" not in pin and "scale" not in pin:
        return None
    turn, scale = (_number(pin.get(key, usual), f"{name}: {key}") for key, usual in (("turn", 0), ("scale", 1)))
    with faults_named(name):
        return Ring(turn, scale)


def _radius(pin: dict[str, object], name: str) -> float:
    """Return how far around a pin the picture is stiff, 0 where that is not said."""
    radius = _number(pin.get("stiff", 0), name)
    if radius < 0:
        raise InputError(f"{name}: {radius:g} is less than 0")
    return radius


def _number(value: object, name: str) -> float:
    """Return a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
        raise InputError(f"{name} is not a finite number")
    return float(value)


def _outline(entry: object) -> Points:
    """Return the ring of the outline's sides."""
    sides = _object(entry, "outline", set(_SIDES))
    points = []
    for name in _SIDES:
        if name not in sides:
            raise InputError(f'outline: has no "{name}"')
        points.append(as_points(sides[name], f"outline: {name}"))
        if len(points[-1]) != 4:
            raise InputError(f"outline: {name} has {len(points[-1])} points, not 4")
    for i, name in enumerate(_SIDES):
        if np.abs(points[i][-1] - points[(i + 1) % 4][0]).max() > _JOINT_PX:
            raise InputError(f"outline: {name} does not end where {_SIDES[(i + 1) % 4]} begins; sides run clockwise")
    return np.concatenate([side[:3] for side in points])
