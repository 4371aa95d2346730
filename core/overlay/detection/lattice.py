"""The lattice: vertices with integer coordinates, grown from a seed by prediction and local search.

NRT sec. 3.1 with two changes: a place is predicted from all known neighbours, and the vectors are updated by aligning
the mean appearance around a vertex affinely, which gives both of them at every vertex.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import scipy

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.overlay.detection.alignment import FlatPicture, PatchFrames, Template, align, make_template, raster, search
from core.overlay.filters.shrinking import to_small
from core.overlay.neighbours import STEPS

AROUND = np.concatenate([STEPS, -STEPS])
NEIGHBOURS = AROUND[np.abs(AROUND).sum(1) == 1]
LEAST_VERTICES = 9
"""Of a lattice that is found by itself, and of keypoints that are alike: fewer are chance."""
STRETCH = (0.5, 2.0)
"""Allowed length of a vector over that of its neighbour's (NRT: 0.5 <= α <= 2); the seed's counts with its square."""
SLACK = 0.14
"""Texels by which a step between two vertices may differ from the mean of their vectors."""
TRIES = 3


@dataclass(frozen=True)
class Lattice:
    """K vertices: integer coordinates (K, 2), u before v, and their frames in the picture."""

    keys: Ints
    frames: PatchFrames

    def __len__(self) -> int:
        return len(self.keys)

    def __getitem__(self, which: Ints | Bools) -> "Lattice":
        """Return the part that an index array or mask picks."""
        return Lattice(self.keys[which], self.frames[which])

    @property
    def is_row(self) -> bool:
        """Whether all vertices lie in one row or column: the edge of stripes repeats so too."""
        return len(self) == 0 or bool(np.ptp(self.keys, axis=0).min() == 0)

    @property
    def texel_area(self) -> float:
        """Median area of a texel, square pixels."""
        return float(np.median(np.abs(np.linalg.det(self.frames.bases)))) if len(self) else 0.0

    @property
    def basis(self) -> Floats:
        """Median vectors (2, 2), columns, pixels a texel."""
        return np.asarray(np.median(self.frames.bases, axis=0), np.float64)

    def divided(self, steps: int) -> "Lattice":
        """Return the lattice with so many steps along each side of a texel, and its vertices alone."""
        return Lattice(steps * self.keys, replace(self.frames, bases=self.frames.bases / steps))

    def shrunk(self, times: int) -> "Lattice":
        """Return the lattice in pixels of a picture of means over squares of so many pixels."""
        frames = replace(self.frames, points=to_small(self.frames.points, times), bases=self.frames.bases / times)
        return replace(self, frames=frames)


def window(basis: Floats) -> tuple[float, int]:
    """Return the reach in texels and samples a side of a template for texels of such vectors."""
    length = float(np.sqrt(abs(np.linalg.det(basis))))
    reach = max(0.75, 13.0 / length)
    return reach, int(np.clip(round(2 * reach * length / 1.5), 16, 36))


def mean_template(canvas: FlatPicture, frames: PatchFrames, *, reach: float | None = None) -> Template:
    """Return the robust mean appearance within `reach` texels of the vertices as a template; weighs by score."""
    usual, count = window(np.median(frames.bases, axis=0))
    reach = reach or usual
    values, known = canvas.patches(frames.points, frames.bases, raster(reach, count))
    w = (np.maximum(frames.scores, 0.05)[:, None] ** 2 * (1.0 if known is None else known)).astype(np.float32)
    mean = weighted_mean(values, w)
    spread = np.abs(values - mean).mean((1, 2))
    w = w * (spread <= 2 * np.median(spread))[:, None]
    return make_template(weighted_mean(values, w).reshape(count, count, -1), reach)


def weighted_mean(values: Singles, weights: Singles) -> Singles:
    """Return the mean (M, C) of patches (K, M, C) under weights (K, M or 1)."""
    total = np.maximum(weights.sum(0), 1e-6)
    return np.asarray(
        np.einsum("km,kmc->mc", np.broadcast_to(weights, values.shape[:2]), values) / total[:, None], np.float32
    )


def seed(canvas: FlatPicture, point: Points, basis: Floats) -> tuple[Lattice, Template]:
    """Return the lattice of one vertex and the template of its surroundings."""
    frames = PatchFrames(point[None].astype(float), basis[None].astype(float), np.ones(1))
    return Lattice(np.zeros((1, 2), np.int64), frames), mean_template(canvas, frames)


def grow(
    canvas: FlatPicture, lattice: Lattice, template: Template, *, least: float = 0.5, most: int = 4000
) -> Iterator[Lattice]:
    """Yield the lattice after each ring of new vertices, until nothing more fits.

    `least` is the lowest correlation of a vertex, `most` the number of vertices to stop at.
    """
    typical = lattice.basis
    tried: dict[tuple[int, int], int] = {}
    while len(lattice) < most:
        keys = frontier(lattice, tried)
        if not len(keys):
            return
        keys, predicted = predict(lattice, keys)
        found = align(canvas, template, search(canvas, template, predicted), rounds=8)
        fits = (found.scores >= least) & plausible(found, predicted, typical)
        fits[fits] = agreeing(lattice, keys[fits], found[fits])
        for key in keys[~fits].tolist():
            tried[tuple(key)] = tried.get(tuple(key), 0) + 1
        if not fits.any():
            continue
        lattice = join(lattice, Lattice(keys[fits], found[fits]))
        yield lattice


def join(a: Lattice, b: Lattice) -> Lattice:
    """Return the vertices of both."""
    pairs = ((a.frames.points, b.frames.points), (a.frames.bases, b.frames.bases), (a.frames.scores, b.frames.scores))
    return Lattice(np.concatenate([a.keys, b.keys]), PatchFrames(*(np.concatenate(pair) for pair in pairs)))


def rows_of(keys: Ints, wanted: Ints) -> Ints:
    """Return the rows of the wanted keys (..., 2) among `keys` (K, 2), -1 for those that are none of them."""
    if not len(keys):
        return np.full(wanted.shape[:-1], -1)
    # One number for each place of the lattice; one outside of it may have the number of another.
    unit = np.array([1, int(np.ptp(keys[:, 0])) + 1])
    number = keys @ unit
    order = np.argsort(number, kind="stable")
    found = order[np.maximum(np.searchsorted(number[order], wanted @ unit, side="right") - 1, 0)]
    return np.where((keys[found] == wanted).all(-1), found, -1)


def frontier(lattice: Lattice, tried: dict[tuple[int, int], int]) -> Ints:
    """Return the keys next to the lattice that are not in it and have not failed too often."""
    around = (lattice.keys[:, None] + NEIGHBOURS).reshape(-1, 2)
    around = around[rows_of(lattice.keys, around) < 0]
    ring, first, count = np.unique(around, axis=0, return_index=True, return_counts=True)
    failed = np.array([tried.get((i, j), 0) for i, j in ring.tolist()])
    # A place that failed is tried again when it has more neighbours than it had failures.
    order = np.argsort(first)
    return ring[order[(failed < np.minimum(count, TRIES))[order]]]


def predict(lattice: Lattice, keys: Ints) -> tuple[Ints, PatchFrames]:
    """Return the keys that have a neighbour and the frames that their neighbours predict there."""
    near = rows_of(lattice.keys, keys[:, None] + AROUND)
    weight = (near >= 0) * np.where(np.abs(AROUND).sum(1) == 1, 1.0, 0.4)
    weight = weight / weight.sum(1, keepdims=True)
    bases, points = lattice.frames.bases[near], lattice.frames.points[near]
    steps = points - np.einsum("knij,nj->kni", bases, AROUND.astype(float))
    frames = PatchFrames(
        np.einsum("kn,kni->ki", weight, steps), np.einsum("kn,knij->kij", weight, bases), np.zeros(len(keys))
    )
    return keys, frames


def plausible(found: PatchFrames, predicted: PatchFrames, typical: Floats) -> Bools:
    """Return which frames are neither folded nor stretched too far."""
    good = np.linalg.det(found.bases) * np.linalg.det(typical) > 0
    for reference, (low, high) in ((predicted.bases, (0.6, 1.6)), (typical[None], STRETCH)):
        inner = np.linalg.inv(reference) @ found.bases
        sizes = np.linalg.svd(np.nan_to_num(inner), compute_uv=False)
        good &= (sizes[:, 1] > low * (0.7 if high == STRETCH[1] else 1)) & (sizes[:, 0] < high * 1.25)
    drift = np.einsum("kij,kj->ki", np.linalg.inv(predicted.bases), found.points - predicted.points)
    return np.asarray(good & (np.abs(drift).max(1) < 0.4), np.bool_)


def agreeing(lattice: Lattice, keys: Ints, found: PatchFrames) -> Bools:
    """Return which new vertices lie where their neighbours' vectors and their own lead, and on nobody else's place."""
    near = rows_of(lattice.keys, keys[:, None] + NEIGHBOURS)
    wrong = step_errors(found.points, found.bases, lattice.frames, near)
    known = near >= 0
    agree = ((wrong < SLACK) & known).sum(1) * 2 > known.sum(1)
    if len(keys):
        agree &= ~find_crowded(lattice, found)
    return np.asarray(agree, np.bool_)


def step_errors(points: Points, bases: Floats, others: PatchFrames, near: Ints) -> Floats:
    """Return (K, 4) texels between the steps to the neighbours and the mean of the vectors at both ends."""
    mean = (bases[:, None] + others.bases[near]) / 2
    steps = others.points[near] - points[:, None] - np.einsum("knij,nj->kni", mean, NEIGHBOURS.astype(float))
    inside = np.linalg.solve(mean, steps[..., None])[..., 0]
    return np.where(near >= 0, np.linalg.norm(inside, axis=-1), 0.0)


def find_crowded(lattice: Lattice, found: PatchFrames) -> Bools:
    """Return which new frames fall within half a texel of a vertex that exists."""
    _, away = nearest_vertices(found.points, lattice)
    apart = np.linalg.solve(found.bases, away[..., None])[..., 0]
    return np.asarray(np.abs(apart).max(1) < 0.5, np.bool_)


def nearest_vertices(points: Points, lattice: Lattice) -> tuple[Ints, Points]:
    """Return the rows (n,) of the vertices nearest to points (n, 2), and the ways (n, 2) from there to the points."""
    rows = np.asarray(scipy.spatial.cKDTree(lattice.frames.points).query(points)[1], np.int64)
    return rows, points - lattice.frames.points[rows]


def neighbour_rows(keys: Ints) -> Ints:
    """Return (K, 4) rows of the neighbours right, below, left and above, -1 where there is none."""
    return rows_of(keys, keys[:, None] + NEIGHBOURS)


def refine(canvas: FlatPicture, lattice: Lattice, *, rounds: int = 8) -> tuple[Lattice, Template]:
    """Return the lattice aligned anew with its own mean appearance, outliers rejected, and that appearance."""
    template = mean_template(canvas, lattice.frames)
    found = align(canvas, template, lattice.frames, rounds=rounds)
    good = plausible(found, lattice.frames, lattice.basis)
    frames = PatchFrames(
        np.where(good[:, None], found.points, lattice.frames.points),
        np.where(good[:, None, None], found.bases, lattice.frames.bases),
        np.where(good, found.scores, -1.0),
    )
    return keep_connected(reject_outliers(replace(lattice, frames=frames))), template


def reject_outliers(lattice: Lattice, *, spread: float = 4.0) -> Lattice:
    """Return the lattice without vertices whose likeness or continuity is an outlier by the MAD (NRT sec. 3.1)."""
    scores = lattice.frames.scores
    near = neighbour_rows(lattice.keys)
    wrong = step_errors(lattice.frames.points, lattice.frames.bases, lattice.frames, near)
    apart = wrong.max(1, initial=0)
    keep = (scores > median_bound(scores, -spread, 0.08)) & (apart < max(SLACK, median_bound(apart, spread, 0.02)))
    return lattice[keep | (np.abs(lattice.keys).sum(1) == 0)] if keep.any() else lattice


def median_bound(values: Floats, spread: float, least: float) -> float:
    """Return the median plus `spread` times the MAD in units of a standard deviation, which is at least `least`."""
    middle = float(np.median(values))
    return middle + spread * max(1.4826 * float(np.median(np.abs(values - middle))), least)


def keep_connected(lattice: Lattice) -> Lattice:
    """Return the largest part whose vertices are connected by lattice steps."""
    return lattice[max(parts(neighbour_rows(lattice.keys)), key=len)] if len(lattice) else lattice


def parts(near: Ints) -> list[Ints]:
    """Return the rows of each set of vertices that are connected, from their neighbours (K, 4)."""
    rows, columns = np.nonzero(near >= 0)
    count = len(near)
    graph = scipy.sparse.csr_array((np.ones(len(rows)), (rows, near[rows, columns])), shape=(count, count))
    number, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
    return [np.flatnonzero(label == k) for k in range(number)]
