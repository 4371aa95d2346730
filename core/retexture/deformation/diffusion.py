"""Deformation by diffusion: the motion of feature curves spread over the picture by Laplace's equation (DPD sec. 3.1).

On a grid of nodes a few pixels apart, with G the differences along its edges and B the bilinear weights that read the
grid at points of the curves, the field u minimises

    |G u|^2 + w |B u - v|^2,    u = 0 on the picture's border (and beyond a chosen distance of the curves)

so that (G'G + w B'B) u = w B'v. The matrix depends on where the curves' points are, not on the values v they carry.
"""

from typing import NamedTuple

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.curves.bezier import pair_parameters
from core.curves.feature_curves import FeatureCurve
from core.linalg.factor import Entries, Factor
from core.linalg.nearest import Nearest
from core.tracing import span

NODES = 40_000
"""Nodes of the default grid."""
HOLD = 100.0
"""Weight w of a curve's point against one edge of the grid: it is met to about a hundredth of a pixel."""


class Diffusion:
    """Diffuse values given at points over a picture; factor once per set of points, solve once per set of values."""

    def __init__(
        self, shape: tuple[int, int], points: Points, *, reach_px: float | None = None, nodes: int = NODES
    ) -> None:
        height, width = shape
        self.shape = shape
        self.step = max(2.0, float(np.sqrt(height * width / nodes)))
        """Distance of neighbouring nodes in px; node (r, c) lies at pixel (step c, step r)."""
        self.rows, self.columns = (int(np.ceil((n - 1) / self.step)) + 1 for n in shape)
        inside = ((points > 0) & (points < np.array([width - 1, height - 1]))).all(axis=1)
        self._used = inside
        free = self._free_nodes(points, reach_px)
        self._free = np.flatnonzero(free.ravel())
        self._reading = _bilinear(points[inside] / self.step, self.rows, self.columns)
        self._factor = Factor(_system(free, self._reading))

    def solve(self, values: Floats) -> Floats:
        """Return the field (R, C, d) at the nodes for `values` (n, d) at the points."""
        with span("rhs"):
            right = HOLD * self._reading.spread(values[self._used], self.rows * self.columns)
        field = np.zeros((self.rows * self.columns, values.shape[1]))
        with span("solve"):
            field[self._free] = self._factor.solve(right[self._free])
        return field.reshape(self.rows, self.columns, -1)

    def at_pixels(self, field: Floats | Singles, window: tuple[slice, slice] | None = None) -> Singles:
        """Return a field (R, C, d) of the nodes, d at most 4, at every pixel of `window` (rows, columns)."""
        rows, columns = window or (slice(0, self.shape[0]), slice(0, self.shape[1]))
        scale = 1 / self.step
        to_nodes = np.array([[scale, 0, columns.start * scale], [0, scale, rows.start * scale]])
        size = columns.stop - columns.start, rows.stop - rows.start
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        nodes = field.astype(np.float32)
        dense = cv2.warpAffine(nodes, to_nodes, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(dense, np.float32).reshape(size[1], size[0], -1)

    def at(self, field: Floats, places: Points) -> Floats:
        """Return a field (R, C, d) of the nodes at `places` (n, 2), those outside the picture as at its border."""
        limit = np.array([self.columns - 1, self.rows - 1])
        reading = _bilinear(np.clip(places / self.step, 0, limit), self.rows, self.columns)
        return reading.of(field.reshape(self.rows * self.columns, -1))

    @property
    def nodes(self) -> Points:
        """(R, C, 2) positions of the nodes in the picture."""
        x, y = np.meshgrid(np.arange(self.columns) * self.step, np.arange(self.rows) * self.step)
        return np.stack([x, y], axis=-1)

    def _free_nodes(self, points: Points, reach_px: float | None) -> Bools:
        free = np.zeros((self.rows, self.columns), bool)
        free[1:-1, 1:-1] = True
        if reach_px is not None and len(points):
            distance, _ = Nearest(points).to(self.nodes.reshape(-1, 2))
            free &= np.reshape(distance < reach_px, free.shape)
        return free


class CoarseReading(NamedTuple):
    """B: how n values come about from those at four nodes each."""

    nodes: Ints
    """(4, n)."""
    weights: Floats
    """(4, n)."""

    def of(self, values: Floats) -> Floats:
        """Return B u (n, d) for `values` u (m, d) at the nodes."""
        parts = (weight[:, None] * values.take(node, axis=0) for node, weight in zip(*self, strict=True))
        return np.asarray(sum(parts))

    def spread(self, values: Floats, count: int) -> Floats:
        """Return B'v (count, d) for `values` v (n, d)."""
        nodes = self.nodes.ravel()
        loads = (self.weights[..., None] * values).reshape(len(nodes), -1)
        return np.column_stack([np.bincount(nodes, load, count) for load in loads.T])


def _bilinear(positions: Points, rows: int, columns: int) -> CoarseReading:
    """Return what reads a flattened grid at `positions` (n, 2), in cells."""
    corner = np.clip(np.floor(positions).astype(int), 0, [columns - 2, rows - 2])
    u, v = (positions - corner).T
    first = corner[:, 1] * columns + corner[:, 0]
    weights = np.stack([(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v])
    return CoarseReading(np.stack([first, first + 1, first + columns, first + columns + 1]), weights)


def _system(free: Bools, reading: CoarseReading) -> Entries:
    """Return G'G + w B'B for the `free` nodes (R, C), the others being held at 0."""
    number = np.full(free.shape, -1)
    number[free] = np.arange(np.count_nonzero(free))
    # All of them lie off the border, and have four edges.
    rows, columns, values = [number[free]], [number[free]], [np.full(np.count_nonzero(free), 4.0)]
    for here, there in ((number[:, :-1], number[:, 1:]), (number[:-1], number[1:])):
        both = (here >= 0) & (there >= 0)
        rows.append(there[both])
        columns.append(here[both])
        values.append(np.full(len(rows[-1]), -1.0))
    read = number.ravel()[reading.nodes]
    # Of a point's nodes the later have the higher numbers: these are the pairs on and below the diagonal.
    for i in range(4):
        for j in range(i + 1):
            both = (read[i] >= 0) & (read[j] >= 0)
            rows.append(read[i][both])
            columns.append(read[j][both])
            values.append(HOLD * (reading.weights[i] * reading.weights[j])[both])
    return Entries(np.concatenate(rows), np.concatenate(columns), np.concatenate(values), len(rows[0]))


def motion(curves: list[FeatureCurve], step: float) -> tuple[Points, Points]:
    """Return corresponding points (n, 2) of all active curves, at the source and at the target."""
    pairs = [(c.source, c.target, *pair_parameters(c.source, c.target, step=step)) for c in curves if c.target]
    if not pairs:
        return np.empty((0, 2)), np.empty((0, 2))
    return (
        np.concatenate([source.at(s) for source, _, s, _ in pairs]),
        np.concatenate([target.at(t) for _, target, _, t in pairs]),
    )


def deformation(
    shape: tuple[int, int], curves: list[FeatureCurve], *, reach_px: float | None = None
) -> tuple[Diffusion, Floats]:
    """Return D at the nodes of a grid: the way from a target pixel to its source (DPD eq. 1)."""
    source, target = motion(curves, 1.0)
    grid = Diffusion(shape, target, reach_px=reach_px)
    return grid, grid.solve(source - target)


def compression(grid: Diffusion, field: Floats) -> Floats:
    """Return the Lipschitz constant at the nodes (R, C), from 1 to 3, of the map q + D(q) to the source.

    DPD eq. 4 and sec. 3.5, with D read as the place it leads to: a mere turn or shift compresses nothing.
    """
    place = grid.nodes + field
    most = np.zeros(field.shape[:2])
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        here = place[: place.shape[0] - down, max(-right, 0) : place.shape[1] - max(right, 0)]
        there = place[down:, max(right, 0) : place.shape[1] - max(-right, 0)]
        slope = np.linalg.norm(there - here, axis=-1) / (grid.step * np.hypot(down, right))
        for part in (
            most[: field.shape[0] - down, max(-right, 0) : field.shape[1] - max(right, 0)],
            most[down:, max(right, 0) : field.shape[1] - max(-right, 0)],
        ):
            np.maximum(part, slope, out=part)
    return np.clip(most, 1, 3)


def distortion(grid: Diffusion, field: Floats) -> Floats:
    """Return at the nodes (R, C) how far the deformation is from rigid: the larger |log| of its two stretches.

    The stretches are the singular values of J = I + dD, with s1^2 + s2^2 = |J|^2 and s1 s2 = |det J|.
    """
    right, down = np.gradient(field, grid.step, axis=1), np.gradient(field, grid.step, axis=0)
    a, b, c, d = right[..., 0] + 1, down[..., 0], right[..., 1], down[..., 1] + 1
    plus, minus = np.hypot(a + d, c - b), np.hypot(a - d, c + b)
    most, least = (plus + minus) / 2, np.abs(plus - minus) / 2
    return np.asarray(np.maximum(np.abs(np.log(np.maximum(most, 1e-3))), np.abs(np.log(np.maximum(least, 1e-3)))))
