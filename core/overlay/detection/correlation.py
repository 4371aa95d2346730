"""Lattice vectors from the picture's correlation with one of its own patches.

Finds what keypoints miss: dots, checks and plaids. The patch around a place is correlated with its surroundings; the
peaks nearest to the middle that are high enough are the vectors by which the pattern repeats there.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.overlay.detection.basis import reduce, spans

SIDES_PX = (20, 32, 48, 72, 108)
"""Sides of the exemplar patches."""
LEVELS = (0.5, 0.7, 0.85)
"""Peaks over these shares of the highest one count, in turn."""
LIKE_MARKED = (0.55, 1.8)
"""Area of a texel over that of the upright box which a user marked; a slanting one fills its box badly."""


@dataclass(frozen=True)
class Proposal:
    """A place where the pattern seems to repeat, and by which vectors."""

    point: Points
    """(2,), pixels."""
    basis: Floats
    """(2, 2), columns are the two vectors, pixels."""
    support: float
    """Mean correlation over the eight neighbours that the vectors predict."""


def propose(image: Singles, valid: Bools, rng: "np.random.Generator", *, places: int = 12) -> list[Proposal]:
    """Return proposals from patches of several sizes at random places of `image` (H, W, 3), best first."""
    found: list[Proposal] = []
    for side in SIDES_PX:
        if 2.5 * side > min(image.shape[:2]):
            continue
        for point in seeds(valid, side, rng, places):
            found += proposals_at(image, point, side)
    return sorted(found, key=lambda proposal: -proposal.support)


def snap(image: Singles, marked: Proposal) -> list[Proposal]:
    """Return proposals around a texel that a user marked, of about its size: its sides may slant."""
    sides = np.linalg.norm(marked.basis, axis=0)
    found: list[Proposal] = []
    for side in {round(float(length)) for length in (sides.min(), sides.mean(), sides.max())}:
        room = min(*marked.point, *(np.array(image.shape[1::-1]) - 1 - marked.point))
        if room > side // 2 + 1:
            found += proposals_at(image, marked.point, side)
    areas = [abs(np.linalg.det(proposal.basis) / np.linalg.det(marked.basis)) for proposal in found]
    return [proposal for proposal, area in zip(found, areas, strict=True) if LIKE_MARKED[0] < area < LIKE_MARKED[1]]


def seeds(valid: Bools, side: int, rng: "np.random.Generator", count: int) -> Points:
    """Return up to `count` places (n, 2) whose patch of `side` lies inside `valid`, spread over it."""
    whole = cv2.erode(np.pad(valid, 1).astype(np.uint8), np.ones((side + 1, side + 1), np.uint8), borderValue=0)[
        1:-1, 1:-1
    ]
    y, x = np.nonzero(whole)
    if not len(x):
        return np.empty((0, 2))
    pool = rng.permutation(len(x))[: 40 * count]
    chosen = [np.array([x[pool[0]], y[pool[0]]], float)]
    rest = np.stack([x[pool], y[pool]], -1).astype(float)
    for _ in range(min(count, len(pool)) - 1):
        distance = np.linalg.norm(rest[:, None] - np.array(chosen), axis=-1).min(1)
        chosen.append(rest[distance.argmax()])
    return np.array(chosen)


def proposals_at(image: Singles, point: Points, side: int) -> list[Proposal]:
    """Return the lattice vectors that the patch of `side` pixels around `point` suggests."""
    surface, middle = correlation_surface(image, point, side)
    if surface is None:
        return []
    peaks, heights = find_peaks(surface, middle, side)
    found: list[Proposal] = []
    for level in LEVELS if len(peaks) else ():
        basis = shortest_pair(peaks[heights >= max(level * heights.max(), 0.35)])
        if basis is None or any(np.allclose(basis, other.basis, atol=1.5) for other in found):
            continue
        support = neighbour_support(surface, middle, basis)
        if support > 0.3:
            found.append(Proposal(point, basis, support))
    return found


def correlation_surface(image: Singles, point: Points, side: int) -> tuple[Singles | None, Points]:
    """Return the correlation of the patch with its surroundings, and where in it the patch itself lies."""
    half, reach = side // 2, round(2.2 * side)
    x, y = (int(v) for v in point)
    patch = image[y - half : y + half + 1, x - half : x + half + 1]
    left, top = max(x - reach, 0), max(y - reach, 0)
    around = image[top : y + reach + 1, left : x + reach + 1]
    if patch.std(axis=(0, 1)).max(initial=0) < 0.02 or min(patch.shape[:2]) < 2 * half + 1:
        return None, point
    surface = cv2.matchTemplate(around, np.ascontiguousarray(patch), cv2.TM_CCOEFF_NORMED)
    return np.asarray(surface, np.float32), np.array([x - half - left, y - half - top], float)


def find_peaks(surface: Singles, middle: Points, side: int) -> tuple[Points, Floats]:
    """Return offsets from `middle` (n, 2) and heights (n,) of the surface's local maxima, the middle left out."""
    radius = max(2, side // 8)
    smooth = np.asarray(cv2.GaussianBlur(surface, (0, 0), 1.0), np.float32)
    highest = cv2.dilate(smooth, np.ones((2 * radius + 1, 2 * radius + 1), np.uint8))
    inner = np.zeros(surface.shape, bool)
    inner[1:-1, 1:-1] = True
    y, x = (a.astype(np.int64) for a in np.nonzero((smooth == highest) & (smooth > 0.25) & inner))
    offsets = np.stack([x, y], -1) + vertex_of_parabola(smooth, x, y) - middle
    away = np.linalg.norm(offsets, axis=1) > max(3.0, radius / 2)
    return offsets[away], smooth[y, x][away].astype(float)


def vertex_of_parabola(surface: Singles, x: Ints, y: Ints) -> Points:
    """Return the subpixel offsets (n, 2) of maxima at columns x and rows y."""
    out = []
    for dx, dy in ((1, 0), (0, 1)):
        before, here, after = (surface[y + k * dy, x + k * dx].astype(float) for k in (-1, 0, 1))
        bend = np.minimum(before - 2 * here + after, -1e-6)
        out.append(np.clip((before - after) / (2 * bend), -0.5, 0.5))
    return np.stack(out, -1)


def shortest_pair(vectors: Points) -> Floats | None:
    """Return the two shortest vectors that span the plane as columns, reduced, or None."""
    ordered = vectors[np.argsort(np.linalg.norm(vectors, axis=1))]
    pairs = (np.stack([ordered[0], second], -1) for second in ordered[1:])
    return next((reduce(pair) for pair in pairs if spans(pair)), None)


def neighbour_support(surface: Singles, middle: Points, basis: Floats) -> float:
    """Return the mean of the surface's highest values near the eight neighbours that `basis` predicts."""
    steps = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j])
    radius = max(2, round(0.12 * float(np.linalg.norm(basis, axis=0).min())))
    values = []
    for x, y in np.rint(middle + steps @ basis.T).astype(int):
        window = surface[max(y - radius, 0) : y + radius + 1, max(x - radius, 0) : x + radius + 1]
        if window.size and 0 <= x < surface.shape[1] and 0 <= y < surface.shape[0]:
            values.append(float(window.max()))
    return float(np.mean(values)) if len(values) >= 4 else 0.0
