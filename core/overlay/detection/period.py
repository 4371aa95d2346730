"""Which translations leave a texture as it is: tells a texel from its fractions and multiples.

A basis that is too fine joins what differs in colour only (a checkerboard with a mark in every second check), one that
is too coarse wastes observations. The texture is estimated twice, from two halves of the texels drawn at random. The
product of what a translation changes in one half and in the other has the true squared change as its mean, whatever
the noise, so that it is compared with the texture's variance without a model of the noise.
"""

from collections import Counter
from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Floats, Ints, Singles
from core.overlay.detection.alignment import FlatPicture, raster
from core.overlay.detection.basis import sublattices
from core.overlay.detection.lattice import Lattice, rows_of
from core.overlay.texel import estimate_texel

CHANGED, LARGEST_CHANGE = 0.03, 0.06
"""Share of the texture's variance over which a translation is no period, and the same where there is noise, or others
change far more."""
CONTRAST, NOISE = 0.25, 2.0
"""Share of what the worst translation changes up to which they do, and times the noise up to which a change is none."""
MARKED = 0.25
"""The same for the worst spot of a tenth of a texel: a small mark is part of the pattern."""
SAMPLES = 24
"""Samples along a side of one texel while testing."""

FURTHEST = 8
"""Most steps after which stripes that are evenly spaced come back to their first colour."""
LEAST_FAR = 4
"""Steps from which that is looked for here: a block of fewer texels shows it."""
LEAST_PAIRS = 16
"""Texels that have to be compared over so many steps."""
ALIKE, UNLIKE = 1.4, 2.0
"""Difference of two texels, over the least one, up to which they may be the same, and from which they are not."""


@dataclass(frozen=True)
class Halves:
    """The texture of a block of `count` x `count` texels, estimated from two halves of the photo."""

    first: Floats
    second: Floats
    count: int


def estimate_halves(photo: Floats | Singles, uv: Floats, weight: Floats | Singles, count: int, seed: int) -> Halves:
    """Return the texture over a block of texels of side `count`; `photo` (H, W, 3) has no shading."""
    block = np.floor(uv / count).astype(np.int64)
    draw = np.random.default_rng(seed).integers(0, 2, (512, 512)).astype(bool)
    which = draw[block[..., 0] % 512, block[..., 1] % 512]
    size = (SAMPLES * count, SAMPLES * count)
    light = np.ones(weight.shape)
    parts = [estimate_texel(photo, uv / count, light, weight * half, size).pixels for half in (which, ~which)]
    return Halves(parts[0], parts[1], count)


def change(halves: Halves, shift: Floats) -> tuple[float, float]:
    """Return what a translation by `shift` texels changes: mean and worst spot, over the texture's variance."""
    changes = [move(part, shift / halves.count) - part for part in (halves.first, halves.second)]
    mean = (halves.first + halves.second) / 2
    variance = float(mean.var(axis=(0, 1)).sum())
    product = (changes[0] * changes[1]).sum(-1)
    sigma = SAMPLES / 10
    pad = int(4 * sigma)
    local = cv2.GaussianBlur(np.pad(product, pad, mode="wrap"), (0, 0), sigma)[pad:-pad, pad:-pad]
    # Noise is as often negative as positive; a change is positive only.
    worst = float(local.max()) + min(3 * float(local.min()), 0.0)
    return float(product.mean()) / max(variance, 1e-9), worst / max(variance, 1e-9)


def move(pixels: Floats, shift: Floats) -> Floats:
    """Return a periodic texture moved by a share (2,) of its sides."""
    h, w = pixels.shape[:2]
    phase = np.exp(-2j * np.pi * (np.fft.fftfreq(w) * w * shift[0] + (np.fft.fftfreq(h) * h * shift[1])[:, None]))
    return np.asarray(np.fft.ifft2(np.fft.fft2(pixels, axes=(0, 1)) * phase[..., None], axes=(0, 1)).real)


def periods(*draws: Halves) -> set[tuple[int, int]]:
    """Return the steps (i, j), in texels, within the block after which the texture is the same in most draws."""
    steps = [(i, j) for i in range(draws[0].count) for j in range(draws[0].count)]
    changes = [{step: change(halves, np.array(step, float)) for step in steps} for halves in draws]
    # What seems to change less than nothing is noise, which is as often positive.
    noise = -min(mean for found in changes for mean, _ in found.values())
    votes: Counter[tuple[int, int]] = Counter()
    for found in changes:
        # Texels that were aligned badly never look quite the same; others must differ from them all the more.
        most = max(mean for mean, _ in found.values())
        limit = float(np.clip(max(CONTRAST * most, NOISE * noise), CHANGED, LARGEST_CHANGE))
        votes.update(step for step, (mean, worst) in found.items() if mean < limit and worst < MARKED)
    return {step for step, votes_for in votes.items() if 2 * votes_for > len(draws)}


def coarser(*draws: Halves) -> Ints:
    """Return the finest sublattice (2, 2) of Z² that contains `count` Z² and has periods of most draws as steps."""
    n, common = draws[0].count, periods(*draws)
    for index in range(1, n * n + 1):
        if (n * n) % index:
            continue
        for basis in sublattices(index):
            steps = {tuple(int(c) % n for c in basis @ np.array([a, b])) for a in range(n) for b in range(n)}
            if steps <= common and index * len(steps) == n * n:
                return basis
    return n * np.eye(2, dtype=np.int64)


def far_period(canvas: FlatPicture, lattice: Lattice) -> Ints:
    """Return after how many steps (2,) of each vector texels look alike again; 1 unless it is after many.

    Evenly spaced stripes of five colours have neighbours that differ, whichever blocks of two or three are taken.
    """
    values, _ = canvas.patches(lattice.frames.points, lattice.frames.bases, raster(0.5, 8))
    return np.array([far_period_along(values.reshape(len(values), -1), lattice.keys, k) for k in (0, 1)])


def far_period_along(values: Floats | Singles, keys: Ints, axis: int) -> int:
    """Return after how many steps along an axis the values (K, n) at vertices (K, 2) are alike again, or 1."""
    differences: list[float] = []
    for steps in range(1, FURTHEST + 1):
        there = rows_of(keys, keys + steps * np.eye(2, dtype=np.int64)[axis])
        if (there >= 0).sum() < LEAST_PAIRS:
            break
        change = values[there >= 0] - values[there[there >= 0]]
        differences.append(float(np.median((change**2).mean(-1))))
    if len(differences) < LEAST_FAR:
        return 1
    least = min(differences)
    period = 1 + next(k for k, difference in enumerate(differences) if difference < ALIKE * least)
    between = [difference for k, difference in enumerate(differences, 1) if k % period]
    return period if period >= LEAST_FAR and min(between) > UNLIKE * least else 1
