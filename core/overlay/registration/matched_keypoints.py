"""Where further pieces of a cloth begin: at keypoints that look like those of cloth that is followed already.

A keypoint on cloth has texture coordinates. One beyond it that looks alike [Lowe 2004] is at the same place of a texel,
and its direction and size say how the cloth lies there. What its neighbours say has to agree with that, but for whole
texels, far more often than by chance. So sleeves are found whose texels are large, of which no lattice grows.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
import scipy

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.overlay.detection.displacement_votes import ALIKE, BLOCK_PX, LIKELY, SAME_SIZE, surplus
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
        missed = apart - (slopes @ away[..., None])[..., 0]
        missed = (missed - np.rint(missed)) @ self.basis.T
        return np.asarray(np.linalg.norm(missed, axis=-1) < OFF * self.side_px, np.bool_)


def find_starts(cloth: FittedCloth, found: Fit) -> Iterator[ClothState]:
    """Yield where further pieces may begin, the surest first: coordinates, in texels, and the cells that tell them."""
    if not has_room(cloth, found):
        return
    matches = match(cloth, found)
    sure, agree = agreement(matches)
    while len(sure) and sure.max() > LIKELY:
        best = int(sure.argmax())
        yield state_around(cloth, matches, best, agree[best])
        sure[agree[best]] = 0.0


def has_room(cloth: FittedCloth, found: Fit) -> bool:
    """Return whether as many blocks as have to agree fit within the reach of a keypoint beyond what is followed."""
    beyond = (cloth.valid & ~cloth.mesh.pixels_of(found.cells)).astype(np.float32)
    across = 2 * round(REACH * cloth.side_px) + 1
    room = cv2.boxFilter(beyond, -1, (across, across), normalize=False, borderType=cv2.BORDER_CONSTANT)
    return bool(room.max() > LIKELY * BLOCK_PX**2)


def match(cloth: FittedCloth, found: Fit) -> Matches:
    """Return the keypoints beyond the followed cloth that look like one on it, and what that says of them."""
    keypoints = cloth.canvas.keypoints
    column, row = (
        np.clip((keypoints.points + 0.5) // cloth.mesh.cell, 0, np.array(cloth.mesh.cells[::-1]) - 1).astype(int).T
    )
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
