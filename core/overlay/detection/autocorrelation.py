"""Lattice vectors from the autocorrelation of all that may be cloth.

A patch of crumpled cloth is little like its copies. Over all of the cloth their likeness adds up: its correlation with
itself is high where it is moved by a vector of the lattice. Cloth that is stretched by a share displaces copies in
proportion to how far they are apart, so that vectors of each octave of length are best looked for in a picture that is
shrunk until they are some pixels long.
"""

from functools import partial
from itertools import combinations
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from core.arrays import Bools, Floats, Points, Singles
from core.overlay.detection.basis import keep_distinct, reduce, spans
from core.overlay.neighbours import STEPS

SIDE_PX = 16.0
"""Side of a texel that is looked for at least, less than twice that; vectors are half to two times as long."""
SMOOTH_PX = (2.0, 1.0)
"""Blurs of the correlation, each of which proposes: copies lie so far from where even steps lead. Under the wider one
maxima join that stretched cloth has split."""
OVERLAP = 0.2
"""Share of the cloth that lies on cloth after it is moved, at least."""
PEAKS, PROPOSED = 10, 6
"""Highest maxima of which pairs are looked at, and lattices that are proposed under either blur."""
LEAST_TEXELS = 6.0
"""Area, in texels, that has to be seen: a block of two by three."""


def autocorrelate(image: Singles, valid: Bools) -> Singles:
    """Return the correlation (2 H, 2 W) of an image (H, W, C) with itself moved by each vector; at (H, W) by none.

    Only pixels count that are `valid` (H, W) in both; what they differ by from their means is compared [Padfield 2012].
    It is 0 where there are hardly any.
    """
    shape = 2 * image.shape[0], 2 * image.shape[1]
    inside = valid.astype(np.float64)[..., None]
    seen = image * inside
    marks, values, squares = (np.fft.rfft2(plane, shape, axes=(0, 1)) for plane in (inside, seen, seen**2))

    def correlate(a: NDArray[Any], b: NDArray[Any]) -> Floats:
        moved = np.fft.irfft2(np.conj(a) * b, shape, axes=(0, 1))
        return np.asarray(np.fft.fftshift(moved, axes=(0, 1)), np.float64)

    count = np.maximum(correlate(marks, marks), 1e-3)
    here, there = correlate(values, marks), correlate(marks, values)
    common = (correlate(values, values) - here * there / count).sum(-1)
    own, other = (correlate(squares, marks) - here**2 / count, correlate(marks, squares) - there**2 / count)
    spread = np.maximum(own.sum(-1), 1e-9) * np.maximum(other.sum(-1), 1e-9)
    enough = count[..., 0] >= OVERLAP * inside.sum()
    return np.where(enough, common / np.sqrt(spread), 0).astype(np.float32)


def propose_bases(image: Singles, valid: Bools) -> list[Floats]:
    """Return vectors (2, 2), columns, pixels, by which an image (H, W, C) may repeat where it is `valid` (H, W).

    They are those of distinct lattices, the likeliest ones under each blur first.
    """
    correlation = autocorrelate(image, valid)
    proposed: list[Floats] = []
    for blur_px in SMOOTH_PX:
        smooth = np.asarray(cv2.GaussianBlur(correlation, (0, 0), blur_px), np.float32)
        pairs = (np.stack(pair, -1) for pair in combinations(find_peaks(smooth), 2))
        bases = [reduce(pair) for pair in pairs if spans(pair) and is_of_size(pair, int(valid.sum()))]
        proposed += sorted(bases, key=partial(support, smooth), reverse=True)[:PROPOSED]
    return keep_distinct(proposed)


def support(correlation: Singles, basis: Floats) -> float:
    """Return the mean correlation at the steps that a basis (2, 2), pixels, predicts."""
    at = np.rint(np.array(correlation.shape[::-1]) / 2 + STEPS @ basis.T).astype(int)
    inside = ((at >= 0) & (at < correlation.shape[::-1])).all(1)
    return float(correlation[at[inside, 1], at[inside, 0]].sum()) / len(STEPS)


def is_of_size(basis: Floats, area_px: int) -> bool:
    """Return whether vectors (2, 2) span a texel of the size that is looked for, and an area shows enough of them."""
    texel_px = abs(float(np.linalg.det(basis)))
    return SIDE_PX**2 <= texel_px < (2 * SIDE_PX) ** 2 and LEAST_TEXELS * texel_px <= area_px


def find_peaks(correlation: Singles) -> list[Points]:
    """Return the vectors (2,) from the middle of a correlation to its highest maxima."""
    y, x = np.nonzero((correlation == cv2.dilate(correlation, np.ones((5, 5)))) & (correlation > 0))
    vectors = np.stack([x, y], -1) - np.array(correlation.shape[::-1]) / 2
    lengths = np.linalg.norm(vectors, axis=1)
    # Opposite vectors are the same.
    kept = (np.arctan2(vectors[:, 1], vectors[:, 0]) >= 0) & (lengths >= SIDE_PX / 2) & (lengths < 2 * SIDE_PX)
    vectors, heights = vectors[kept], correlation[y, x][kept]
    best = np.argsort(-heights, kind="stable")[:PEAKS]
    return list(vectors[best])
