"""The outline of the picture as four lines from corner to corner, along which its nodes may glide.

A gliding node is known by its arc length, in pixels, from where its side begins: the top and the bottom on the left,
the left and the right at the top.
"""

from dataclasses import dataclass

import numpy as np

from core.arrays import Bools, Floats, Ints
from core.grid import SIDES, Grid
from core.mapping.jacobians import Complexes
from core.mapping.tolerances import ROUNDING

CORNERS = ([0, 0, -1, -1], [0, -1, 0, -1])
"""Nodes of the corners."""


@dataclass(frozen=True)
class OutlineNodes:
    """The four lines that a map draws: the points of each and their arc lengths."""

    lines: tuple[Complexes, ...]
    arcs: tuple[Floats, ...]

    @classmethod
    def of(cls, shape: Complexes) -> "OutlineNodes":
        """Return the outline of a map (R, C)."""
        lines = tuple(np.ascontiguousarray(shape[side]) for side in SIDES)
        return cls(lines, tuple(np.append(0.0, np.cumsum(np.abs(np.diff(line)))) for line in lines))

    def project(self, side: int, z: Complexes) -> Floats:
        """Return the arc lengths of the points of a side that are closest to z (k,)."""
        line, arc = self.lines[side], self.arcs[side]
        along = np.diff(line)
        square = np.maximum(np.abs(along) ** 2, np.finfo(float).tiny)
        share = np.clip((np.conj(along) * (z[:, None] - line[:-1])).real / square, 0, 1)
        best = np.abs(z[:, None] - line[:-1] - share * along).argmin(axis=1)
        return np.asarray(arc[best] + share[np.arange(len(z)), best] * np.abs(along[best]))

    def point_at(self, side: int, arc: Floats) -> Complexes:
        """Return the points at arc lengths (k,); beyond an end, that end."""
        line, known = self.lines[side], self.arcs[side]
        return np.asarray(np.interp(arc, known, line.real) + 1j * np.interp(arc, known, line.imag))

    def tangent_at(self, side: int, arc: Floats) -> Complexes:
        """Return the directions of the line at arc lengths (k,), as unit numbers."""
        line, known = self.lines[side], self.arcs[side]
        segment = np.clip(np.searchsorted(known, arc, "right") - 1, 0, len(line) - 2)
        along = np.diff(line)[segment]
        return np.asarray(along / np.maximum(np.abs(along), np.finfo(float).tiny))


class Gliders:
    """Nodes (g,) of a grid that glide along an outline, side by side."""

    def __init__(self, outline: OutlineNodes, grid: Grid, glide: Bools) -> None:
        self._outline = outline
        number = np.arange(grid.size).reshape(grid.shape)
        inner = [number[side][1:-1] for side in SIDES]
        self._parts = [nodes[glide.ravel()[nodes]] for nodes in inner]
        self.nodes: Ints = np.concatenate(self._parts)
        ends = np.cumsum([len(part) for part in self._parts])
        self._slices = [slice(end - len(part), end) for end, part in zip(ends, self._parts, strict=True)]

    def arcs_of(self, z: Complexes) -> Floats:
        """Return the arc lengths (g,) of gliders in a map of all nodes (N,)."""
        found = [self._outline.project(side, z[nodes]) for side, nodes in enumerate(self._parts) if len(nodes)]
        return np.concatenate([np.empty(0), *found])

    def places(self, arcs: Floats) -> Complexes:
        """Return the places (g,) at arc lengths."""
        found = [self._outline.point_at(side, arcs[part]) for side, part in enumerate(self._slices)]
        return np.concatenate(found)

    def tangents(self, arcs: Floats) -> Complexes:
        """Return the directions (g,) in which gliders move."""
        found = [self._outline.tangent_at(side, arcs[part]) for side, part in enumerate(self._slices)]
        return np.concatenate(found)


def ring_of(grid: Grid) -> Ints:
    """Return the outline's node numbers, clockwise from the top left."""
    number = np.arange(grid.size).reshape(grid.shape)
    return np.concatenate([number[0], number[1:, -1], number[-1, -2::-1], number[-2:0:-1, 0]])


def nodes_beside_cuts(grid: Grid, index: Ints, reach: int) -> Bools:
    """Return the outline nodes (R, C) outside bodies within `reach` nodes, along the outline, of one inside."""
    ring = ring_of(grid)
    cut = index.ravel()[ring] >= 0
    near = cut.copy()
    for by in range(1, min(reach, len(ring)) + 1):
        near |= np.roll(cut, by) | np.roll(cut, -by)
    found = np.zeros(grid.size, bool)
    found[ring[near & ~cut]] = True
    return found.reshape(grid.shape)


def crosses_itself(ring: Complexes) -> bool:
    """Return whether the closed line through `ring` (n,) crosses itself."""
    # Two edges cross where the ends of each lie to either side of the other; that takes boxes that meet.
    one, other = _edges_whose_boxes_meet(ring)
    on = ROUNDING * np.abs(ring - ring[0]).max()
    return bool((_are_parted(ring, one, other, on) & _are_parted(ring, other, one, on)).any())


def _edges_whose_boxes_meet(ring: Complexes) -> tuple[Ints, Ints]:
    """Return pairs of edges of the closed line that share no end, each edge by the number of its first point."""
    meet = np.ones((len(ring), len(ring)), bool)
    for start in (ring.real, ring.imag):
        end = np.roll(start, -1)
        meet &= np.minimum(start, end)[:, None] <= np.maximum(start, end)
    one, other = np.nonzero(meet & meet.T)
    chosen = (other > one + 1) & (other - one < len(ring) - 1)
    return one[chosen], other[chosen]


def _are_parted(ring: Complexes, ends: Ints, lines: Ints, on: float) -> Bools:
    """Return whether the line through an edge parts the ends of another, for pairs of them.

    What is nearer than `on` is to neither side of it, whatever the rounding.
    """
    after = np.roll(ring, -1)
    along, near = after[lines] - ring[lines], on * np.abs(after[lines] - ring[lines])
    first, second = ((np.conj(along) * (z[ends] - ring[lines])).imag for z in (ring, after))
    return np.asarray((np.minimum(first, second) < -near) & (np.maximum(first, second) > near))
