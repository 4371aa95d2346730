"""What W and what is held ask of the free nodes: a load that is 0 but beside features, and beside a frame that glides.

With z⁰ = W on free nodes, u = W - z⁰ lives on held ones, and at a free node a the load b - K z⁰ is

    Σ w_own (W_b - W_a) - w u_b,

over its neighbours b: w the weight of the edge between them, w_own that of the quads which follow features. Features at
c ask for B c beside. Only nodes where that may not be 0 are worked on.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from core.arrays import Bools, Floats, Ints
from core.linalg.laplacian import EdgeWeights
from core.mapping.features.columns import Field
from core.mapping.features.pose import HeldNodes, Start
from core.mapping.features.reduced_system import as_two
from core.mapping.jacobians import Complexes


@dataclass(frozen=True, eq=False)
class NearLoad:
    """The load on `nodes` (m,), as it depends on W, on u and on c."""

    nodes: Ints
    _read: Ints
    """Those that W is read at."""
    _at: Ints
    _held: Ints
    """Those that u is read at, and their numbers among the held ones."""
    _by: "scipy.sparse.csr_array"
    """What makes it of W, u and c, one after the other."""

    @classmethod
    def of(
        cls,
        weights: EdgeWeights,
        own: EdgeWeights,
        fields: Sequence[Field],
        free: Bools,
        held: HeldNodes,
        *,
        glides: bool,
    ) -> "NearLoad":
        """Return it for `free` nodes (R, C): where the outline `glides`, beside that too."""
        count = held.place.shape[1]
        is_held = (held.place >= 0 if glides else (held.place >= 0) & (held.place < len(held.bodies))).ravel()
        nodes = np.flatnonzero(_find_near(is_held.reshape(free.shape), own) & free)
        across, row = nodes - nodes // count, np.arange(len(nodes))
        edges = (0, across), (0, across - 1), (1, nodes), (1, nodes - count)
        both, follow = (np.stack([of[axis].ravel()[at] for axis, at in edges]) for of in (weights, own))
        beside = nodes + np.array([[1], [-1], [count], [-count]])
        follows, meets, rows = follow != 0, is_held[beside], np.broadcast_to(row, beside.shape)
        read, reads = _number(np.concatenate([nodes, beside[follows]]), free.size)
        at, meet = _number(beside[meets], free.size)
        border, columns, column = _columns_of(fields, free)
        parts = [
            (row, reads[: len(nodes)], -follow.sum(axis=0)),
            (rows[follows], reads[len(nodes) :], follow[follows]),
            (rows[meets], len(read) + meet, -both[meets]),
            (np.searchsorted(nodes, border), len(read) + len(at) + column, columns),
        ]
        each, places, values = (np.concatenate(part) for part in zip(*parts, strict=True))
        size = len(nodes), len(read) + len(at) + 3 * len(fields)
        return cls(nodes, read, at, held.place.ravel()[at], scipy.sparse.csr_array((values, (each, places)), size))

    def evaluate(self, start: Start, c: Complexes) -> Floats:
        """Return the load (m, 2) for a start and the (α, iα, t) of the features."""
        u = start.w.read(self._at) - start.at_held[self._held]
        return np.asarray(self._by @ as_two(np.concatenate([start.w.read(self._read), u, c])))


def _find_near(held: Bools, own: EdgeWeights) -> Bools:
    """Return the nodes (R, C) beside held ones, and those with an edge that follows features."""
    near = np.zeros(held.shape, bool)
    for axis, follow in ((1, own[0]), (0, own[1])):
        part, marked, follows = (np.moveaxis(x, axis, 0) for x in (near, held, follow != 0))
        part[1:] |= marked[:-1] | follows
        part[:-1] |= marked[1:] | follows
    return near


def _number(nodes: Ints, count: int) -> tuple[Ints, Ints]:
    """Return the different ones of some nodes, of so many, ascending, and which of them each is."""
    place = np.zeros(count, np.int64)
    place[nodes] = 1
    found = np.flatnonzero(place)
    place[found] = np.arange(len(found))
    return found, place[nodes]


def _columns_of(fields: Sequence[Field], free: Bools) -> tuple[Ints, Floats, Ints]:
    """Return B at free nodes by the nodes, values and columns: those for the real part of α, those of iα, and of t."""
    border = np.concatenate([np.empty(0, np.int64), *(field.border for field in fields)])
    columns = np.concatenate([np.empty((0, 3)), *(field.columns for field in fields)])
    owner = np.repeat(np.arange(len(fields)), [len(field.border) for field in fields])
    there = free.ravel()[border]
    column = np.add.outer(owner[there], len(fields) * np.arange(3))
    return np.repeat(border[there], 3), columns[there].ravel(), column.ravel()
