"""Pieces of one straight edge made one line: what stands before an edge breaks it for a detector of segments."""

import numpy as np

from core.arrays import Bools, Floats, Points

_LEAST_SEEN = 0.5
"""Share of a line that its pieces make up at least: gaps that are longer than what is seen tell of several edges."""


def join_collinear(lines: Points, off_px: float, least_px: float) -> Points:
    """Return the ends (m, 2, 2) of lines, those in one that lie on one, the longest first.

    Lines (n, 2, 2) run along an edge with its dark side at the same hand; those that run the other way are of others.
    Ends of all pieces are within `off_px` of the line through the outermost. Shorter ones than `least_px` stay as they
    are.
    """
    left = lines[np.argsort(-_lengths(lines), kind="stable")]
    found = [left[_lengths(left) < least_px]]
    left = left[_lengths(left) >= least_px]
    while len(left):
        line, seen, left = left[0], float(_lengths(left[:1])[0]), left[1:]
        joined = True
        while joined and len(left):
            joined = False
            for i in np.flatnonzero(_may_belong(left, line, off_px)):
                longer, more = _join(line, left[i]), float(_lengths(left[i : i + 1])[0])
                if _off(longer, np.concatenate([line, left[i]])) > off_px:
                    continue
                if seen + more < _LEAST_SEEN * _lengths(longer[None])[0]:
                    continue
                line, seen, joined = longer, seen + more, True
                left = np.delete(left, i, axis=0)
                break
        found.append(line[None])
    joined_lines = np.concatenate(found)
    return np.asarray(joined_lines[np.argsort(-_lengths(joined_lines), kind="stable")])


def _lengths(lines: Points) -> Floats:
    return np.asarray(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1))


def _may_belong(others: Points, line: Points, off_px: float) -> Bools:
    """Return which of the lines run the same way, and have a middle near the line where a join could reach them."""
    along = (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])
    across = np.array([-along[1], along[0]])
    away = others.mean(axis=1) - line.mean(axis=0)
    lengths, own = _lengths(others), float(np.linalg.norm(line[1] - line[0]))
    reach = (own + lengths) / (2 * _LEAST_SEEN) + off_px
    # The further away a middle is, the more an angle of the line that is off by its own ends' amounts to.
    off = off_px * (1 + 2 * np.abs(away @ along) / own)
    same_way = (others[:, 1] - others[:, 0]) @ along > 0
    return np.asarray(same_way & (np.abs(away @ across) <= off) & (np.abs(away @ along) <= reach))


def _join(a: Points, b: Points) -> Points:
    """Return the line from the first to the last of the ends of two lines along the longer of them."""
    longer = max((a, b), key=lambda line: float(np.linalg.norm(line[1] - line[0])))
    ends = np.concatenate([a, b])
    place = ends @ (longer[1] - longer[0])
    return ends[[int(place.argmin()), int(place.argmax())]]


def _off(line: Points, points: Points) -> float:
    """Return how far the furthest of `points` is from a line."""
    along = (line[1] - line[0]) / max(float(np.linalg.norm(line[1] - line[0])), np.finfo(float).tiny)
    return float(np.abs((points - line[0]) @ np.array([-along[1], along[0]])).max())
