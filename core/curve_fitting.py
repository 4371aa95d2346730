"""Bezier segments fitted to a drawn or traced line.

Least squares after P. J. Schneider, "An algorithm for automatically fitting digitized curves" (Graphics Gems, 1990):
with both ends and both end directions held, a cubic has two unknowns, the lengths of its handles. Points get
parameters by chord length, those are improved by Newton steps towards the nearest point, and a piece that stays too
far off is split where it is worst.
"""

from itertools import pairwise
from typing import cast

import numpy as np
from scipy.ndimage import gaussian_filter1d

from core.arrays import Bools, Floats, InputError, Points, as_points
from core.curves import Curve

REPARAMETRISATIONS = 4


def fit(line: Points, *, tolerance: float = 1.5, corner_deg: float = 60.0, closed: bool = False) -> Curve:
    """Return a curve within `tolerance` px of the polyline `line` (n, 2), smooth but at turns over `corner_deg`.

    Raises `InputError` when fewer than two points are distinct.
    """
    line = as_points(line, "a line")
    moves = np.concatenate([[True], np.hypot(*np.diff(line, axis=0).T) > 1e-9]) if len(line) else np.empty(0, bool)
    line = line[moves]
    if closed and len(line) > 2 and np.hypot(*(line[0] - line[-1])) > 1e-9:
        line = np.concatenate([line, line[:1]])
    if len(line) < 2:
        raise InputError("a line of one point makes no curve")
    directions = _directions(line, closed=closed)
    stops = np.flatnonzero(_corners(line, corner_deg))
    stops = np.unique(np.concatenate([[0], stops, [len(line) - 1]]))
    cubics: list[Points] = []
    for start, end in pairwise(stops):
        leave = directions[start] if closed and start == 0 else _outward(line[start : end + 1])
        arrive = -directions[end] if closed and end == len(line) - 1 else _outward(line[start : end + 1][::-1])
        _fit_piece(line[start : end + 1], leave, arrive, tolerance, cubics)
    return Curve(np.concatenate([cubics[0], *(cubic[1:] for cubic in cubics[1:])]), closed)


def _directions(line: Points, *, closed: bool) -> Points:
    """Return unit directions (n, 2) of a slightly smoothed line."""
    smooth = np.column_stack([gaussian_filter1d(line[:, i], 1.5, mode="nearest") for i in (0, 1)])
    slope = np.gradient(smooth, axis=0)
    if closed:
        slope[0] = slope[-1] = line[min(3, len(line) - 1)] - line[-min(4, len(line))]
    return _unit(slope)


def _corners(line: Points, corner_deg: float) -> Bools:
    """Return at which inner points (n,) the direction turns by more than `corner_deg`, at its local maximum."""
    if len(line) < 3:
        return np.zeros(len(line), bool)
    reach = min(4, (len(line) - 1) // 2)
    ahead, behind = np.zeros_like(line), np.zeros_like(line)
    ahead[:-reach], behind[reach:] = line[reach:] - line[:-reach], line[reach:] - line[:-reach]
    turn = np.zeros(len(line))
    inner = slice(reach, len(line) - reach)
    turn[inner] = np.degrees(np.arccos(np.clip((_unit(ahead[inner]) * _unit(behind[inner])).sum(axis=1), -1, 1)))
    window = np.lib.stride_tricks.sliding_window_view(np.pad(turn, reach), 2 * reach + 1)
    return cast("Bools", (turn > corner_deg) & (turn == window.max(axis=1)))


def _fit_piece(line: Points, leave: Points, arrive: Points, tolerance: float, cubics: list[Points]) -> None:
    """Append cubics along `line`; both end directions point into the piece."""
    steps = np.hypot(*np.diff(line, axis=0).T)
    u = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    for _ in range(REPARAMETRISATIONS):
        cubic = _least_squares(line, u, leave, arrive)
        curve = Curve(cubic)
        off = np.hypot(*(curve.at(u) - line).T)
        if off.max() <= tolerance or len(line) < 3:
            cubics.append(cubic)
            return
        if off.max() > 5 * tolerance + 5:
            break
        u = _towards_nearest(curve, line, u)
    split = int(np.clip(off.argmax(), 1, len(line) - 2))
    reach = min(2, split, len(line) - 1 - split)
    across = _unit(line[split + reach] - line[split - reach])
    _fit_piece(line[: split + 1], leave, -across, tolerance, cubics)
    _fit_piece(line[split:], across, arrive, tolerance, cubics)


def _least_squares(line: Points, u: Floats, leave: Points, arrive: Points) -> Points:
    """Return the cubic (4, 2) from the line's first to its last point with the best handle lengths.

    With B1 = 3u(1-u)^2, B2 = 3u^2(1-u), A = [B1 leave, B2 arrive] and r the line less the cubic without handles,
    the normal equations A'A (a, b)' = A'r give the lengths a and b.
    """
    first, last = line[0], line[-1]
    b1, b2 = (3 * u * (1 - u) ** 2)[:, None], (3 * u**2 * (1 - u))[:, None]
    start_share = ((1 - u) ** 3)[:, None] + b1
    rest = line - start_share * first - (1 - start_share) * last
    a1, a2 = b1 * leave, b2 * arrive
    normal = np.array([[(a1 * a1).sum(), (a1 * a2).sum()], [(a1 * a2).sum(), (a2 * a2).sum()]])
    right = np.array([(a1 * rest).sum(), (a2 * rest).sum()])
    chord = float(np.hypot(*(last - first)))
    span = chord if chord > 1e-9 else float(np.hypot(*np.diff(line, axis=0).T).sum())
    lengths = np.full(2, span / 3)
    if abs(np.linalg.det(normal)) > 1e-12:
        lengths = np.linalg.solve(normal, right)
    # Handles that point backwards or overshoot make loops: the third of the chord is always safe.
    lengths = np.where((lengths > 1e-3 * span) & (lengths < 3 * span), lengths, span / 3)
    return np.array([first, first + lengths[0] * leave, last + lengths[1] * arrive, last])


def _towards_nearest(curve: Curve, line: Points, u: Floats) -> Floats:
    """Return parameters moved towards the feet of the line's points on `curve`, still in order."""
    slope = curve.derivative(u)
    gap = ((curve.at(u) - line) * slope).sum(axis=1)
    moved = np.clip(u - gap / np.maximum((slope**2).sum(axis=1), 1e-12), 0, 1)
    moved[0], moved[-1] = 0.0, 1.0
    return np.maximum.accumulate(moved)


def _outward(line: Points) -> Points:
    """Return the unit direction in which `line` leaves its first point."""
    return _unit(line[min(3, len(line) - 1)] - line[0])


def _unit(vectors: Points) -> Points:
    return cast("Points", vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12))
