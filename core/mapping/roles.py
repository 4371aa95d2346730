"""Which quads follow a feature, which follow W, and how strongly  [FAT sec. 2.1]."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from core.arrays import Bools, Floats, Ints


@dataclass(frozen=True)
class Roles:
    """The part that every quad (R-1, C-1) plays.

    A quad with a node in one feature, or close to it, has an `owner` and equations of type FAT eq. 3; all others,
    and those that hold nodes of two features, have equations of type eq. 4.
    """

    owner: Ints
    """Index of the feature that the quad follows, -1 for none."""
    touched: Bools
    """Whether a node of the quad is in a feature."""
    weight: Floats
    """w(Q) of FAT eq. 7: both sides of the quad's equations are multiplied by it."""

    @cached_property
    def inside(self) -> Ints:
        """Numbers of the quads with an owner that have a node in it."""
        return np.flatnonzero(self.touched & (self.owner >= 0))


def assign_roles(index: Ints, *, weight: float, falloff: float) -> Roles:
    """Give every quad its role.

    Parameters
    ----------
    index
        Index of each node's feature (R, C), -1 for none.
    weight
        w_F, the weight inside features.
    falloff
        ρ, the width in cells of the band outside them over which the weight returns to 1.
    """
    corners = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]])
    highest = corners.max(axis=0)
    touched = highest >= 0
    mixed = touched & (np.where(corners < 0, highest, corners).min(axis=0) != highest)
    if not touched.any():
        return Roles(np.full(touched.shape, -1), touched, np.ones(touched.shape))
    far, nearest = cv2.distanceTransformWithLabels(
        (~touched).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    owner_of = np.zeros(int(nearest.max()) + 1, np.int64)
    owner_of[nearest[touched]] = np.where(mixed, -1, highest)[touched]
    # From centre to centre; a feature reaches half a cell further than the centres of its quads.
    near = np.flatnonzero(touched | (far < falloff + 0.5))
    share = decay(np.maximum(far.ravel()[near].astype(np.float64) - 0.5, 0.0), falloff)
    of = np.where(share > 0, owner_of[nearest.ravel()[near]], -1)
    owner, total = np.full(touched.shape, -1), np.ones(touched.shape)
    owner.ravel()[near], total.ravel()[near] = of, np.where(of >= 0, weight * share + (1 - share), 1.0)
    return Roles(owner, touched, total)


def decay(distance: Floats, falloff: float) -> Floats:
    """Evaluate f(x) = 2 x³ / ρ³ - 3 x² / ρ² + 1, 0 from ρ on  [FAT eq. 6]."""
    if falloff <= 0:
        return (distance <= 0).astype(np.float64)
    x: Floats = np.minimum(distance / falloff, 1.0)
    return 2 * x**3 - 3 * x**2 + 1


def average_scales(values: Floats, roles: Roles, count: int) -> Floats:
    """Return λ of every feature: the mean of `values` (R-1, C-1) over the quads that have a node in it."""
    return _means(values.ravel()[roles.inside], roles, count)


def average_parts(values: NDArray[np.complex128], roles: Roles, count: int) -> NDArray[np.complex128]:
    """Return for every feature the mean of `values` (k,), one for each of the k quads that have a node in it."""
    return _means(values.real, roles, count) + 1j * _means(values.imag, roles, count)


def _means(values: Floats, roles: Roles, count: int) -> Floats:
    owner = roles.owner.ravel()[roles.inside]
    mean: Floats = np.bincount(owner, values, count) / np.maximum(np.bincount(owner, minlength=count), 1)
    return mean
