"""Where further pieces of a cloth begin: at keypoints that look like those of cloth that is followed already.

A keypoint on cloth has texture coordinates. One beyond it that looks alike [Lowe 2004] is at the same place of a texel,
and its direction and size say how the cloth lies there. What its neighbours say has to agree with that, but for whole
texels, more often than the luckiest of all keypoints would by chance. So sleeves are found whose texels are large, of
which no lattice grows, and cloth whose motifs are too sparse to be followed from one to the next. Of another print with
the same texels some keypoints agree as often: a piece that was followed counts if those in it still say the same.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import scipy

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.overlay.detection.displacement_votes import ALIKE, BLOCK_PX, SAME_SIZE, surplus
from core.overlay.mesh import ClothMesh
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.orientation import slopes
from core.overlay.registration.registration import ClothState
from core.overlay.registration.thin_plate import interpolation

REACH = 1.5
"""Sides of a texel up to which neighbours are asked: cloth is nearly flat so far."""
OFF = 0.12
"""Sides of a texel by which they may miss what a keypoint foretells."""
ROUNDS = 3
"""Times that the slopes are fitted to those that agree."""


@dataclass(frozen=True)
class Matches:
    """Keypoints (n,) beyond the cloth that is followed, and what the most alike ones on it say of them."""

    points: Points
    """(n, 2)."""
    uv: Points
    """(n, 2), texels, but for whole ones."""
    slopes: Floats
    """(n, 2, 2), of the coordinates by x and y."""
    basis: Floats
    """S (2, 2), pixels a texel."""

    @property
    def side_px(self) -> float:
        """Side of a square of the area of a texel."""
        return float(np.sqrt(abs(np.linalg.det(self.basis))))

    def agreeing(self, at: Points, uv: Points, slopes: Floats) -> Bools:
        """Return which (n,) are near a place (2,), and lie as its `uv` (2,) and `slopes` (2, 2) foretell."""
        away = self.points - at
        near = np.asarray(np.linalg.norm(away, axis=-1) < REACH * self.side_px, np.bool_)
        return near & self.agree(away, self.uv - uv, slopes)

    def agree(self, away: Points, apart: Points, slopes: Floats) -> Bools:
        """Return which of n pairs, (n, 2) pixels `away` and texels `apart`, are so by slopes (2, 2) or (n, 2, 2)."""
        return self.are_whole(apart - (slopes @ away[..., None])[..., 0])

    def are_whole(self, apart: Points) -> Bools:
        """Return which vectors (n, 2), texels, are nearly whole ones."""
        missed = (apart - np.rint(apart)) @ self.basis.T
        return np.asarray(np.linalg.norm(missed, axis=-1) < OFF * self.side_px, np.bool_)

    def confirm(self, mesh: ClothMesh, piece: ClothState) -> float:
        """Return by how many standard deviations those that say what a piece says around them surpass chance."""
        row, column = cells_at(mesh, self.points)
        inside = piece.cells[row, column]
        points = self.points[inside]
        agree = self.are_whole(interpolation(mesh, points) @ piece.uv.reshape(-1, 2) - self.uv[inside])
        seen, asked = (len(np.unique(points[which] // BLOCK_PX, axis=0)) for which in (agree, np.s_[:]))
        return float(surplus(np.array(seen), np.array(asked * np.pi * OFF**2)))


def find_starts(cloth: FittedCloth, matches: Matches, taken: Bools) -> Iterator[ClothState]:
    """Yield where further pieces may begin, the surest first: coordinates, in texels, and the cells that tell them.

    Cells that are `taken` are left out, and so are those that are taken meanwhile.
    """
    sure, agree = agreement(matches)
    while len(sure) and sure.max() > by_chance(len(sure)):
        best = int(sure.argmax())
        start = state_around(cloth, matches, best, agree[best])
        start = replace(start, cells=start.cells & ~taken)
        if start.cells.any():
            yield start
        sure[agree[best]] = 0.0


def by_chance(tries: int) -> float:
    """Return what the largest of so many normal deviates comes to."""
    return float(np.sqrt(2 * np.log(tries)))


def cells_at(mesh: ClothMesh, points: Points) -> Ints:
    """Return row and column (2, n) of the cells in which places (n, 2), pixels, lie."""
    return np.clip((points.T[::-1] + 0.5) // mesh.cell, 0, np.array(mesh.cells)[:, None] - 1).astype(np.int64)


def match(cloth: FittedCloth, found: Fit) -> Matches:
    """Return the keypoints beyond the followed cloth that look like one on it, and what that says of them."""
    keypoints = cloth.canvas.keypoints
    row, column = cells_at(cloth.mesh, keypoints.points)
    uv, lie = np.zeros((len(row), 2)), np.zeros((*cloth.mesh.cells, 2, 2))
    for piece in found.pieces:
        own = piece.cells[row, column]
        uv[own] = interpolation(cloth.mesh, keypoints.points[own]) @ piece.uv.reshape(-1, 2)
        lie[piece.cells] = slopes(cloth.mesh, piece)
    known = found.cells[row, column]
    on, beyond = np.flatnonzero(known), np.flatnonzero(~known)
    if not len(on):
        beyond = on
    sizes = np.log(keypoints.sizes)
    unlike = 2 - 2 * keypoints.descriptors[beyond] @ keypoints.descriptors[on].T
    unlike[np.abs(sizes[beyond, None] - sizes[on]) > np.log(SAME_SIZE)] = np.inf
    nearest = unlike.argmin(1) if len(on) else on
    alike = np.take_along_axis(unlike, nearest[:, None], 1)[:, 0] < ALIKE**2
    here, there = beyond[alike], on[nearest[alike]]
    turn = keypoints.turns[there] - keypoints.turns[here]
    turned = np.moveaxis(np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]), -1, 0)
    scaled = (keypoints.sizes[there] / keypoints.sizes[here])[:, None, None] * turned
    return Matches(keypoints.points[here], uv[there], lie[row[there], column[there]] @ scaled, cloth.basis)


def agreement(matches: Matches) -> tuple[Floats, list[Ints]]:
    """Return by how many standard deviations (n,) those that agree with a match surpass chance, and which those are.

    Those that lie in one block are one motif, and count once.
    """
    points, count = matches.points, len(matches.points)
    one, other = scipy.spatial.KDTree(points).query_pairs(REACH * matches.side_px, output_type="ndarray").T
    own = np.arange(count)
    here, there = np.concatenate([own, one, other]), np.concatenate([own, other, one])
    apart = matches.uv[there] - matches.uv[here]
    agree = matches.agree(points[there] - points[here], apart, matches.slopes[here])
    blocks = np.unique((points // BLOCK_PX).astype(np.int64), axis=0, return_inverse=True)[1].ravel()
    seen, asked = (count_blocks(here[which], blocks[there[which]], count) for which in (agree, np.s_[:]))
    order = np.argsort(here[agree], kind="stable")
    agreeing = np.split(there[agree][order], np.cumsum(np.bincount(here[agree], minlength=count))[:-1])
    return np.asarray(surplus(seen, asked * np.float32(np.pi * OFF**2)), np.float64), agreeing


def count_blocks(matches: Ints, blocks: Ints, count: int) -> Singles:
    """Return how many different blocks (m,) stand beside each of `count` matches (m,)."""
    beside = scipy.sparse.csr_array((np.ones(len(blocks), np.float32), (matches, blocks)), shape=(count, count))
    return np.diff(beside.indptr).astype(np.float32)


def state_around(cloth: FittedCloth, matches: Matches, best: int, agree: Ints) -> ClothState:
    """Return coordinates that agree with a match and those of numbers `agree`, near which they count."""
    at, uv, lie = matches.points[best], matches.uv[best], matches.slopes[best]
    for _ in range(ROUNDS):
        # A few in a row say nothing of the slopes across it: what the first one says counts as much as one a side away.
        away, whole = matches.points[agree] - at, matches.uv[agree] - uv
        whole -= np.rint(whole - away @ lie.T)
        rows = np.concatenate([np.column_stack([away, np.ones(len(away))]), matches.side_px * np.eye(2, 3)])
        targets = np.concatenate([whole, matches.side_px * lie.T])
        change = np.linalg.lstsq(rows, targets, rcond=None)[0]
        lie, uv = change[:2].T, uv + change[2]
        agree = np.flatnonzero(matches.agreeing(at, uv, lie))
    _, cells = cloth.near_points(matches.points[agree])
    return ClothState(uv + (cloth.mesh.positions() - at) @ lie.T, cloth.brightness, cells)
