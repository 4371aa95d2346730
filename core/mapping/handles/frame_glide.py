"""How the nodes of a straight frame glide along its sides, beside features and with them."""

from dataclasses import dataclass

import numpy as np

from core.arrays import Floats, Ints, Points
from core.grid import SIDES, Grid
from core.linalg.factor import Factor
from core.linalg.laplacian import edge_weights, find_stored, laplacian, node_values, pattern
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.handles.free_plate import SMOOTH_NODES
from core.mapping.jacobians import Complexes


class FrameGlide:
    """How the nodes of a straight frame glide when features leave W, found on a few thousand nodes.

    A displacement from W that costs least, Σ |d u|², is harmonic: with u given on features, its part along x is
    0 on the left and right sides and free on the others, its part along y 0 on the others and free on these. The frame
    need not be at the least of that to more than a part of a cell, so that a coarse grid serves.
    """

    def __init__(self, mapping: FeatureMapping) -> None:
        fine = mapping.grid
        self._fine, self._index = fine, mapping.index
        self._grid = fine.with_nodes(SMOOTH_NODES)
        nodes, weights = fine.weights_at(self._grid.nodes.reshape(-1, 2))
        self._nearest = np.take_along_axis(nodes, weights.argmax(axis=1)[:, None], axis=1)[:, 0].reshape(
            self._grid.shape
        )
        body = mapping.index.ravel()[self._nearest] >= 0
        lower = pattern(self._grid.shape)
        self._edges = edge_weights(np.ones((self._grid.rows - 1, self._grid.columns - 1)))
        self._free, self._factors = [], []
        for across in (True, False):
            free = ~body
            free[(np.s_[:], [0, -1]) if across else np.s_[[0, -1]]] = False
            lower.data = node_values(self._edges, free)[find_stored(self._grid.shape)]
            self._free.append(free)
            self._factors.append(Factor(lower))

    def glide(self, z: Complexes, w: Complexes) -> Complexes:
        """Return where the frame's nodes are (R, C), for bodies at z (R, C), and W; inside it is W."""
        moved = (z - w).ravel()[self._nearest]
        parts = []
        for part, free, factor in zip((moved.real, moved.imag), self._free, self._factors, strict=True):
            held = np.where(free | self._grid.outline & (self._index.ravel()[self._nearest] < 0), 0, part)
            load = np.where(free, -laplacian(self._edges, held), 0)
            parts.append(held + factor.solve(load.ravel()).reshape(held.shape))
        base = w.copy()
        for side, axis in zip(SIDES, (0, 0, 1, 1), strict=True):
            u = parts[axis][side]
            place = np.linspace(0, len(u) - 1, self._fine.shape[1 - axis])
            along: Floats = np.interp(place, np.arange(len(u)), u)
            base[side] += 1j * along if axis else along
        return glide_beside(z, base, self._index)


def glide_beside(z: Complexes, w: Complexes, index: Ints, knots: "Knots | None" = None) -> Complexes:
    """Return `z` (R, C) with the frame nodes outside bodies moved along their sides as the bodies there ask.

    Between cut bodies, and between those and the corners, the displacement from W runs linearly. `index` (R, C) is the
    body of each node, -1 for none. `knots` are further places of the frame that are displaced.
    """
    found = z.copy()
    for number, side in enumerate(SIDES):
        known = index[side] >= 0
        corners = np.zeros(len(known), bool)
        corners[[0, -1]] = True
        moved: Complexes = np.where(known, z[side] - w[side], 0)
        at = np.flatnonzero(known | corners)
        places, by = at.astype(np.float64), moved[at]
        if knots is not None:
            apart = np.abs(knots.places[number][:, None] - places).min(axis=1, initial=np.inf) >= 1
            order = np.argsort(np.append(places, knots.places[number][apart]), kind="stable")
            places = np.append(places, knots.places[number][apart])[order]
            by = np.append(by, knots.moves[number][apart])[order]
        line: Floats = np.arange(len(known), dtype=np.float64)
        along = np.interp(line, places, by.real) + 1j * np.interp(line, places, by.imag)
        found[side] = np.where(known, z[side], w[side] + along)
    return found


@dataclass(frozen=True, eq=False)
class Knots:
    """Places of the frame that are displaced along their side, for each of `SIDES`."""

    places: list[Floats]
    """In cells along the side."""
    moves: list[Complexes]

    @classmethod
    def of(cls, grid: Grid, at: Points, moves: Complexes) -> "Knots":
        """Return those of points (k, 2) of the picture at the frame, which lie on the side nearest to them."""
        cells = (at + 0.5) / grid.cell
        last = np.array([grid.columns - 1, grid.rows - 1])
        far = np.stack([cells[:, 1], last[1] - cells[:, 1], cells[:, 0], last[0] - cells[:, 0]])
        nearest = far.argmin(axis=0)
        places, by = [], []
        for number in range(len(SIDES)):
            chosen = nearest == number
            across = number < 2
            place = cells[chosen, 0 if across else 1]
            order = np.argsort(place, kind="stable")
            places.append(place[order])
            along = moves[chosen][order]
            by.append((along.real + 0j) if across else 1j * along.imag)
        return cls(places, by)
