"""Where further pieces of a cloth begin: at keypoints that look like those of cloth that is followed already.

A keypoint on cloth has texture coordinates. One beyond it that looks alike [Lowe 2004] is at the same place of a texel,
and its direction and size say how the cloth lies there. What its neighbours say has to agree with that, but for whole
texels, far more often than by chance. So sleeves are found whose texels are large, of which no lattice grows.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Bools, Floats, Points
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

    def agreeing(self, at: Points, uv: Points, slopes: Floats) -> tuple[Bools, Bools]:
        """Return which (k, n) are near each of k places (k, 2), and which of them lie as `uv` and `slopes` foretell."""
        away = self.points - at[:, None]
        missed = self.uv - uv[:, None] - np.einsum("kij,knj->kni", slopes, away)
        missed = (missed - np.rint(missed)) @ self.basis.T
        near = np.asarray(np.linalg.norm(away, axis=-1) < REACH * self.side_px, np.bool_)
        return near, near & (np.linalg.norm(missed, axis=-1) < OFF * self.side_px)


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


def agreement(matches: Matches) -> tuple[Floats, Bools]:
    """Return by how many standard deviations (n,) those that agree with a match surpass chance, and which (n, n) do.

    Those that lie in one block are one motif, and count once.
    """
    near, agree = matches.agreeing(matches.points, matches.uv, matches.slopes)
    places = (matches.points // BLOCK_PX).astype(np.int64)
    blocks, block = np.unique(places, axis=0, return_inverse=True)
    member = np.eye(len(blocks), dtype=np.float32)[block.ravel()]
    seen, asked = (((which.astype(np.float32) @ member) > 0).sum(1).astype(np.float32) for which in (agree, near))
    return np.asarray(surplus(seen, asked * np.float32(np.pi * OFF**2)), np.float64), agree


def state_around(cloth: FittedCloth, matches: Matches, best: int, agree: Bools) -> ClothState:
    """Return coordinates that agree with a match and those (n,) that agree with it, near which they count."""
    at, uv, lie = matches.points[best], matches.uv[best], matches.slopes[best]
    for _ in range(ROUNDS):
        # A few in a row say nothing of the slopes across it: what the first one says counts as much as one a side away.
        away, whole = matches.points[agree] - at, matches.uv[agree] - uv
        whole -= np.rint(whole - away @ lie.T)
        rows = np.concatenate([np.column_stack([away, np.ones(len(away))]), matches.side_px * np.eye(2, 3)])
        targets = np.concatenate([whole, matches.side_px * lie.T])
        change = np.linalg.lstsq(rows, targets, rcond=None)[0]
        lie, uv = change[:2].T, uv + change[2]
        agree = matches.agreeing(at[None], uv[None], lie[None])[1][0]
    _, cells = cloth.near_points(matches.points[agree])
    return ClothState(uv + (cloth.mesh.positions() - at) @ lie.T, cloth.brightness, cells)
