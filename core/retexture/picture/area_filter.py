"""Reading a source where several of its pixels fall on one of the result.

With s the stretches of the map from the result to the source, the singular values of its Jacobian, a pixel shows the
mean over a box whose sides run along the images of the two directions that stay at right angles. They are as wide as
makes the spread of a pixel's square that of its image:

    w^2 = max(s^2 - 1, 0)

Where the source is not pressed together w is 0, and nothing is lost. A side has two halves, since the map may crease:
each by the steps to the neighbours that it leads to. No step leads across a seam.
"""

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from core.arrays import Ints, Singles
from core.retexture.deformation.grids import as_complex, as_pairs
from core.retexture.sampling import Kernel, read

PRESSED = 1.25
"""Stretches below this alias too little to be seen."""
MOST = 8
"""Samples along a side, at most."""
Numbers: TypeAlias = NDArray[np.complex64]
"""Vectors as complex numbers."""


class Boxes(NamedTuple):
    """What n pixels of the flattened picture show the mean of."""

    pixel: Ints
    halves: Singles
    """(n, 2, 2, 2) the two sides, the halves of each, and where these lead, px of the source."""

    def rows(self, start: int, stop: int, width: int) -> "Boxes":
        """Return the part in some rows; its pixels count from the first of them."""
        low, high = np.searchsorted(self.pixel, [start * width, stop * width])
        return Boxes(self.pixel[low:high] - start * width, self.halves[low:high])

    def corners(self, place: Singles) -> Singles:
        """Return what the boxes around their `place`s (H, W, 2) lie between: places (2 n, 2)."""
        middle, far = place.reshape(-1, 2)[self.pixel], np.abs(self.halves).max(axis=2).sum(axis=1)
        return np.concatenate([middle - far, middle + far])


def boxes(place: Singles, label: Ints) -> Boxes:
    """Return the pixels at whose `place`s (H, W, 2) the source is pressed together, in patches `label` (H, W).

    Label 0 is the plain deformation, which stays as it is.
    """
    at, width = as_complex(place).ravel(), label.shape[1]
    pixel = np.flatnonzero(label > 0)
    column = pixel % width
    right, left = _steps(at, label.ravel(), pixel, np.where(column < width - 1, 1, 0), np.where(column > 0, -1, 0))
    rows = np.where(pixel < label.size - width, width, 0), np.where(pixel >= width, -width, 0)
    down, up = _steps(at, label.ravel(), pixel, *rows)
    x, y = (right + left) / 2, (down + up) / 2
    a, b, d = ((p * np.conj(q)).real for p, q in ((x, x), (x, y), (y, y)))
    pressed = np.flatnonzero((a + d) / 2 + np.hypot((a - d) / 2, b) > PRESSED**2)
    turn = np.arctan2(2 * b[pressed], (a - d)[pressed]) / 2
    right, left, down, up = (step[pressed] for step in (right, left, down, up))
    cos, sin = np.cos(turn), np.sin(turn)
    # The first direction leads to the right, down or up; the second is a quarter turn from it.
    ahead, aside = np.where(sin > 0, down, up) * sin, np.where(sin > 0, left, right) * sin
    behind, beside = np.where(sin > 0, up, down) * sin, np.where(sin > 0, right, left) * sin
    halves = [cos * right + ahead, -cos * left - behind, cos * down - aside, beside - cos * up]
    return Boxes(pixel[pressed], as_pairs(_half(np.stack(halves, axis=1))).reshape(-1, 2, 2, 2))


def average(light: Singles, source: Singles, place: Singles, found: Boxes, origin: Singles | None = None) -> None:
    """Let pixels of `light` (H, W, C) show the means over their boxes of a source, around their `place`s (H, W, 2).

    The first pixel of the source lies at `origin` (x, y), None for (0, 0).
    """
    first_pixel = np.zeros(2, np.float32) if origin is None else origin
    middle, flat = place.reshape(-1, 2)[found.pixel], light.reshape(-1, light.shape[2])
    length = np.linalg.norm(found.halves, axis=-1).sum(axis=-1)
    counts = np.clip(np.ceil(length), 1, MOST).astype(np.int64)
    sides = counts @ [MOST + 1, 1]
    for both in np.flatnonzero(np.bincount(sides)):
        (longer, shorter), these = divmod(int(both), MOST + 1), np.flatnonzero(sides == both)
        total = np.zeros((len(these), light.shape[2]), np.float32)
        first, second = (found.halves[these, n] for n in (0, 1))
        beside = np.stack([np.float32(abs(t)) * second[:, int(t < 0)] for t in _middles(shorter)], axis=1)
        for t in _middles(longer):
            at = (middle[these] + np.float32(abs(t)) * first[:, int(t < 0)])[:, None] + beside
            total += read(source, at - first_pixel, Kernel.LANCZOS, mirror=True).sum(axis=1)
        flat[found.pixel[these]] = total / np.float32(longer * shorter)


def _steps(at: Numbers, label: Ints, pixel: Ints, after: Ints, before: Ints) -> tuple[Numbers, Numbers]:
    """Return the steps (n,) of places from pixels to those `after` them, and from those `before`, in the same patch.

    Each stands for the other where it is 0, as at a seam; both are where a patch is but a pixel wide.
    """
    mine, here = label.take(pixel), at.take(pixel)
    on, back = (np.where(label.take(pixel + by) == mine, at.take(pixel + by) - here, 0) for by in (after, before))
    return np.where(on == 0, -back, on), np.where(back == 0, on, -back)


def _half(reach: Numbers) -> Numbers:
    """Return halves of sides (n, 4) from what leads a whole pixel of the result away (n, 4)."""
    square = np.maximum((reach * np.conj(reach)).real, 1)
    return np.asarray(reach * np.sqrt(1 - 1 / square), np.complex64)


def _middles(count: int) -> list[float]:
    """Return the middles of `count` equal parts of the line from -1/2 to 1/2."""
    return [(i + 0.5) / count - 0.5 for i in range(count)]
