"""Which way up a further piece of cloth lies.

A pattern that looks the same when it is turned does not say: a piece may be followed upside down, and another texture
would lie so too. Where the texel turned and moved is the texel, a piece lies as the cloth nearest to it does.
"""

from dataclasses import replace

import numpy as np

from core.arrays import Floats
from core.overlay.filters.distances import distance
from core.overlay.mesh import ClothMesh
from core.overlay.registration.registration import ClothState
from core.overlay.texel import Texel

QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])
TURNS = -np.eye(2), QUARTER, QUARTER.T
"""Turns that take whole texels to whole texels."""
ALIKE = 0.93
"""Correlation of a texel with itself turned from which it looks the same."""
SAMPLES = 64
"""Places along a side of the texel at which the two are compared."""
BLUR = 0.03
"""Blur, over the side of a texel, under which they are."""


def turned(
    mesh: ClothMesh, state: ClothState, others: tuple[ClothState, ...], texel: Texel, scale: Floats
) -> ClothState:
    """Return a piece turned to lie as the nearest of the others does, if the texture looks the same then.

    `scale` (2, 2) is pixels a texel.
    """
    own, beside = scale @ slopes(mesh, state).mean(0), scale @ slopes_beside(mesh, state, others)
    soft = texel.blurred(BLUR * float(np.sqrt(abs(np.linalg.det(scale)))), scale)
    best, agreement = state, float((own * beside).sum())
    for turn in TURNS:
        lying = float((scale @ turn @ np.linalg.inv(scale) @ own * beside).sum())
        if lying > agreement:
            alike, shift = symmetry(soft, turn)
            if alike > ALIKE:
                best, agreement = replace(state, uv=state.uv @ turn.T + shift), lying
    return best


def slopes(mesh: ClothMesh, state: ClothState) -> Floats:
    """Return the slopes (K, 2, 2) of the coordinates by x and y in the cells in use."""
    corners = state.uv.reshape(-1, 2)[mesh.corners[state.cells]]
    across, down = corners[:, 1::2] - corners[:, ::2], corners[:, 2:] - corners[:, :2]
    return np.asarray(np.stack([across.mean(1), down.mean(1)], -1) / mesh.cell, np.float64)


def slopes_beside(mesh: ClothMesh, state: ClothState, others: tuple[ClothState, ...]) -> Floats:
    """Return the mean slopes (2, 2) of other pieces, the nearer to a piece's cells the more they count."""
    away = distance(state.cells)
    weights = np.concatenate([1 / np.maximum(away[other.cells], 1.0) ** 2 for other in others])
    return np.asarray(np.average(np.concatenate([slopes(mesh, other) for other in others]), 0, weights), np.float64)


def symmetry(texel: Texel, turn: Floats) -> tuple[float, Floats]:
    """Return the correlation of T(N u + c) with T(u) for the turn N (2, 2), and the c (2,) for which it is highest."""
    t = (np.arange(SAMPLES) + 0.5) / SAMPLES
    at = np.stack(np.meshgrid(t, t), -1)
    own, other = (np.fft.fft2(texel(places), axes=(0, 1)) for places in (at, at @ turn.T))
    own[0, 0] = other[0, 0] = 0
    common = np.fft.ifft2(own.conj() * other, axes=(0, 1)).real.sum(-1) * SAMPLES**2
    row, column = np.unravel_index(common.argmax(), common.shape)
    alike = common.max() / max(float(np.linalg.norm(own) * np.linalg.norm(other)), 1e-12)
    return float(alike), np.asarray(turn @ np.array([column, row]) / SAMPLES, np.float64)
