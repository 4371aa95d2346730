"""What one feature contributes to the exact mapping: its columns, in a window of the grid around it.

In the terms of `exact`: with p the arms of the feature's nodes and w the weights of the edges,

    Φ = (p, 1) on its nodes,   H = (dᵀ w_own d p, 0),   B = H - K Φ,   D = (Σ w_own |d p|², 0),

w_own those of the quads that follow the feature. The first of two is that for α, the second that for t.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from core.arrays import Floats, Ints
from core.linalg.laplacian import EdgeWeights, divergence, edge_weights, laplacian
from core.mapping.features.pose import Start
from core.mapping.features.similarity import Body
from core.mapping.jacobians import Complexes
from core.mapping.tolerances import ROUNDING, TIE

Window = tuple[slice, slice]


@dataclass(frozen=True, eq=False)
class Field:
    """Columns (2, h, w) over the nodes of a window that holds a feature, its neighbours and its quads."""

    nodes: Ints
    window: Window
    number: Ints
    """Numbers of the window's nodes in the grid (h, w)."""
    own: Floats
    """Weight of each quad of the window, 0 of those that do not follow the feature."""
    near: EdgeWeights
    """Weights of the edges of the window, of all quads."""
    phi: Complexes
    halo: Complexes
    """H for α (h, w)."""
    load: Complexes
    """B."""
    stiffness: float
    """D for α."""
    border: Ints
    """Numbers of the nodes of the grid where B is not 0."""
    columns: Floats
    """B there, for the real and the imaginary part of α and for t (k, 3)."""

    @classmethod
    def of(cls, body: Body, rest: Complexes, window: Window, own: Floats, near: EdgeWeights) -> "Field":
        """Evaluate a feature's columns; rest positions are those of the whole grid (R, C)."""
        number = np.arange(rest.size).reshape(rest.shape)[window]
        phi = np.zeros((2, *number.shape), np.complex128)
        place = np.searchsorted(number.ravel(), body.nodes)
        phi[0].ravel()[place], phi[1].ravel()[place] = body.arms, 1
        own_across, own_down = edge_weights(own)
        across, down = np.diff(rest[window], axis=1), np.diff(rest[window], axis=0)
        halo = divergence(own_across * across, own_down * down)
        load = np.stack([halo - laplacian(near, phi[0]), -laplacian(near, phi[1])])
        stiffness = float((own_across * np.abs(across) ** 2).sum() + (own_down * np.abs(down) ** 2).sum())
        there = load.any(axis=0)
        columns = np.stack([load[0].real[there], load[0].imag[there], load[1].real[there]], axis=-1)
        return cls(body.nodes, window, number, own, near, phi, halo, load, stiffness, number[there], columns)

    def has_same(self, window: Window, own: Floats, near: EdgeWeights) -> bool:
        """Return whether a field of the same nodes with this window and these weights is this one."""
        if window != self.window or not np.array_equal(own, self.own):
            return False
        return all(np.array_equal(a, b) for a, b in zip(near, self.near, strict=True))

    def with_other(self, other: "Field", tie: float) -> Complexes:
        """Return the block (2, 2) of τ Φ*Φ - Φ*B - H*Φ that this feature has with another one."""
        mine, its = _overlap(self.window, other.window)
        phi, phi_of_other = self.phi[:, *mine].reshape(2, -1), other.phi[:, *its].reshape(2, -1)
        block = phi.conj() @ (tie * phi_of_other - other.load[:, *its].reshape(2, -1)).T
        block[0] -= self.halo[mine].conj().ravel() @ phi_of_other.T
        return np.asarray(block)

    @cached_property
    def with_itself(self) -> Complexes:
        """The block (2, 2) of τ Φ*Φ + D - Φ*B - H*Φ that this feature has with itself."""
        block = self.with_other(self, TIE)
        block[0, 0] += self.stiffness
        return block

    def weighed(self, start: Start) -> Complexes:
        """Return Φ* (r + τ W) + H* z⁰ (2,)."""
        nodes, by_u, by_w = self._rim
        there, inside = start.w.read(nodes), start.w.whole[self.window].ravel()
        tied = np.array([np.vdot(phi, inside) for phi in self.phi])
        return np.asarray(by_u @ (there - start.read(nodes)) + by_w @ there + TIE * tied)

    @cached_property
    def _rim(self) -> tuple[Ints, Complexes, Complexes]:
        """Nodes of the grid (k,), and by what u and W there, (2, k) each, make up Φ* r + H* z⁰.

        With z⁰ = W - u and r = K u - dᵀ w_own d W that is (H - dᵀ w_own d Φ)* W - B* u: nothing but rounding counts
        further inside the feature.
        """
        own = edge_weights(self.own)
        by_w = np.stack([self.halo - laplacian(own, self.phi[0]), -laplacian(own, self.phi[1])])
        size = np.abs(np.stack([by_w, self.load]))
        there = (size > ROUNDING * size.max(axis=(2, 3), keepdims=True)).any(axis=(0, 1))
        return self.number[there], -self.load[:, there].conj(), by_w[:, there].conj()


def fields_of(
    bodies: list[Body],
    rest: Complexes,
    *,
    owner: Ints,
    follow: Floats,
    weights: EdgeWeights,
    reach: int,
    known: Iterable[Field] = (),
) -> list[Field]:
    """Return the field of each body; those that are the same as a `known` one are taken from there.

    Parameters
    ----------
    owner
        Index of the body that each quad (R-1, C-1) follows, -1 for none: one within `reach` cells of it.
    follow
        Weight of each quad's equations of type FAT eq. 3, squared.
    weights
        Of the edges, from equations of both types.
    """
    by_nodes = {field.nodes.tobytes(): field for field in known}
    fields = []
    for i, body in enumerate(bodies):
        window = _window(body, reach, rest.shape)
        rows, columns = window
        quads = slice(rows.start, rows.stop - 1), slice(columns.start, columns.stop - 1)
        own = np.where(owner[quads] == i, follow[quads], 0.0)
        near = weights[0][rows, quads[1]], weights[1][quads[0], columns]
        field = by_nodes.get(body.nodes.tobytes())
        if field is None or not field.has_same(window, own, near):
            field = Field.of(body, rest, window, own, near)
        fields.append(field)
    return fields


def pairs_that_meet(fields: list[Field]) -> list[tuple[int, int]]:
    """Return the pairs of two fields, in both orders, whose windows overlap."""
    if not fields:
        return []
    first, last = (np.array([[getattr(side, end) for side in f.window] for f in fields]) for end in ("start", "stop"))
    meet = (first[:, None] < last).all(axis=-1)
    meet &= meet.T & ~np.eye(len(fields), dtype=bool)
    return [(i, j) for i, j in np.argwhere(meet).tolist()]


def _window(body: Body, reach: int, shape: tuple[int, ...]) -> Window:
    """Return the window of a feature's nodes, and of what lies within `reach` cells and one more around them."""
    rows, columns = (
        slice(max(int(places.min()) - reach - 1, 0), min(int(places.max()) + reach + 2, size))
        for places, size in zip(np.divmod(body.nodes, shape[1]), shape, strict=True)
    )
    return rows, columns


def _overlap(one: Window, other: Window) -> tuple[Window, Window]:
    """Return what two windows have in common, as each counts its nodes."""
    common = [(max(a.start, b.start), min(a.stop, b.stop)) for a, b in zip(one, other, strict=True)]
    mine, its = (
        tuple(slice(first - w.start, last - w.start) for (first, last), w in zip(common, window, strict=True))
        for window in (one, other)
    )
    return (mine[0], mine[1]), (its[0], its[1])
