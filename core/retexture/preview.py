"""The deformation on a grid of the caller's choice: live while targets are dragged, and the final one.

A field u on the diffusion's nodes is read at the crossings of rows y_i and columns x_j. Bilinear reading is separable:
with the hat weights Y (R', R) of the rows and X (C', C) of the columns it is Y u X'.
"""

import numpy as np
import scipy.sparse as sp

from core.arrays import Floats, Points
from core.feature_curves import FeatureCurve
from core.retexture.diffusion import Diffusion, LivePreview

NODES = 24_000
"""Of the live grid, about as many as the editor draws."""


class Reading:
    """Reads a diffusion's fields at the crossings of columns `x` (C',) and rows `y` (R',), in pixels."""

    def __init__(self, grid: Diffusion, x: Floats, y: Floats) -> None:
        self._across, self._down = _hats(x / grid.step, grid.columns), _hats(y / grid.step, grid.rows)

    def of(self, field: Floats) -> Floats:
        """Return a field (R, C, d) at the crossings (R', C', d)."""
        rows, columns, channels = field.shape
        down = (self._down @ field.reshape(rows, -1)).reshape(-1, columns, channels)
        across = self._across @ down.transpose(1, 0, 2).reshape(columns, -1)
        return np.ascontiguousarray(across.reshape(self._across.shape[0], -1, channels).transpose(1, 0, 2))


def _hats(places: Floats, count: int) -> sp.csr_matrix:
    """Return the weights (n, count) that read a row of `count` nodes at `places` (n,), held at its ends."""
    places = np.clip(places, 0, count - 1)
    first = np.minimum(places.astype(int), max(count - 2, 0))
    share = places - first
    number = np.arange(len(places))
    second = np.minimum(first + 1, count - 1)
    weights = np.concatenate([1 - share, share])
    return sp.csr_matrix((weights, (np.tile(number, 2), np.concatenate([first, second]))), (len(places), count))


class LiveDeformation:
    """Where the nodes (R', C', 2) of a regular grid go while targets are dragged; the sources stay as given."""

    def __init__(
        self, shape: tuple[int, int], curves: list[FeatureCurve], nodes: Points, *, reach_px: float | None = None
    ) -> None:
        self._preview = LivePreview(shape, curves, reach_px=reach_px, nodes=NODES)
        self._nodes = nodes
        self._reading = Reading(self._preview.grid, nodes[0, :, 0], nodes[:, 0, 1])

    def solve(self, curves: list[FeatureCurve]) -> Points:
        """Return the nodes' places when the active `curves` have these targets, in the order given before."""
        moved = self._preview.solve(curves) - self._preview.grid.nodes
        return np.asarray(self._nodes + self._reading.of(moved))


def pulled(grid: Diffusion, field: Floats, nodes: Points) -> Points:
    """Return the places (R', C', 2) of the picture that the final deformation shows at the nodes of a regular grid."""
    return np.asarray(nodes + Reading(grid, nodes[0, :, 0], nodes[:, 0, 1]).of(field))
