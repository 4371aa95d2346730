"""The same mapping on a grid of larger cells, where a search takes little time, and the way back."""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from core.arrays import Floats, Ints
from core.grid import Features, Grid
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.frames import Complexes, as_complex
from core.progress import Job, T, stepwise

_CELLS = 3
"""So many cells are taken as one, along either side."""
_ROUNDING = 1e-9
_NODES_AT_LEAST = 3000
"""Smaller grids are searched themselves."""


class Coarser:
    """A mapping of the same features on fewer nodes; features that no longer have a shape there are left out.

    Where they are `covered`, every fine node of a feature lies between coarse ones of it. What folds nothing there then
    folds nothing when it is lifted, where features are not close to each other. With the `same_outline`, every fine
    outline node outside features lies between coarse ones outside.
    """

    def __init__(
        self, fine: FeatureMapping, *, covered: bool = False, same_outline: bool = False, cells: float = _CELLS
    ) -> None:
        self._fine = fine
        self._covered = covered
        grid = fine.grid
        self.grid = Grid(grid.width_px, grid.height_px, cell_px=cells * float(np.sqrt(grid.cell[0] * grid.cell[1])))
        self._nodes, self._weights = grid.weights_at(self.grid.nodes.reshape(-1, 2))
        labels = self._covering() if covered else self._nearest()
        if same_outline:
            labels.ravel()[self._beside(np.flatnonzero(grid.outline & (fine.index < 0)))] = 0
        self.mapping = FeatureMapping(self.grid, Features(labels), keep=fine.keep, method=fine.method)

    def _nearest(self) -> NDArray[np.int32]:
        """Return the label of the fine node nearest to each coarse one."""
        labels = self._labels()
        nearest = np.take_along_axis(self._nodes, self._weights.argmax(axis=1)[:, None], axis=1)
        return np.asarray(labels[nearest].reshape(self.grid.shape))

    def _labels(self) -> NDArray[np.int32]:
        """Return the labels (N,) of the features that have a shape on the fine grid."""
        return np.asarray(np.where(self._fine.index >= 0, self._fine.features.labels, 0).ravel())

    def _covering(self) -> NDArray[np.int32]:
        """Return for each coarse node the label of a fine one that lies in a cell beside it."""
        labels = self._labels()
        inside = np.flatnonzero(labels)
        nodes, weights = self.grid.weights_at(self._fine.grid.nodes.reshape(-1, 2)[inside])
        found = np.zeros(self.grid.size, labels.dtype)
        beside = weights > _ROUNDING
        found[nodes[beside]] = np.broadcast_to(labels[inside, None], nodes.shape)[beside]
        return found.reshape(self.grid.shape)

    def _beside(self, fine: Ints) -> Ints:
        """Return the coarse nodes between which some fine ones lie."""
        nodes, weights = self.grid.weights_at(self._fine.grid.nodes.reshape(-1, 2)[fine])
        return np.unique(nodes[weights > _ROUNDING])

    def at_nodes(self, z: Complexes) -> Complexes:
        """Return a mapping of the fine grid at the coarse nodes."""
        return np.asarray((z.ravel()[self._nodes] * self._weights).sum(axis=1).reshape(self.grid.shape))

    def placed(self, coarse_w: Complexes, found: Solution) -> Solution:
        """Return on the coarse grid features where `found` has them on the fine one, and free nodes as they follow."""
        fine = self._fine
        number = {body.number: i for i, body in enumerate(fine.bodies)}
        rest, coarse_rest = as_complex(fine.grid.nodes).ravel(), as_complex(self.grid.nodes).ravel()
        same = [number[body.number] for body in self.mapping.bodies]
        alpha, t = found.alpha[same], found.t[same]
        for j, (i, body) in enumerate(zip(same, self.mapping.bodies, strict=True)):
            t[j] += alpha[j] * (coarse_rest[body.nodes].mean() - rest[fine.bodies[i].nodes].mean())
        return self.mapping.place_at(coarse_w, alpha, t)

    def between(self, w: Complexes, coarse_w: Complexes, z: Complexes) -> Complexes:
        """Return where coarse nodes at z take all fine ones (R, C), those of features too, given W on both."""
        return np.asarray(w + self._bilinear(z - coarse_w))

    def lifted(self, w: Complexes, found: Solution, linear: Solution, *, released: bool) -> Solution:
        """Return on the fine grid what was `found` on the coarse one; features left out are as in `linear`."""
        fine, coarse = self._fine, self.mapping
        refined = self._bilinear if released or self._covered else self._bicubic
        z = w + refined(found.z - self.at_nodes(w))
        stays = fine.grid.outline & (np.abs(z - w) < _ROUNDING * np.ptp(w.real) if released else True)
        z[stays] = w[stays]
        alpha, t = linear.alpha.copy(), linear.t.copy()
        number = {body.number: i for i, body in enumerate(coarse.bodies)}
        rest, coarse_rest = as_complex(fine.grid.nodes).ravel(), as_complex(self.grid.nodes).ravel()
        for i, body in enumerate(fine.bodies[: len(alpha)]):
            j = number.get(body.number, len(found.alpha))
            if j < len(found.alpha):
                moved = rest[body.nodes].mean() - coarse_rest[coarse.bodies[j].nodes].mean()
                alpha[i], t[i] = found.alpha[j], found.t[j] + found.alpha[j] * moved
            else:
                t[i] = z.ravel()[body.nodes].mean()
            z.ravel()[body.nodes] = body.place(alpha[i], t[i])
        return Solution(z, alpha, t)

    def _bilinear(self, away: Complexes) -> Complexes:
        """Interpolate displacements of the coarse nodes at the fine ones, which folds nothing that was not."""
        nodes, weights = self.grid.weights_at(self._fine.grid.nodes.reshape(-1, 2))
        return np.asarray((away.ravel()[nodes] * weights).sum(axis=1).reshape(self._fine.grid.shape))

    def _bicubic(self, away: Complexes) -> Complexes:
        """Interpolate displacements of the coarse nodes at the fine ones smoothly."""
        rows, columns = (_places(n, m) for n, m in zip(self._fine.grid.shape, self.grid.shape, strict=True))
        u, v = np.meshgrid(columns, rows)
        parts = [
            cv2.remap(part.astype(np.float32), u, v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
            for part in (away.real, away.imag)
        ]
        return np.asarray(parts[0].astype(np.float64) + 1j * parts[1])


def _places(count: int, coarse: int) -> NDArray[np.float32]:
    """Return where `count` nodes lie among `coarse` nodes over the same length."""
    places: Floats = np.linspace(0, coarse - 1, count)
    return places.astype(np.float32)


def is_large(mapping: FeatureMapping) -> bool:
    """Return whether a search is to begin on a coarser grid."""
    return mapping.grid.size > _NODES_AT_LEAST


def unseen(job: Job[T]) -> Job[T]:
    """Run `job` without its previews, which are of another grid."""
    return stepwise(job, lambda step: replace(step, preview=None))
