"""Fewer points for a curve and its target, which keep corresponding."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from core.arrays import Floats, Ints
from core.curves import curve_edit
from core.curves.fitting import direction_at_seam, fit_curve
from core.document.document import CurvePair

SAMPLE_PX = 1.5
FEWEST, MOST = 24, 1500
"""Samples of a piece between corners."""
PER_SEGMENT = 48


def simplify_pair(pair: CurvePair, size_px: tuple[int, int], *, tolerance_px: float) -> CurvePair:
    """Return the curves with few points, within `tolerance_px` of where they were; corners stay.

    Returns `pair` itself where no point can go. `size_px` is that of the picture.
    """
    line, corners = _line(pair, np.array([*size_px, *size_px], float))
    seam = direction_at_seam(line) if pair.closed and 0 not in pair.corners else None
    points, knots = fit_curve(line, corners, tolerance=tolerance_px, seam=seam)
    least = 7 if pair.closed else 4
    if not least <= len(points) < len(pair.source):
        return pair
    kept = set(np.flatnonzero(np.isin(knots, corners)).tolist())
    last = len(pair.source) // 3
    kept |= {new for old, new in ((0, 0), (last, len(knots) - 1)) if old in pair.corners}
    places = points / [*size_px, *size_px]
    return replace(pair, source=places[:, :2], target=places[:, 2:], corners=frozenset(kept))


def _line(pair: CurvePair, scale: Floats) -> tuple[Floats, Ints]:
    """Return source and target as one line (n, 4) in pixels, evenly sampled between corners, and the corners in it."""
    sides = [curve_edit.samples_of(points, per_segment=PER_SEGMENT) for points in (pair.source, pair.target)]
    dense = np.column_stack(sides) * scale
    segments = len(pair.source) // 3
    stops = [0, *sorted(knot for knot in pair.corners if 0 < knot < segments), segments]
    pieces, corners = [dense[:1]], [0]
    for first, last in pairwise(stops):
        piece = _evenly(dense[first * PER_SEGMENT : last * PER_SEGMENT])
        pieces.append(piece[1:])
        corners.append(corners[-1] + len(piece) - 1)
    return np.concatenate(pieces), np.array(corners[1:-1], int)


def _evenly(line: Floats) -> Floats:
    """Return points of a line, its ends included, at even distances."""
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    count = int(np.clip(along[-1] / SAMPLE_PX, FEWEST, MOST)) + 1
    places = np.linspace(0, along[-1], count)
    return np.column_stack([np.interp(places, along, line[:, axis]) for axis in range(line.shape[1])])
