"""How much of a retextured picture is magnified, beside its plain deformation, in bands along the curves."""

from typing import NamedTuple

import cv2
import numpy as np

from core.arrays import Bools, Ints, Singles
from core.curves.bezier import Curve
from core.retexture.result import Retexture, plain_place

MAGNIFIED = 1.6
"""What is so many times as large as in the source, in any direction, looks smeared."""
BAND_PX, BANDS = 10, 8
"""Width of a band, and how many there are."""


class Band(NamedTuple):
    """Pixels so far from the nearest target curve, px, and the shares of them that are magnified, from 0 to 1."""

    from_px: int
    to_px: int
    regrown: float
    plain: float


def bands(found: Retexture, targets: list[Curve]) -> list[Band]:
    """Return the bands along `targets` that hold any pixel of the picture, the nearest first."""
    height, width = found.label.shape
    deformed = plain_place(found.grid, found.field, (slice(0, height), slice(0, width)))
    shown = find_magnified(found.place, found.label), find_magnified(deformed, np.zeros_like(found.label))
    number = (distance(targets, (height, width)) / BAND_PX).astype(np.int64)
    counts = np.bincount(number.ravel(), minlength=BANDS)
    sums = [np.bincount(number[mask], minlength=BANDS) for mask in shown]
    return [
        Band(BAND_PX * i, BAND_PX * (i + 1), float(sums[0][i] / counts[i]), float(sums[1][i] / counts[i]))
        for i in range(BANDS)
        if counts[i]
    ]


def find_magnified(place: Singles, label: Ints) -> Bools:
    """Return which pixels show the source over `MAGNIFIED` times as large, from their `place`s (H, W, 2) in it.

    That is where the smaller singular value of the Jacobian is below 1 / `MAGNIFIED`; steps across seams between
    `label`s (H, W) do not count.
    """
    within = (label[:-1, 1:] == label[:-1, :-1]) & (label[1:, :-1] == label[:-1, :-1])
    right, down = place[:-1, 1:] - place[:-1, :-1], place[1:, :-1] - place[:-1, :-1]
    plus = np.hypot(right[..., 0] + down[..., 1], right[..., 1] - down[..., 0])
    minus = np.hypot(right[..., 0] - down[..., 1], right[..., 1] + down[..., 0])
    found = np.zeros(label.shape, np.bool_)
    found[:-1, :-1] = within & (np.abs(plus - minus) / 2 < 1 / MAGNIFIED)
    return found


def distance(curves: list[Curve], shape: tuple[int, int]) -> Singles:
    """Return the distance of every pixel (H, W) to the nearest curve, to about a pixel; large where none is in it."""
    apart = np.ones(shape, np.uint8)
    for curve in curves:
        line = np.rint(curve.at(curve.parameters(step=0.5))).astype(int)
        inside = ((line >= 0) & (line < [shape[1], shape[0]])).all(axis=1)
        apart[line[inside, 1], line[inside, 0]] = 0
    if apart.all():
        return np.full(shape, BAND_PX * BANDS, np.float32)
    return np.asarray(cv2.distanceTransform(apart, cv2.DIST_L2, 5), np.float32)
