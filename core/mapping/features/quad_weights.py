"""Which quads follow a feature, which follow W, and how strongly  [FAT sec. 2.1]."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from core.arrays import Bools, Floats, InputError, Ints, Singles
from core.grid import Grid
from core.mapping.features.similarity import Body
from core.mapping.jacobians import Complexes

MOST_WEIGHT, MOST_FALLOFF = 1e6, 1000


@dataclass(frozen=True)
class Roles:
    """The part that every quad (R-1, C-1) plays.

    A quad with a node in one feature, or close to it, has an `owner` and equations of type FAT eq. 3; all others,
    those that hold nodes of two features and those that are as close to one as to another have equations of type eq. 4.
    """

    owner: Ints
    """Index of the feature that the quad follows, -1 for none."""
    touched: Bools
    """Whether a node of the quad is in a feature."""
    weight: Floats
    """w(Q) of FAT eq. 7: both sides of the quad's equations are multiplied by it."""
    reach: int
    """Cells from a feature within which the quads are that it owns."""

    @cached_property
    def inside(self) -> Ints:
        """Numbers of the quads with an owner that have a node in it."""
        return np.flatnonzero(self.touched & (self.owner >= 0))

    @cached_property
    def counts(self) -> Ints:
        """How many quads are inside each feature."""
        return np.bincount(self.owner.ravel()[self.inside])

    def sum_edges(self, z: Complexes, count: int) -> tuple[Complexes, Complexes]:
        """Return the sums (count,) of the edges across and down of the quads inside features, with nodes at z (N,).

        Two edges to a quad each way. Where one quad goes on with the next, both ends cancel.
        """
        found = []
        for of, nodes, beside in self._ends:
            there = z[nodes] + z[nodes + beside]
            x, y = (np.bincount(of, part, count) for part in (there.real, there.imag))
            found.append(np.asarray(x + 1j * y, np.complex128))
        return found[0] - found[1], found[2] - found[3]

    @cached_property
    def _ends(self) -> list[tuple[Ints, Ints, int]]:
        """Sides of quads that go on with no other one: owners, first nodes, and the way to the second node.

        Those on the right, on the left, below and above.
        """
        rows, columns = self.owner.shape
        owner = np.full((rows + 2, columns + 1), -1)
        owner[1:-1, :-1] = np.where(self.touched, self.owner, -1)
        nodes = self.inside + self.inside // columns  # as padded quads are numbered, but for the first row
        own, around = self.owner.ravel()[self.inside], owner.ravel()
        wide, found = columns + 1, []
        for step, first, beside in ((1, 1, wide), (-1, 0, wide), (wide, wide, 1), (-wide, 0, 1)):
            ends = around[nodes + wide + step] != own
            found.append((own[ends], nodes[ends] + first, beside))
        return found

    def means(self, values: Floats, quads: Ints, count: int) -> Floats:
        """Return for each of `count` features the mean of the `values` (k,) of those of the `quads` (k,) it owns."""
        owner = self.owner.ravel()[quads]
        mean: Floats = np.bincount(owner, values, count) / np.maximum(np.bincount(owner, minlength=count), 1)
        return mean


def assign_roles(index: Ints, *, weight: float, falloff: float) -> Roles:
    """Give every quad its role: equations of type FAT eq. 3 or eq. 4, and their weight (FAT eq. 7).

    Parameters
    ----------
    index
        Index of each node's feature (R, C), -1 for none.
    weight
        w_F, the weight inside features.
    falloff
        ρ, the width in cells of the band outside them over which the weight returns to 1.

    Raises `InputError` for a weight or a width beyond what they can be.
    """
    if not 0 < weight <= MOST_WEIGHT:
        raise InputError(f"feature weight of {weight:g}: must be positive and at most {MOST_WEIGHT:g}")
    if not 0 <= falloff <= MOST_FALLOFF:
        raise InputError(f"falloff of {falloff:g} cells: must not be negative, nor more than {MOST_FALLOFF}")
    corners = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    highest = np.maximum(np.maximum(corners[0], corners[1]), np.maximum(corners[2], corners[3]))
    touched = highest >= 0
    if not touched.any():
        return Roles(np.full(touched.shape, -1), touched, np.ones(touched.shape), 0)
    own = highest[touched]
    mixed = np.any([(found >= 0) & (found != own) for found in (corner[touched] for corner in corners)], axis=0)
    owned = np.full(touched.shape, -1)
    owned[touched] = np.where(mixed, -1, own)
    far, nearest = _find_nearest(touched, owned)
    # From centre to centre; a feature reaches half a cell further than the centres of its quads.
    is_near = touched | (far < falloff + 0.5)
    if _meet(nearest, is_near):
        nearest = _without_ties(nearest, touched, owned)
    near = np.flatnonzero(is_near)
    share = decay(np.maximum(far.ravel()[near].astype(np.float64) - 0.5, 0.0), falloff)
    of = np.where(share > 0, nearest.ravel()[near], -1)
    owner, total = np.full(touched.shape, -1), np.ones(touched.shape)
    owner.ravel()[near], total.ravel()[near] = of, np.where(of >= 0, weight * share + (1 - share), 1.0)
    return Roles(owner, touched, total, math.ceil(falloff) + 2)


def _find_nearest(touched: Bools, owned: Ints) -> tuple[Singles, Ints]:
    """Return how far every quad (R-1, C-1) is from the nearest one that is touched, in cells, and whose that is."""
    far, label = cv2.distanceTransformWithLabels(
        (~touched).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    owner = np.zeros(int(label.max()) + 1, np.int64)
    owner[label[touched]] = owned[touched]
    return np.asarray(far, np.float32), owner[label]


def _meet(nearest: Ints, is_near: Bools) -> bool:
    """Return whether what is near one feature lies beside what is near another."""
    return any(
        bool(((one != other) & both).any())
        for one, other, both in (
            (nearest[1:], nearest[:-1], is_near[1:] & is_near[:-1]),
            (nearest[:, 1:], nearest[:, :-1], is_near[:, 1:] & is_near[:, :-1]),
        )
    )


def _without_ties(nearest: Ints, touched: Bools, owned: Ints) -> Ints:
    """Return `nearest` with -1 where two features are equally near: which is found hangs on the side begun from."""
    found = nearest.copy()
    for down, across in ((1, -1), (-1, 1), (-1, -1)):
        mirrored = np.ascontiguousarray(touched[::down, ::across]), np.ascontiguousarray(owned[::down, ::across])
        found[_find_nearest(*mirrored)[1][::down, ::across] != nearest] = -1
    return found


def weigh_free(owner: Ints, grid: Grid, soft: Iterable[Body], weight: float) -> Floats:
    """Return the weights (R-1, C-1) of equations of type FAT eq. 4, squared: 0 where a quad has an `owner`, else 1.

    Inside features that are protected softly they grow up to that of features: w_F^(2p).
    """
    weights = np.ones(owner.shape)
    for body in soft:
        weights[quads_inside(grid, body)] = weight ** (2 * body.limits.weight)
    weights[owner >= 0] = 0
    return weights


def quads_inside(grid: Grid, body: Body) -> Bools:
    """Return the quads (R-1, C-1) with all nodes in a body."""
    inside = np.bincount(body.nodes, minlength=grid.size)[grid.quads].all(axis=1)
    return np.asarray(inside.reshape(grid.rows - 1, grid.columns - 1))


def decay(distance: Floats, falloff: float) -> Floats:
    """Evaluate f(x) = 2 x³ / ρ³ - 3 x² / ρ² + 1, 0 from ρ on  [FAT eq. 6]."""
    if falloff <= 0:
        return (distance <= 0).astype(np.float64)
    x: Floats = np.minimum(distance / falloff, 1.0)
    return 2 * x**3 - 3 * x**2 + 1
