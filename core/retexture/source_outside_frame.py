"""What stands for the source where it would lie outside the picture: another part of the same curve, as far from it.

The deformation, which leads outside nowhere, stretches the last rows of the source over all that is missing. Where that
is little, it shows less than texture from somewhere else.
"""

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Points
from core.retexture.deformation.coordinates import SpineCurves

DEEP = 2
"""Much is missing where the source lies so many half patches outside."""
FARTHEST = 60
"""Other parts of a curve are looked for up to so many half patches away, the nearest first."""
TRIED = 12
"""So many of them are looked at together."""


def far_outside(places: Points, size: tuple[int, ...], rib: int) -> Bools:
    """Return which `places` (r, c, 2) of a grid lie in parts that lead far outside a picture of `size`, (H, W)."""
    limit = np.array(size[1::-1]) - 1
    depth = np.maximum(-places, places - limit).max(axis=-1)
    _, part = cv2.connectedComponents((depth > 0).astype(np.uint8))
    return np.asarray((depth > 0) & np.isin(part, part[depth > DEEP * rib]))


def has_surroundings(there: Points, here: Points, size: tuple[int, ...], rib: int) -> Bools:
    """Return whether a picture of `size`, (H, W), has the surroundings of places `there` (n, ..., 2).

    That is `rib` px to every side, or as far as the result has those of places `here` (n, ..., 2).
    """
    limit = np.array(size[1::-1]) - 1
    before = (there >= np.clip(here, 0, rib)) | (there >= here)
    after = (limit - there >= np.clip(limit - here, 0, rib)) | (there <= here)
    return np.asarray((before & after & (there >= 0) & (there <= limit)).all(axis=-1))


def find_stand_ins(
    source: SpineCurves, curve: Ints, length: Floats, offset: Floats, here: Points, size: tuple[int, ...], rib: int
) -> tuple[Bools, Points, Points]:
    """Return what stands for places at `offset`s from arc `length`s of source curves, for places `here` (n, 2).

    That is whether there is anything (n,), the places (n, 2), and the curves' tangents there (n, 2).
    """
    found, places, headings = np.zeros(len(here), bool), np.empty((len(here), 2)), np.empty((len(here), 2))
    steps = rib * np.arange(1, FARTHEST + 1).repeat(2) * np.tile([1, -1], FARTHEST)
    for some in np.split(steps, range(TRIED, len(steps), TRIED)):
        left = np.flatnonzero(~found)
        if not len(left):
            break
        at = length[left, None] + some
        found[left], places[left], headings[left] = _first_shown(
            source, curve[left], at, offset[left], here[left], size, rib
        )
    return found, places, headings


def _first_shown(
    source: SpineCurves, curve: Ints, at: Floats, offset: Floats, here: Points, size: tuple[int, ...], rib: int
) -> tuple[Bools, Points, Points]:
    """Return the first of the arc lengths `at` (n, m) that has the surroundings of `here` (n, 2)."""
    whole = np.array([each.length for each in source.curves])[curve][:, None]
    closed = np.array([each.closed for each in source.curves])[curve][:, None]
    at = np.where(closed, at % whole, at)
    tries = at.shape[1]
    places, headings = source.place(curve.repeat(tries), at.ravel(), offset.repeat(tries))
    places, headings = places.reshape(*at.shape, 2), headings.reshape(*at.shape, 2)
    good = has_surroundings(places, np.broadcast_to(here[:, None], places.shape), size, rib) & (at >= 0) & (at <= whole)
    first = np.arange(len(at)), good.argmax(axis=1)
    return np.asarray(good.any(axis=1)), places[first], headings[first]
