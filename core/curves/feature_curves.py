"""Feature curves: where a curve is in the picture and where it shall go; the file that holds them.

The file is `{"curves": [{"source": [[x, y], ...], "target": [[x, y], ...], "closed": false, "passive": false}]}`.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from core.arrays import Floats, InputError
from core.curves.bezier import Curve, crossings, pair_parameters
from core.files.faults import faults_named
from core.files.json_file import read_json

GAP_PX = 2.0
"""Curves that cross are cut this far from the crossing, so that the pieces stay apart."""


@dataclass(frozen=True, eq=False)
class FeatureCurve:
    """A curve traced in the picture and its destination; a passive one has none and follows the deformation."""

    source: Curve
    target: Curve | None = None

    @property
    def passive(self) -> bool:
        """Whether the curve steers orientation only."""
        return self.target is None


def read(path: Path) -> list[FeatureCurve]:
    """Return the curves of a file; raise `InputError` that names the file, the curve and the fault."""
    data = read_json(path)
    with faults_named(path):
        return from_data(data)


def from_data(data: object) -> list[FeatureCurve]:
    """Return the curves of a parsed file; raise `InputError` that names the curve (counted from 1) and the fault."""
    entries = data.get("curves") if isinstance(data, dict) else None
    if not isinstance(entries, list):
        raise InputError('no list "curves"')
    return [_entry(entry, f"curve {i}") for i, entry in enumerate(entries, 1)]


def _entry(entry: object, name: str) -> FeatureCurve:
    if not isinstance(entry, dict):
        raise InputError(f"{name}: not an object with a source and a target")
    flags = {key: entry.get(key, False) for key in ("closed", "passive")}
    for key, value in flags.items():
        if not isinstance(value, bool):
            raise InputError(f'{name}: "{key}" is neither true nor false')
    source = _curve(entry, "source", name, closed=flags["closed"])
    if flags["passive"]:
        return FeatureCurve(source)
    target = _curve(entry, "target", name, closed=flags["closed"])
    if source.closed and measure_area(source) * measure_area(target) < 0:
        raise InputError(f"{name}: its source and its target run round in opposite directions")
    return FeatureCurve(source, target)


def _curve(entry: dict[str, Any], key: str, name: str, *, closed: bool) -> Curve:
    if key not in entry:
        raise InputError(f'{name}: has no "{key}"')
    with faults_named(f"{name}: {key}"):
        return Curve(entry[key], closed)


def measure_area(curve: Curve) -> float:
    """Return the signed area that a closed curve encloses, in px^2; positive when it runs clockwise on screen."""
    x, y = curve.at(curve.parameters(step=1.0)).T
    return float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum() / 2)


def disjoint(curves: list[FeatureCurve]) -> list[FeatureCurve]:
    """Break curves whose destinations cross one another, or themselves, into pieces that do not (DPD sec. 3.1)."""
    places: list[list[float]] = [[] for _ in curves]
    lines = [curve.target or curve.source for curve in curves]
    for i, a in enumerate(lines):
        for j in range(i, len(lines)):
            if curves[i].passive != curves[j].passive:
                continue
            for ta, tb in crossings(a, lines[j]):
                places[i].append(float(ta))
                places[j].append(float(tb))
    return [piece for curve, cuts in zip(curves, places, strict=True) for piece in _pieces(curve, cuts)]


def _pieces(curve: FeatureCurve, cuts: list[float]) -> list[FeatureCurve]:
    """Return `curve` without `GAP_PX` of its destination on either side of each of `cuts`."""
    if not cuts:
        return [curve]
    line = curve.target or curve.source
    at = np.sort(line.length_at(np.array(cuts)))
    if line.closed:
        starts, ends = at, np.concatenate([at[1:], [at[0] + line.length]])
    else:
        starts, ends = np.concatenate([[-GAP_PX], at]), np.concatenate([at, [line.length + GAP_PX]])
    spans = [(a + GAP_PX, b - GAP_PX) for a, b in zip(starts, ends, strict=True) if b - a > 4 * GAP_PX]
    return [_piece(curve, line, a, b) for a, b in spans]


def _piece(curve: FeatureCurve, line: Curve, start: float, end: float) -> FeatureCurve:
    """Return the part of `curve` whose destination has arc lengths `start` to `end`; both may pass the seam."""
    span = np.array([start, end])
    t = line.parameter_at(span % line.length if line.closed else span)
    if line.closed:
        t[1] += line.segments if end >= line.length and start < line.length else 0
    if curve.target is None:
        return FeatureCurve(curve.source.between(*t))
    s = _corresponding(curve.source, curve.target, t)
    return FeatureCurve(curve.source.between(*s), curve.target.between(*t))


def _corresponding(source: Curve, target: Curve, t: Floats) -> Floats:
    """Return the parameters on `source` that belong to `t` on `target`."""
    if source.segments == target.segments:
        return t
    laps, rest = np.divmod(t, target.segments)
    known = pair_parameters(source, target, step=1.0)
    return np.asarray(np.interp(rest, known[1], known[0]) + laps * source.segments)
