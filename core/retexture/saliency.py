"""Landmarks: what a picture shows once along a curve is no texture; regrown, it would be bent, torn or doubled.

The picture is averaged over squares, which smooths its texture, and read in curve coordinates as a strip (s, d). A
place is as rare as its surroundings differ from those at other s, at the same d: not from the most alike of them, since
a landmark may have a twin, but from a share of all. Texture is about as rare everywhere along the curve. What is many
times as rare as the median is a landmark; so is a long line across the curve, such as a mast, that is everywhere rarer.
"""

import cv2
import numpy as np

from core.arrays import Bools, Points, Singles
from core.retexture.deformation.coordinates import SpineCurves
from core.retexture.sampling import read

THING, LINE = 5, 3
"""Sides of the surroundings that are compared to find either, samples."""
NEAREST, FARTHEST, STRIDE = 6, 30, 2
"""With places so many samples away, on either side."""
BEYOND = 1.25
"""Strips are so many times as wide as landmarks are looked for, to tell lines that go on."""
ASIDE = (-1, 0, 1)
"""What runs along a curve wavers by so many samples across it."""
SHARE = 0.3
"""As large a share of the places is more alike."""
FAINT = 0.04
"""Differences below this, of 1, are none."""
RARE, UNUSUAL = 5.5, 3.0
"""A thing is somewhere, on average over a few samples, so many times as rare as the median, and everywhere more often
than the second."""
MEAN = 3
LENGTH, SLANTS = 21, np.linspace(-1, 1, 11)
"""Of lines, in samples: how long they are, and how far they lead along the curve for each across it."""
RARE_LINE, MOST = 2.1, 0.8
"""At most of its samples a line is so many times as rare as the median."""


def find_landmarks(
    picture: Singles, curves: SpineCurves, places: Points, *, reach_px: float, sample_px: float
) -> Bools:
    """Return at which `places` (n, 2) a picture (H, W, c) shows landmarks, none of them beyond `reach_px` of a curve.

    The samples of the picture lie about `sample_px` apart.
    """
    size = tuple(max(round(n / sample_px), 1) for n in picture.shape[1::-1])
    small = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.float32)
    scale = np.array(size) / picture.shape[1::-1]
    feet, farthest = curves.feet(places), BEYOND * reach_px
    inside = ~feet.beyond & (np.abs(feet.offset) <= reach_px)
    found = np.zeros(len(places), bool)
    offsets = np.linspace(-farthest, farthest, 2 * int(np.ceil(farthest / sample_px)) + 1)
    for i, curve in enumerate(curves.curves):
        lengths = np.linspace(0, curve.length, max(round(curve.length / sample_px), 2))
        length, offset = (part.ravel() for part in np.meshgrid(lengths, offsets, indexing="ij"))
        at, _ = curves.place(np.full(len(length), i), length, offset)
        strip = read(small, ((at + 0.5) * scale - 0.5).reshape(len(lengths), len(offsets), 2))
        mine = inside & (feet.curve == i)
        x = (feet.offset[mine] / farthest + 1) / 2 * (len(offsets) - 1)
        y = feet.length[mine] / curve.length * (len(lengths) - 1)
        found[mine] = read(_mark(strip, closed=curve.closed), np.column_stack([x, y])) > 0.5
    return found


def _mark(strip: Singles, *, closed: bool) -> Singles:
    """Return 1 on and beside the landmarks in a strip (n, m, c), 0 elsewhere."""
    thing, line = (times_as_rare(strip, side, closed=closed) for side in (THING, LINE))
    marked = (things(thing) | lines(line)).astype(np.float32)
    return np.asarray(cv2.dilate(marked, np.ones((MEAN, MEAN), np.uint8)), np.float32)


def times_as_rare(strip: Singles, side: int, *, closed: bool) -> Singles:
    """Return how many times as rare as the median surroundings of a `side` are in a strip (n, m, c)."""
    count = len(strip)
    shifts = range(NEAREST, min(FARTHEST, count), STRIDE)
    gaps = np.full((2 * len(shifts) + 1, *strip.shape[:2]), np.inf, np.float32)
    for i, shift in enumerate(shifts):
        least = np.minimum.reduce([_gap(strip, shift, aside, side) for aside in ASIDE])
        ends = count if closed else count - shift
        gaps[2 * i, :ends] = least[:ends]
        gaps[2 * i + 1] = np.roll(gaps[2 * i], shift, axis=0)
    gaps.sort(axis=0)
    chosen = (SHARE * np.isfinite(gaps).sum(axis=0)).astype(int)
    rare = np.take_along_axis(gaps, chosen[None], axis=0)[0]
    rare = np.where(np.isfinite(rare), rare, 0)
    median = np.sort(rare, axis=0)[[(count - 1) // 2, count // 2]].mean(axis=0)
    return np.asarray(rare / (median + FAINT**2), np.float32)


def _gap(strip: Singles, shift: int, aside: int, side: int) -> Singles:
    """Return the mean squares (n, m) by which surroundings differ from those `shift` further on, and `aside`."""
    gap = np.roll(strip, (-shift, -aside), axis=(0, 1)) - strip
    return np.asarray(cv2.blur(np.einsum("smc,smc->sm", gap, gap), (side, side)), np.float32)


def things(times: Singles) -> Bools:
    """Return which places (n, m) belong to things that are so many `times` as rare as the median."""
    mean = cv2.blur(times, (MEAN, MEAN))
    _, part = cv2.connectedComponents((mean > UNUSUAL).astype(np.uint8))
    return np.isin(part, part[mean > RARE])


def lines(times: Singles) -> Bools:
    """Return which places (n, m) belong to lines across the curve, so many `times` as rare as the median."""
    rare, found = (times > RARE_LINE).astype(np.float32), np.zeros(times.shape, bool)
    half = LENGTH // 2
    for slant in SLANTS:
        line = np.zeros((LENGTH, LENGTH), np.uint8)
        line[half + np.rint(slant * np.arange(-half, half + 1)).astype(int), np.arange(LENGTH)] = 1
        most = cv2.filter2D(rare, -1, line.astype(np.float32), borderType=cv2.BORDER_CONSTANT) >= MOST * LENGTH
        found |= cv2.dilate(most.astype(np.uint8), line) > 0
    return found & (rare > 0)
