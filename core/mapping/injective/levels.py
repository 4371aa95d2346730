"""What the energy needs to know of a grid, on the grid of the picture and on coarser ones, and the way between them.

Poses of bodies are about pivots in the picture, so that they mean the same on every grid. On a coarser grid, bodies
cover all nodes that they have on the fine one: every fine node of a body lies between coarse ones of it.
"""

from dataclasses import dataclass, replace

import numpy as np

from core.arrays import Bools, Floats, Ints
from core.grid import SIDES, Grid
from core.mapping.features.feature_mapping import JOINT_AT_MOST, FeatureMapping
from core.mapping.features.pose import Solution
from core.mapping.features.quad_weights import assign_roles
from core.mapping.folds import corner_areas
from core.mapping.handles.constraints import Constraints
from core.mapping.injective.outline import OutlineNodes
from core.mapping.jacobians import Complexes, as_complex
from core.mapping.tolerances import LEAST_SHARE, ROUNDING

_WEIGHT, _FALLOFF, _MOST_WEIGHT = 10.0, 2.0, 4.0
"""w_F and ρ of FAT sec. 2.1 on coarser grids, and w_F² at most on all: more would only stiffen what has to give way."""


@dataclass(frozen=True)
class Map:
    """A mapped grid with the poses of its bodies about their pivots."""

    z: Complexes
    """Nodes (N,)."""
    alpha: Complexes
    place: Complexes
    """Point p of body i lies at place[i] + alpha[i] (p - pivot[i])."""


@dataclass(frozen=True, eq=False)
class GridLevel:
    """A grid of R x C nodes with its bodies, what its quads follow, and what its map is measured against."""

    grid: Grid
    wanted: Complexes
    shape: Complexes
    """Maps (R, C): background quads follow the one, corners are measured against the other, which folds nothing."""
    index: Ints
    """Body of every node (N,), -1 for none."""
    owner: Ints
    """Body that a quad (M,) follows, -1 for none."""
    follow_wanted: Floats
    follow_body: Floats
    """Weights (M,) of a quad's equations."""
    constraints: Constraints
    outline: OutlineNodes
    """That of the fine grid's `shape`."""

    @classmethod
    def of(
        cls, mapping: FeatureMapping, wanted: Complexes, start: Solution, shape: Complexes, held: Constraints
    ) -> "GridLevel":
        """Return the picture's own grid. Without poses (FAT as printed) quads follow the linear answer itself."""
        index, owner, follow = mapping.index.ravel(), mapping.owner.ravel(), mapping.follow_w.ravel()
        weight = np.minimum(mapping.follow_feature.ravel(), _MOST_WEIGHT)
        if not len(start.alpha):
            index, owner = np.full_like(index, -1), np.full_like(owner, -1)
            wanted, follow, weight = start.z, follow + weight, 0 * weight
        return cls(mapping.grid, wanted, shape, index, owner, follow, weight, held, OutlineNodes.of(shape))

    @property
    def rest(self) -> Complexes:
        """Nodes of the picture (N,)."""
        return as_complex(self.grid.nodes).ravel()

    @property
    def inner(self) -> Bools:
        """Nodes (N,) that are neither on a held outline nor in a body."""
        return np.asarray(~self.held_outline.ravel() & (self.index < 0))

    @property
    def held_outline(self) -> Bools:
        """Nodes (R, C) of the outline, if it is not free."""
        return np.asarray(self.grid.outline & (not self.constraints.is_free))

    def off_outline(self, z: Complexes) -> Bools:
        """Return the nodes (N,) of the outline outside bodies that are neither where `shape` has them nor glide."""
        off = self.held_outline.ravel() & (self.index < 0) & ~self.constraints.glide.ravel()
        return np.asarray(off & (np.abs(z - self.shape.ravel()) > ROUNDING * self.side))

    def is_fit(self) -> bool:
        """Return whether `shape`, on a coarser grid, can still tell what folds."""
        return bool(corner_areas(self.shape).sum(axis=0).min() > 0)

    @property
    def side(self) -> float:
        """Side of a cell in pixels, in the mean."""
        return float(np.sqrt(np.abs(corner_areas(self.shape)).mean()))

    def counts(self) -> Ints:
        """Return how many nodes each body has."""
        return np.bincount(self.index[self.index >= 0], minlength=len(self.constraints.pivots))

    def placed(self, z: Complexes, alpha: Complexes, place: Complexes) -> Map:
        """Return the map with z (N,) outside bodies and with bodies at the given poses."""
        inside = np.flatnonzero(self.index >= 0)
        body, z = self.index[inside], z.copy()
        z[inside] = place[body] + alpha[body] * (self.rest[inside] - self.constraints.pivots[body])
        return Map(z, alpha, place)

    def of_solution(self, found: Solution, centres: Complexes) -> Map:
        """Return a solution with poses about pivots instead of the bodies' centres (n,)."""
        n = len(found.alpha)
        place = found.t + found.alpha * (self.constraints.pivots[:n] - centres[:n])
        return Map(found.z.ravel(), found.alpha.copy(), place)

    def solution_of(self, found: Map, centres: Complexes) -> Solution:
        """Return a map with poses about the bodies' centres (n,)."""
        n = len(found.alpha)
        t = found.place + found.alpha * (centres[:n] - self.constraints.pivots[:n])
        return Solution(found.z.reshape(self.grid.shape), found.alpha, t)


class Transfer:
    """Restriction of a level to a coarser one, and prolongation back from it."""

    def __init__(self, fine: GridLevel, cells: float, *, held_outline: bool) -> None:
        """Take about `cells` cells as one.

        With a `held_outline`, every fine outline node that stays lies between coarse ones that stay.
        """
        self.fine = fine
        grid = fine.grid.coarsened(cells)
        self._down = fine.grid.weights_at(grid.nodes.reshape(-1, 2))
        self._up = grid.weights_at(fine.grid.nodes.reshape(-1, 2))
        index = self._covered(grid.size)
        stays = self.around(fine.held_outline & (fine.index < 0).reshape(fine.grid.shape) & ~fine.constraints.glide)
        if held_outline:
            index[stays] = -1
        roles = assign_roles(index.reshape(grid.shape), weight=_WEIGHT, falloff=_FALLOFF)
        owner = np.where(roles.owner < JOINT_AT_MOST, roles.owner, -1).ravel()
        followed = owner >= 0
        wanted, shape = self.restrict(fine.wanted.ravel()), self.restrict(fine.shape.ravel())
        self.coarse = GridLevel(
            grid,
            wanted.reshape(grid.shape),
            shape.reshape(grid.shape),
            index,
            owner,
            np.where(followed, 0.0, 1.0),
            np.where(followed, np.minimum(roles.weight.ravel() ** 2, _MOST_WEIGHT), 0.0),
            self._constraints(grid, index, stays),
            fine.outline,
        )

    def _between(self, nodes: Ints) -> tuple[Ints, Ints]:
        """Return the coarse nodes between which fine `nodes` lie, each with the fine one that it is found for."""
        around, weights = self._up[0][nodes], self._up[1][nodes]
        beside = weights > ROUNDING
        return around[beside], np.broadcast_to(nodes[:, None], around.shape)[beside]

    def around(self, marked: Bools) -> Bools:
        """Return the coarse nodes (n,) between which `marked` ones (R, C) of the fine grid lie."""
        found = np.zeros(len(self._down[0]), bool)
        found[self._between(np.flatnonzero(marked))[0]] = True
        return found

    def _covered(self, size: int) -> Ints:
        """Return the body of every coarse node; of two that cover it, the smaller one."""
        index = np.full(size, -1)
        nodes, of = self._between(np.flatnonzero(self.fine.index >= 0))
        np.maximum.at(index, nodes, self.fine.index[of])
        return index

    def _constraints(self, grid: Grid, index: Ints, stays: Bools) -> Constraints:
        """Return the constraints of the coarse grid: points that can be held there, and the frame's gliding nodes."""
        held = self.fine.constraints
        nodes, weights = held.probes.on(grid)
        inner = (index < 0) & (~grid.outline.ravel() | held.is_free)
        self.kept: Bools = (np.abs(weights) * inner[nodes]).sum(axis=1) > LEAST_SHARE * np.abs(weights).sum(axis=1)
        """Points that the coarse grid holds."""
        kept = self.kept
        glide = grid.outline.ravel() & (index < 0) & ~stays & held.glide.any()
        return replace(held, probes=held.probes[kept], to=held.to[kept], glide=glide.reshape(grid.shape))

    def restrict(self, z: Complexes) -> Complexes:
        """Return a map of the fine grid (N,) at the coarse nodes."""
        return np.asarray((z[self._down[0]] * self._down[1]).sum(axis=1))

    def prolong(self, z: Complexes) -> Complexes:
        """Return values of the coarse nodes at the fine ones, which lie between them."""
        return np.asarray((z[self._up[0]] * self._up[1]).sum(axis=1))

    def restrict_map(self, found: Map, *, held_outline: bool = True) -> Map:
        """Return a map of the fine grid on the coarse one, bodies where they are, a held outline as `shape` has it."""
        coarse, z = self.coarse, self.restrict(found.z)
        if held_outline:
            stays = (coarse.held_outline & ~coarse.constraints.glide).ravel()
            z[stays] = coarse.shape.ravel()[stays]
        return coarse.placed(z, found.alpha, found.place)

    def prolong_map(self, found: Map) -> Map:
        """Return a map of the coarse grid on the fine one, by how far it is from `shape`, its outline on `shape`'s."""
        fine, coarse = self.fine, self.coarse
        away = found.z - coarse.shape.ravel()
        away[np.abs(away) < ROUNDING * fine.side] = 0
        z = fine.shape.ravel() + self.prolong(away)
        if fine.constraints.glide.any():
            self._glide(z, found.z)
        return fine.placed(z, found.alpha, found.place)

    def _glide(self, z: Complexes, coarse: Complexes) -> None:
        """Put gliding nodes of the fine grid on the outline, by how far those of the coarse grid have glided."""
        fine, line = self.fine, self.fine.outline
        shape = self.coarse.shape
        rest, coarse_rest = as_complex(fine.grid.nodes), as_complex(self.coarse.grid.nodes)
        for number, side in enumerate(SIDES):
            there, unmoved = coarse.reshape(coarse_rest.shape)[side], shape[side]
            moved = line.project(number, there) - line.project(number, unmoved)
            along = np.abs(rest[side] - rest[side][0])
            shift = np.interp(along, np.abs(coarse_rest[side] - coarse_rest[side][0]), moved)
            glide = fine.constraints.glide[side]
            z.reshape(fine.grid.shape)[side][glide] = line.point_at(number, line.arcs[number] + shift)[glide]
