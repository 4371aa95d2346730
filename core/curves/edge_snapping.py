"""A curve that was drawn beside an edge, brought onto it: the best path through the strip around the curve."""

from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Floats, Ints, Points
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve
from core.imaging.image import Image
from core.imaging.proxy import proxy

REACH_PX, REACH = 10.0, 0.01
"""An edge is sought so far to either side, or this share of the picture's longer side where that is more."""
STEP = 0.05
"""Places of the strip lie so far apart across the curve, in reaches, and four times as far along it."""
BLUR = 0.16
"""Finer edges than this are texture, in reaches."""
NEAR = 0.15
"""Edges within this share of the reach are those that the curve was drawn on."""
FAINT = 0.25
"""Levels of 255 per px: no edge is fainter than a step of one level is, once it is blurred."""
STRONGER = 1.3
"""A curve leaves the edge that it was drawn on for one that is so many times as strong, in the mean along it."""


def snap_to_edge(image: Image, curve: FeatureCurve) -> FeatureCurve:
    """Return a feature curve with its source on the edge beside it, in a picture; itself if it is on one.

    The target is moved as far along its own normals, so that the motion stays what it was.
    """
    strip = _Strip.of(image, curve.source)
    own = float(np.abs(strip.strength[:, strip.near]).max(axis=1).mean())
    # An edge keeps its sense: the far edge of a thin thing has the dark on the other side.
    paths = [_best_path(np.maximum(sense * strip.strength, 0)) for sense in (1, -1)]
    best, offset = max(((strip.mean_along(path), path) for path in paths), key=lambda found: found[0])
    if best <= max(STRONGER * own, FAINT):
        return curve
    away = strip.offsets[offset]
    target = None if curve.target is None else _moved(curve.target, strip.shares, away)
    return FeatureCurve(_moved(curve.source, strip.shares, away), target)


@dataclass(frozen=True, eq=False)
class _Strip:
    """How strong edges along a curve are at n places along it and m to its sides."""

    shares: Floats
    """Where the places are, as shares of the curve's parameters (n,)."""
    offsets: Floats
    """Distances from it along its normals (m,), px."""
    strength: Floats
    """(n, m): by how much colours change along the curve's normal, per px; less than 0 where they become darker."""
    near: slice
    """Those offsets at which the curve itself is."""

    @classmethod
    def of(cls, image: Image, curve: Curve) -> "_Strip":
        """Return the strip around a curve."""
        reach = max(REACH_PX, REACH * max(image.size_px))
        half = round(1 / STEP)
        offsets = np.linspace(-reach, reach, 2 * half + 1)
        length = np.linspace(0, curve.length, max(int(curve.length / (4 * STEP * reach)), 8))
        t = curve.parameter_at(length)
        tangent = curve.tangent(t)
        normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1)
        places = (curve.at(t)[:, None] + offsets[:, None] * normal[:, None]).astype(np.float32)
        low = np.floor(places.min(axis=(0, 1)) - 2).astype(int).clip(0, np.array(image.size_px) - 2)
        high = np.ceil(places.max(axis=(0, 1)) + 3).astype(int).clip(low + 2, image.size_px)
        part = proxy(image.with_pixels(image.pixels[low[1] : high[1], low[0] : high[0]]), 1.0).astype(np.float32)
        smooth = np.asarray(cv2.GaussianBlur(part, (0, 0), BLUR * reach), np.float32)
        x, y = np.moveaxis(places - low.astype(np.float32), -1, 0)
        colours = np.asarray(
            cv2.remap(
                smooth,
                np.ascontiguousarray(x),
                np.ascontiguousarray(y),
                cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_REPLICATE,
            ),
            np.float32,
        ).reshape(*places.shape[:2], -1)
        across = np.gradient(colours, offsets[1] - offsets[0], axis=1)
        strength = np.copysign(np.linalg.norm(across, axis=-1), across.sum(axis=-1))
        close = round(NEAR / STEP)
        return cls(t / curve.segments, offsets, strength, slice(half - close, half + close + 1))

    def mean_along(self, path: Ints) -> float:
        """Return the mean strength along a path (n,) of numbers of offsets."""
        return abs(float(np.take_along_axis(self.strength, path[:, None], axis=1).mean()))


def _best_path(strength: Floats) -> Ints:
    """Return the offsets (n,), by number, along which strengths (n, m) add up to most.

    From a place to the next they change by one at most.
    """
    n, m = strength.shape
    total, before, number = strength[0], np.zeros((n, m), np.int64), np.arange(m)
    for i in range(1, n):
        padded = np.pad(total, 1, constant_values=-np.inf)
        ways = np.stack([total, padded[:-2], padded[2:]])
        before[i] = number + np.array([0, -1, 1])[ways.argmax(axis=0)]
        total = strength[i] + ways.max(axis=0)
    path = np.empty(n, np.int64)
    path[-1] = total.argmax()
    for i in range(n - 1, 0, -1):
        path[i - 1] = before[i][path[i]]
    return path


def _moved(curve: Curve, shares: Floats, away: Floats) -> Curve:
    """Return a curve whose places, at `shares` of its parameters (n,), are moved `away` along its normals (n,).

    Control points move as little as that takes, in the least-squares sense.
    """
    t = shares * curve.segments
    count = len(curve.points)
    weights = np.stack([Curve(_unit_points(count, i)).at(t)[:, 0] for i in range(count)], axis=1)
    if curve.closed:
        weights[:, 0] += weights[:, -1]
        weights[:, -1] = 0
    moves = np.linalg.lstsq(weights, away[:, None] * curve.normal(t), rcond=1e-6)[0]
    if curve.closed:
        moves[-1] = moves[0]
    return Curve(curve.points + moves, curve.closed)


def _unit_points(count: int, number: int) -> Points:
    """Return control points (count, 2) that are all 0 but for the x of one."""
    points = np.zeros((count, 2))
    points[number, 0] = 1
    return points
