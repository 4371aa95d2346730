"""The deformation on a grid of the caller's choice: live while targets are dragged, and the final one.

A field u on a rectangle of nodes is read at the crossings of rows y_i and columns x_j. Bilinear reading is separable:
with the hat weights Y (R', R) of the rows and X (C', C) of the columns it is Y u X'.
"""

import cv2
import numpy as np
import scipy

from core import tracing
from core.arrays import Bools, Floats, Points
from core.curves.feature_curves import FeatureCurve
from core.linalg.dirichlet_grid import DirichletGrid, Responses
from core.retexture.deformation.diffusion import HOLD, Diffusion, motion

NODES = 24_000
"""Of the live grid, about as many as the editor draws."""
CLOSEST_PX = 2.0
MOST_POINTS = 260
"""Curves are held at about so many points at most while they are dragged, otherwise one in a cell."""


class Reading:
    """Reads fields of nodes, `step` px apart, at the crossings of columns `x` (C',) and rows `y` (R',)."""

    def __init__(self, shape: tuple[int, int], step: float, x: Floats, y: Floats) -> None:
        self._down, self._across = _hats(y / step, shape[0]), _hats(x / step, shape[1])

    def of(self, field: Floats) -> Floats:
        """Return a field (R, C, d) at the crossings (R', C', d)."""
        rows, columns, channels = field.shape
        down = (self._down @ field.reshape(rows, -1)).reshape(-1, columns, channels)
        across = self._across @ down.transpose(1, 0, 2).reshape(columns, -1)
        return np.ascontiguousarray(across.reshape(self._across.shape[0], -1, channels).transpose(1, 0, 2))


def _hats(places: Floats, count: int) -> "scipy.sparse.csr_matrix":
    """Return the weights (n, count) that read a row of `count` nodes at `places` (n,), held at its ends."""
    places = np.clip(places, 0, count - 1)
    first = np.minimum(places.astype(int), max(count - 2, 0))
    share = places - first
    number = np.arange(len(places))
    second = np.minimum(first + 1, count - 1)
    weights = np.concatenate([1 - share, share])
    return scipy.sparse.csr_matrix(
        (weights, (np.tile(number, 2), np.concatenate([first, second]))), (len(places), count)
    )


class Membrane:
    """A membrane over (rows, columns) nodes, 0 on its border, held at points: no factor, whatever the points are.

    With K the graph Laplacian of the nodes, B the bilinear weights at the points and w how hard they are held,
    Woodbury's identity turns the large system into one as large as there are points:

        (K + B'WB) u = B'W v    <=>    u = K^-1 B'q,    (S + W^-1) q = v,    S = B K^-1 B'.
    """

    def __init__(self, rows: int, columns: int) -> None:
        self.shape = (rows, columns)
        self._grid = DirichletGrid(rows, columns)
        self._responses = Responses(self._grid)

    def hold(self, places: Points, values: Floats, hold: Floats) -> Floats:
        """Return the field (rows, columns, d) that is about `values` (n, d) at `places` (n, 2).

        Places are (x, y) in cells, within the grid; `hold` (n,) is how hard each value is held, against an edge of the
        grid.
        """
        matrix = self._responses.between(places)
        matrix[np.diag_indices_from(matrix)] += 1 / hold
        charges = scipy.linalg.solve(matrix, values, assume_a="pos", overwrite_a=True, check_finite=False)
        field = self._grid.spread(self._grid.loads_at(places), charges.T, 0.0)
        return np.ascontiguousarray(np.moveaxis(field, 0, -1))


class LiveDeformation:
    """The deformation of a picture of `shape` (H, W) at the nodes (R', C', 2) of a regular grid, frame by frame.

    It is the final one (DPD sec. 3.1) on a coarser grid: anchored at the targets, so that the picture does not jump
    when the artist lets go. Nothing in it depends on the curves but one small dense system.
    """

    def __init__(self, shape: tuple[int, int], nodes: Points, *, reach_px: float | None = None) -> None:
        self._shape, self._reach_px = shape, reach_px
        self._step = space_out(shape)
        rows, columns = (cells + 1 for cells in _cells(shape, self._step))
        self._membrane = Membrane(rows, columns)
        self._nodes = nodes
        self._reading = Reading((rows, columns), self._step, nodes[0, :, 0], nodes[:, 0, 1])

    def solve(self, curves: list[FeatureCurve]) -> Points:
        """Return the places (R', C', 2) of the picture that are shown at the nodes."""
        source, target = motion(curves, self._step)
        inside = ((target > 0) & (target < np.array(self._shape[::-1]) - 1)).all(axis=1)
        source, target, spacing = _thin(source[inside], target[inside], self._step)
        if not len(target):
            return self._nodes
        places, values = target / self._step, source - target
        with tracing.span("solve", points=len(places)):
            field = self._solve(places, values, HOLD * spacing)
        return np.asarray(self._nodes + self._reading.of(field))

    def _solve(self, places: Points, values: Floats, hold: float) -> Floats:
        """Return D at the nodes of the membrane for its `values` (n, 2) at `places` (n, 2), in cells."""
        if self._reach_px is None:
            return self._membrane.hold(places, values, np.full(len(places), hold))
        free = _near(places, self._membrane.shape, self._reach_px / self._step)
        ring = np.argwhere(_ring_around(free))[:, ::-1].astype(float)
        places, values = np.concatenate([places, ring]), np.concatenate([values, np.zeros((len(ring), 2))])
        return np.asarray(self._membrane.hold(places, values, np.full(len(places), hold)) * free[..., None])


def space_out(shape: tuple[int, int]) -> float:
    """Return the distance in px of about `NODES` nodes over a picture of `shape`.

    Nodes two pixels apart, of small pictures, are those of the final deformation, and stay.
    """
    return max(float(np.sqrt(shape[0] * shape[1] / NODES)), CLOSEST_PX)


def _cells(shape: tuple[int, int], step: float) -> tuple[int, int]:
    """Return how many cells of a grid are above each other, and beside each other."""
    return max(int(np.ceil((shape[0] - 1) / step)), 2), max(int(np.ceil((shape[1] - 1) / step)), 2)


def _thin(source: Points, target: Points, step: float) -> tuple[Points, Points, float]:
    """Return corresponding points about `step` px apart at the target, or farther where they are too many; how far."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(target, axis=0).T))]) if len(target) else np.empty(0)
    spacing = max(step, float(along[-1]) / MOST_POINTS) if len(along) else step
    marks = along // spacing
    kept = np.concatenate([marks[:1] >= 0, marks[1:] > marks[:-1]])
    return source[kept], target[kept], spacing


def _near(places: Points, shape: tuple[int, int], reach: float) -> Bools:
    """Return which nodes lie within `reach` cells of `places` (n, 2), in cells."""
    apart = np.ones(shape, np.uint8)
    column, row = np.rint(places).astype(int).T
    apart[row, column] = 0
    return np.asarray(cv2.distanceTransform(apart, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) < max(reach, 1.0))


def _ring_around(free: Bools) -> Bools:
    """Return nodes just outside `free` ones, every second of them, off the border: enough to hold a membrane."""
    wider = cv2.dilate(free.astype(np.uint8), cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))) > 0
    ring = wider & ~free
    ring[[0, -1]] = ring[:, [0, -1]] = False
    row, column = np.indices(free.shape)
    return np.asarray(ring & ((row + column) % 2 == 0))


def pull(grid: Diffusion, field: Floats, nodes: Points) -> Points:
    """Return the places (R', C', 2) of the picture that the final deformation shows at the nodes of a regular grid."""
    reading = Reading((grid.rows, grid.columns), grid.step, nodes[0, :, 0], nodes[:, 0, 1])
    return np.asarray(nodes + reading.of(field))
