"""A surface laid flat with its angles kept: what is undistorted in the chart is undistorted on the surface.

With M the symmetric square root of the metric J'J of a surface over its texture, and zeta = M q the plane of a small
triangle of it, a map f from the texture to the complex plane has the derivatives f_zeta and f_zetabar there. It keeps
angles where f_zetabar = 0 [least squares conformal maps, Levy et al. 2002], and lengths where f_zeta = exp i theta
besides. Of all maps that keep angles, the one that changes lengths least is sought: with A the triangles' areas,

    E = sum A (|f_zetabar|^2 + LENGTHS |f_zeta - exp i theta|^2),

whose theta is the angle of f_zeta: each round solves for f and takes its angles [local/global, Liu et al. 2008]. One
factor serves all rounds.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import cv2
import numpy as np

from core.arrays import Floats, InputError, Points, SingularSystemError, readonly
from core.grid import Grid
from core.linalg.factor import Factor
from core.linalg.pairs import solve_pairs

if TYPE_CHECKING:
    from scipy.interpolate import RectBivariateSpline

LENGTHS = 1e-4
"""How much lengths count beside angles."""
SAMPLES = 4
"""The metric is read in so many places of a quad each way."""
ROUNDS = 40
STEADY = 1e-6
"""The last round is that in which no angle changes by more."""
STEPS, FOUND = 20, 1e-12
"""Steps of Newton's method from the nearest node of a chart to a place in it, and the one that is the last."""


@dataclass(frozen=True, eq=False)
class Chart:
    """A surface laid flat."""

    places: Points
    """(n + 1, n + 1, 2) where an even grid over the texture lies; its least x and y are 0, and its area is 1."""

    def size_px(self, size_px: tuple[int, int]) -> tuple[int, int]:
        """Return width and height of the box around the chart, with about as many pixels as a picture of `size_px`."""
        width, height = self.places.max(axis=(0, 1)) * np.sqrt(size_px[0] * size_px[1])
        return max(1, round(width)), max(1, round(height))

    def warp(self, size_px: tuple[int, int]) -> Callable[[Points], Points]:
        """Return the warp of a picture of `size_px` into the chart's box, both in pixels."""
        scale = np.array(self.size_px(size_px)) / self.places.max(axis=(0, 1))

        def warp(points: Points) -> Points:
            return np.asarray(self.at((points + 0.5) / size_px) * scale - 0.5)

        return warp

    def at(self, share: Points, *, across: int = 0, down: int = 0) -> Points:
        """Return where places of the texture (..., 2), shares of it, lie; or the derivatives so often each way."""
        x, y = np.clip(share[..., 0], 0, 1).ravel(), np.clip(share[..., 1], 0, 1).ravel()
        found = [spline.ev(y, x, dx=down, dy=across) for spline in self._splines]
        return np.stack(found, axis=-1).reshape(share.shape)

    def on_raster(self, count: int) -> Points:
        """Return where an even raster of `count` places a side over the texture lies, (count, count, 2)."""
        even = np.linspace(0, 1, count)
        return np.stack([spline(even, even) for spline in self._splines], axis=-1)

    def texture_at(self, places: Points) -> Points:
        """Return which places of the texture (..., 2), shares of it, lie at places of the chart; its border beyond."""
        from scipy.spatial import cKDTree

        wanted = places.reshape(-1, 2)
        count = self.places.shape[0]
        _, nearest = cKDTree(self.places.reshape(-1, 2)).query(wanted)
        share = np.stack(np.divmod(nearest, count)[::-1], axis=-1) / (count - 1)
        for _ in range(STEPS):
            step = solve_pairs(self.at(share, across=1), self.at(share, down=1), wanted - self.at(share))
            before, share = share, np.clip(share + np.clip(step, -2 / count, 2 / count), 0, 1)
            if np.abs(share - before).max(initial=0) < FOUND:
                break
        return np.asarray(share.reshape(places.shape))

    @cached_property
    def _splines(self) -> "tuple[RectBivariateSpline, ...]":
        from scipy.interpolate import RectBivariateSpline

        even = np.linspace(0, 1, len(self.places))
        return tuple(RectBivariateSpline(even, even, self.places[..., i]) for i in (0, 1))


def flatten(stretch_at: Callable[[Points], Floats], cells: int) -> Chart:
    """Return the chart of a surface by `cells` x `cells` of its texture.

    `stretch_at` returns M (k, 2, 2) at places of the texture (k, 2). Where it changes so abruptly that the chart would
    fold, as between parts of a texture that do not belong together, it is averaged over ever larger surroundings.
    """
    grid = Grid(cells, cells, cell_px=1)
    nodes = ((grid.nodes + 0.5) / cells).reshape(-1, 2)
    # The mean over each quad, since a mesh has facets.
    within = (np.stack(np.divmod(np.arange(SAMPLES**2), SAMPLES), axis=-1) + 0.5) / (SAMPLES * cells)
    samples = nodes[grid.quads[:, :1]] + within
    stretch = stretch_at(samples.reshape(-1, 2)).reshape(cells, cells, SAMPLES**2, 4).mean(axis=2)
    for around in (0.0, *2.0 ** np.arange(np.log2(cells))):
        smooth = cv2.GaussianBlur(stretch, (0, 0), around, borderType=cv2.BORDER_REPLICATE) if around else stretch
        places = _solve(nodes, grid, np.asarray(smooth, np.float64).reshape(-1, 2, 2))
        if places is not None:
            return Chart(readonly(places))
    places = _solve(nodes, grid, np.broadcast_to(stretch.mean(axis=(0, 1)).reshape(2, 2), (cells**2, 2, 2)))
    if places is None:
        raise InputError("surface: cannot be laid flat")
    return Chart(readonly(places))


def _solve(nodes: Points, grid: Grid, stretch: Floats) -> Points | None:
    """Return `Chart.places` of nodes (n, 2) for M (k, 2, 2) of the quads; None where the chart would fold."""
    # The editor starts without SciPy, which takes longer to load than most of it.
    from scipy import sparse

    side, triangles = grid.columns, grid.triangles
    corners = nodes[triangles]
    # Two triangles of a quad follow one another, and share its metric.
    flat = np.einsum("tij,tkj->tki", stretch.repeat(2, axis=0), corners - corners[:, :1])
    zeta = flat[..., 0] + 1j * flat[..., 1]
    opposite = zeta[:, [2, 0, 1]] - zeta[:, [1, 2, 0]]
    area = (np.conj(zeta[:, 1] - zeta[:, 0]) * (zeta[:, 2] - zeta[:, 0])).imag / 2
    slope = (1j * opposite / (4 * area[:, None])).ravel()
    where = np.repeat(np.arange(len(area)), 3), triangles.ravel()
    sheared, turned = (sparse.csr_array((part, where), (len(area), side**2)) for part in (slope, slope.conj()))
    skewed = sparse.csr_array((sheared[::2] + sheared[1::2]) / 2)
    of_quads, of_triangles = (sparse.diags_array(part / area.sum()) for part in (area[::2] + area[1::2], area))
    held = LENGTHS * turned.conj().T @ of_triangles
    system = skewed.conj().T @ of_quads @ skewed + held @ turned
    # The middle stays, or all could be shifted.
    free = np.delete(np.arange(side**2), side**2 // 2)
    try:
        factor = Factor(sparse.csc_array(system[free][:, free]))
    except SingularSystemError:
        return None
    place, turn = np.zeros(side**2, complex), np.ones(len(area), complex)
    for _ in range(ROUNDS):
        place[free] = factor.solve((held @ turn)[free])
        before, along = turn, turned @ place
        turn = along / np.maximum(np.abs(along), 1e-300)
        if np.abs(turn - before).max() < STEADY:
            break
    corner = place[triangles]
    covered = (np.conj(corner[:, 1] - corner[:, 0]) * (corner[:, 2] - corner[:, 0])).imag / 2
    if not (covered > 0).all():
        return None
    places = np.stack([place.real, place.imag], axis=-1).reshape(side, side, 2)
    return np.asarray((places - places.min(axis=(0, 1))) / np.sqrt(covered.sum()))
