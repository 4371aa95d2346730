"""Cloth carried straight on into a gap in which the mesh would be crushed or torn.

Beside a fold the pattern jumps: what is hidden leaves its two sides with coordinates that do not meet. A place there
belongs to the nearest cloth, whose coordinates go on with the slope that they have around it.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Points
from core.overlay.filters.smoothing import gaussian
from core.overlay.mesh import around
from core.overlay.tolerances import RIM_PX, STRETCH


@dataclass(frozen=True)
class Extension:
    """Which cloth a place belongs to, and what it shows there."""

    places: Points
    """(n, 2), pixels of the cloth at which it begins."""
    nearest: Ints
    """(H, W), the number of the place that is nearest."""
    uv: Floats
    """(n, 2), texels."""
    slopes: Floats
    """(n, 2, 2), texels a pixel."""
    rho: Floats
    """(n,)."""

    def at(self, points: Points) -> tuple[Floats, Floats]:
        """Return coordinates (m, 2) and shading (m,) at places (m, 2) of the picture."""
        size = np.array(self.nearest.shape[::-1])
        x, y = np.clip(np.rint(points).astype(np.int64), 0, size - 1).T
        number = self.nearest[y, x]
        away = points - self.places[number]
        return self.uv[number] + np.einsum("nij,nj->ni", self.slopes[number], away), self.rho[number]


def extension_of(uv: Floats, rho: Floats, owner: Ints, texel_area: float, sigma_px: float) -> Extension | None:
    """Return how pieces of cloth go on beyond their ends, None if nothing of them is sound.

    `uv` (H, W, 2) and `rho` (H, W) are NaN, and the number (H, W) of a pixel's piece is -1, where there is none;
    `texel_area` is in pixels, `sigma_px` the width of the neighbourhood that gives slope and shading.
    """
    covered = np.isfinite(rho)
    slopes = np.zeros((*rho.shape, 2, 2))
    for piece in np.unique(owner[owner >= 0]):
        mine: Bools = np.asarray(owner == piece, np.bool_)
        box = around(mine)
        slopes[box][mine[box]] = mean_slopes(uv[box], mine[box], sigma_px)[mine[box]]
    area = np.abs(slopes[..., 0, 0] * slopes[..., 1, 1] - slopes[..., 0, 1] * slopes[..., 1, 0]) * texel_area
    sound = covered & (area > 1 / STRETCH) & (area < STRETCH)
    kernel = np.ones((2 * RIM_PX + 1, 2 * RIM_PX + 1), np.uint8)
    source = (cv2.erode(covered.astype(np.uint8), kernel, borderValue=1) > 0) & sound
    if not source.any():
        return None
    _, labels = cv2.distanceTransformWithLabels(
        (~source).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    rows, columns = np.nonzero(source)
    number = np.empty(int(labels.max()) + 1, np.int64)
    number[labels[rows, columns]] = np.arange(len(rows))
    light = gaussian(np.nan_to_num(rho), sigma_px) / np.maximum(gaussian(covered.astype(float), sigma_px), 1e-6)
    return Extension(
        np.stack([columns, rows], -1).astype(np.float64),
        number[labels],
        uv[rows, columns],
        slopes[rows, columns],
        np.asarray(light[rows, columns], np.float64),
    )


def mean_slopes(uv: Floats, inside: Bools, sigma_px: float) -> Floats:
    """Return the mean slopes (H, W, 2, 2) of `uv` by x and y in the neighbourhood of each pixel, inside a piece."""
    columns: list[Floats] = []
    for axis in (1, 0):
        here, there = (np.moveaxis(uv, axis, 0)[k] for k in (slice(None, -1), slice(1, None)))
        both = np.moveaxis(inside, axis, 0)[:-1] & np.moveaxis(inside, axis, 0)[1:]
        steps, weight = np.zeros(uv.shape), np.zeros(inside.shape)
        np.moveaxis(steps, axis, 0)[:-1][both] = (there - here)[both]
        np.moveaxis(weight, axis, 0)[:-1] = both
        mass = np.maximum(gaussian(weight, sigma_px), 1e-6)
        columns.append(gaussian(steps, sigma_px) / mass[..., None])
    return np.asarray(np.stack(columns, -1), np.float64)
