"""Layers put right by hand around single vertices of their lattice, without a search or a registration.

A vertex that is moved from p to p + d takes what is around it along. With φ Wendland's function of compact support,
positive definite in the plane (Wendland 1995), the shift of the cloth at a place x is

    D(x) = Σ a_k φ(|x - q_k| / R),    D(q_k) = d_k,    uv'(x) = uv(x - D(x)),

summed over the vertices that are held, at q_k: those that were moved, and those that are to stay, of d = 0. So they lie
where the artist put them whatever is moved later, and their neighbours follow softly. Beyond a seam nothing follows.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.overlay.composition import finite
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.filters.distances import nearest_of
from core.overlay.filters.texture_filter import steepness

REACH = 3.0
"""R in lattice steps, or in lengths of the longest move: the cloth folds nowhere around a single vertex."""
MOVED_PX = 1e-3
"""Length of a move that is one."""
CELL = 0.5
"""Lattice steps around a vertex, along both directions, that are its own."""
SEAM_PX = 3
"""Width of a seam: cloth on both sides is not connected through it."""
ROUNDS = 20
"""Steps in which it is found where a vertex that follows has come to."""


@dataclass(frozen=True)
class Corrections:
    """What the artist made of a lattice."""

    keys: Ints
    """(n, 2), all the vertices that there are to be; those of a lattice that are missing are removed."""
    points: Points
    """(n, 2), where those lie that are held, or new; the others follow."""
    held: Bools
    """(n,)."""
    seams: tuple[Points, ...] = ()
    """Lines (m, 2) that separate pieces of the cloth, pixels."""


@dataclass(frozen=True)
class LaidCloth:
    """Coordinates (H, W, 2), shading (H, W) or (H, W, 3) and coverage (H, W) of a cloth, and its lattice."""

    uv: Singles
    shading: Singles
    coverage: Singles
    lattice: Lattice


def mend(cloth: LaidCloth, wanted: Corrections) -> LaidCloth:
    """Return the cloth as the corrections want it; only what is around them changes."""
    rows = {tuple(key): row for row, key in enumerate(cloth.lattice.keys.tolist())}
    old = np.array([rows.get(tuple(key), -1) for key in wanted.keys.tolist()], np.int64)
    gone = np.setdiff1d(np.arange(len(cloth.lattice)), old)
    mended = uncover(cloth, gone)
    known = old >= 0
    shift = shift_of(cloth, wanted.points[known & wanted.held], old[known & wanted.held], wanted.seams)
    if shift is not None:
        mended = replace(mended, uv=shift.carry(mended.uv))
    points, frames = wanted.points.copy(), cloth.lattice.frames
    follows = known & ~wanted.held
    points[follows] = frames.points[old[follows]]
    if shift is not None:
        points[follows] = shift.follow(points[follows])
    beside = np.linalg.norm(points[:, None] - frames.points, axis=-1).argmin(1)
    alike = np.where(known, old, beside)
    lattice = Lattice(wanted.keys, PatchFrames(points, frames.bases[alike], frames.scores[alike]))
    return cover(replace(mended, lattice=lattice), np.flatnonzero(~known))


@dataclass(frozen=True)
class Shift:
    """By how much cloth is moved at a place: what belongs to one part moves with the held vertices of that part."""

    centres: Points
    """(k, 2), q."""
    weights: Floats
    """(k, 2), a."""
    part: Ints
    """(k,)."""
    parts: Ints
    """(H, W), the part of the cloth that a pixel is of."""
    reach_px: float

    def at(self, points: Points, part: Ints) -> Floats:
        """Return D (n, 2) at places (n, 2) of parts (n,)."""
        out = np.zeros(points.shape)
        for centre, weight, own in zip(self.centres, self.weights, self.part, strict=True):
            out += (wendland(points - centre, self.reach_px) * (part == own))[:, None] * weight
        return out

    def carry(self, uv: Singles) -> Singles:
        """Return coordinates (H, W, 2) moved with the cloth; what is not covered stays so."""
        low = np.maximum(np.floor(self.centres.min(0) - self.reach_px).astype(int), 0)
        high = np.ceil(self.centres.max(0) + self.reach_px).astype(int) + 1
        box = slice(low[1], high[1]), slice(low[0], high[0])
        here, covered = uv[box], finite(uv[box])
        y, x = np.nonzero(covered)
        shift = self.at(np.stack([x, y], -1) + low.astype(float), self.parts[box][y, x])
        some = np.abs(shift).max(1) > MOVED_PX
        if not some.any():
            return uv
        x, y, shift = x[some], y[some], shift[some]
        from_x, from_y = x - shift[:, 0], y - shift[:, 1]
        h, w = covered.shape
        near = np.clip(np.rint(from_y).astype(int), 0, h - 1), np.clip(np.rint(from_x).astype(int), 0, w - 1)
        source = np.divmod(nearest_of(covered)[1][near], w)
        down, across = (steepness(here.astype(np.float64), axis)[source] for axis in (0, 1))
        way = (from_y - source[0])[:, None] * down + (from_x - source[1])[:, None] * across
        out = uv.copy()
        out[box][y, x] = here[source] + way
        return out

    def follow(self, points: Points) -> Points:
        """Return where places (n, 2) of the cloth come to."""
        size = np.array(self.parts.shape[::-1]) - 1
        moved = points.copy()
        x, y = np.clip(np.rint(points).astype(int), 0, size).T
        for _ in range(ROUNDS):
            moved = points + self.at(moved, self.parts[y, x])
        return moved


def wendland(away: Points, reach_px: float) -> Floats:
    """Return φ of offsets (n, 2): 1 at the middle, 0 from `reach_px` on, twice differentiable."""
    r = np.minimum(np.linalg.norm(away, axis=-1) / reach_px, 1)
    return np.asarray((1 - r) ** 4 * (4 * r + 1), np.float64)


def shift_of(cloth: LaidCloth, places: Points, rows: Ints, seams: tuple[Points, ...]) -> Shift | None:
    """Return the shift that brings vertices of some rows (k,) of the lattice to `places` (k, 2), None if none moves."""
    from_points = cloth.lattice.frames.points[rows]
    moves = places - from_points
    longest = float(np.linalg.norm(moves, axis=1).max(initial=0))
    if longest <= MOVED_PX:
        return None
    reach_px = REACH * max(float(np.sqrt(cloth.lattice.texel_area)), longest)
    parts = parts_between(finite(cloth.uv), seams)
    x, y = np.clip(np.rint(from_points).astype(int), 0, np.array(parts.shape[::-1]) - 1).T
    part = parts[y, x]
    near = np.stack([wendland(places - centre, reach_px) for centre in places], -1) * (part[:, None] == part)
    weights = np.linalg.solve(near + 1e-9 * np.eye(len(near)), moves)
    return Shift(places, weights, part, parts, reach_px)


def parts_between(covered: Bools, seams: tuple[Points, ...]) -> Ints:
    """Return the number (H, W) of the part of the cloth that each pixel is of, or nearest to: seams separate parts."""
    if not seams:
        return np.zeros(covered.shape, np.int64)
    line = np.zeros(covered.shape, np.uint8)
    for seam in seams:
        cv2.polylines(line, [np.rint(seam).astype(np.int32)], False, 1, SEAM_PX)
    labels = cv2.connectedComponents((covered & (line == 0)).astype(np.uint8), connectivity=4)[1].astype(np.int64)
    return np.asarray(labels.ravel()[nearest_of(labels > 0)[1]] if labels.any() else labels, np.int64)


def uncover(cloth: LaidCloth, rows: Ints) -> LaidCloth:
    """Return the cloth without what is around the vertices of some rows of its lattice."""
    if not len(rows):
        return cloth
    off, frames = np.zeros(cloth.uv.shape[:2], bool), cloth.lattice.frames
    for point, basis in zip(frames.points[rows], frames.bases[rows], strict=True):
        box, own = cell_of(point, basis, off.shape)
        off[box] |= own
    uv = np.where(off[..., None], np.float32(np.nan), cloth.uv)
    lit = off if cloth.shading.ndim == 2 else off[..., None]
    shading = np.where(lit, np.float32(np.nan), cloth.shading)
    return replace(cloth, uv=uv, shading=shading, coverage=np.where(off, np.float32(0), cloth.coverage))


def cover(cloth: LaidCloth, rows: Ints) -> LaidCloth:
    """Return the cloth with what is around new vertices, which goes on from the nearest others of its lattice."""
    covered = finite(cloth.uv)
    if not len(rows) or not covered.any():
        return cloth
    uv, shading, coverage = cloth.uv.copy(), cloth.shading.copy(), cloth.coverage.copy()
    nearest, (keys, frames) = nearest_of(covered)[1], (cloth.lattice.keys, cloth.lattice.frames)
    old = np.setdiff1d(np.arange(len(keys)), rows)
    for row in rows.tolist():
        beside = old[np.linalg.norm(frames.points[old] - frames.points[row], axis=1).argmin()]
        x, y = np.clip(np.rint(frames.points[beside]).astype(int), 0, np.array(covered.shape[::-1]) - 1)
        start = uv[np.divmod(nearest[y, x], covered.shape[1])] + (keys[row] - keys[beside])
        basis = frames.bases[row]
        box, own = cell_of(frames.points[row], basis, covered.shape)
        own &= ~covered[box]
        rows_own, columns_own = np.nonzero(own)
        at = np.stack([columns_own + box[1].start, rows_own + box[0].start], -1)
        uv[box][own] = start + (at - frames.points[row]) @ np.linalg.inv(basis).T
        shading[box][own] = shading[np.divmod(nearest[box][own], covered.shape[1])]
        coverage[box][own] = 1.0
    return replace(cloth, uv=uv, shading=shading, coverage=coverage)


def cell_of(point: Points, basis: Floats, shape: tuple[int, ...]) -> tuple[tuple[slice, slice], Bools]:
    """Return a box of the picture and which of its pixels (h, w) are nearest to a vertex, by its lattice vectors."""
    half = CELL * np.abs(basis).sum(1)
    low = np.clip(np.floor(point - half).astype(int), 0, np.array(shape[1::-1]))
    high = np.clip(np.ceil(point + half).astype(int) + 1, low, np.array(shape[1::-1]))
    x, y = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
    steps = (np.stack([x, y], -1) - point) @ np.linalg.inv(basis).T
    return (slice(low[1], high[1]), slice(low[0], high[0])), np.asarray((np.abs(steps) <= CELL).all(-1), np.bool_)
