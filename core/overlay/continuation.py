"""Coordinates carried on beside a sheet of cloth, pixel by pixel, as a thin plate with the slopes that it has nearby.

Minimised is the sum of the squared second differences of uv over the pixels, with a little of the squared difference of
the first ones from the mean slopes of the sheet around: far from it the cloth goes straight on. Differences over which
the sheet's two sides would miss each other by much are left out, and there the coordinates jump.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy import sparse

from core.arrays import Bools, Floats, Ints
from core.factor import Factor
from core.overlay.distances import distance
from core.overlay.mesh import Mesh
from core.overlay.smoothing import gaussian

LARGEST = 0.5
"""Lattice steps by which two sides miss each other from which the coordinates jump between them."""
HOLD = 1e-9
"""Weight of the guess, for pixels that nothing else holds."""
EXTENT_PX = 3.0
"""How far, on even cloth, the pixels of a difference lie apart at most."""
REACH_PX = 3.5
"""Distance up to which the sheet holds what goes on."""


@dataclass(frozen=True)
class Slopes:
    """The slopes that hold what goes on."""

    around: float = 0.5
    """Width, in lattice steps, of the neighbourhood that gives them."""
    weight: float = 1e-3
    """Of the squared differences from them, over that of the second differences."""


def continuation(
    uv: Floats,
    fixed: Bools,
    wanted: Bools,
    basis: Floats,
    step_px: float,
    *,
    may_tear: Bools | None = None,
    hold: Slopes = Slopes(),
) -> Floats:
    """Return coordinates (n, 2) at the n `wanted` pixels (H, W) from those (H, W, 2) at `fixed` ones.

    `basis` (2, 2) is pixels of undeformed cloth a texel, `step_px` the side of a lattice step. The coordinates jump
    only where they `may_tear` (H, W), anywhere if that is not given.
    """
    slopes = mean_slopes(uv, fixed, hold.around * step_px)
    guess = straight_on(uv, fixed, slopes)
    flat, apart = guess.reshape(-1, 2), LARGEST * step_px + EXTENT_PX
    used, new = wanted | (fixed & (distance(wanted) < REACH_PX)), np.flatnonzero(wanted)
    values = np.where(fixed[..., None], uv, 0.0).reshape(-1, 2)
    bending = Mesh((wanted.shape[0] - 1, wanted.shape[1] - 1), 1).bending(used)
    whole = np.zeros(used.size) if may_tear is None else (~may_tear).ravel().astype(np.float64)
    bending = bending[(extents(bending, flat @ basis.T) < apart) | (abs(bending) @ whole > 0)]
    rows, right = [bending], [-(bending @ values)]
    for axis in (0, 1):
        steps, start = first_differences(used, wanted, axis)
        kept = (extents(steps, flat @ basis.T) < apart) | (abs(steps) @ whole > 0)
        steps, start = steps[kept], start[kept]
        rows.append(hold.weight**0.5 * steps)
        right.append(hold.weight**0.5 * (slopes[..., axis].reshape(-1, 2)[start] - steps @ values))
    matrix = sparse.csr_array(sparse.vstack(rows))[:, new]
    normal = sparse.csc_array(matrix.T @ matrix + HOLD * sparse.eye_array(len(new)))
    return np.asarray(Factor(normal).solve(matrix.T @ np.concatenate(right) + HOLD * flat[new]), np.float64)


def mean_slopes(uv: Floats, fixed: Bools, sigma_px: float) -> Floats:
    """Return the mean slopes (H, W, 2, 2) of `uv` by row and column around each pixel, of those `fixed` (H, W)."""
    known, columns = np.where(fixed[..., None], uv, np.nan), []
    for axis in (0, 1):
        after = [(0, int(a == axis)) for a in (0, 1, 2)]
        steps = np.pad(np.diff(known, axis=axis), after, constant_values=np.nan)
        seen = np.isfinite(steps[..., 0])
        mass = gaussian(seen.astype(np.float64), sigma_px)
        usual = steps[seen].mean(0) if seen.any() else np.zeros(2)
        near = gaussian(np.nan_to_num(steps), sigma_px) / np.maximum(mass, 1e-6)[..., None]
        columns.append(np.where((mass > 1e-3)[..., None], near, usual))
    return np.stack(columns, -1)


def straight_on(uv: Floats, fixed: Bools, slopes: Floats) -> Floats:
    """Return coordinates (H, W, 2) that go straight on from the nearest of the `fixed` pixels (H, W)."""
    _, labels = cv2.distanceTransformWithLabels(
        (~fixed).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    rows, columns = np.nonzero(fixed)
    number = np.zeros(int(labels.max()) + 1, np.int64)
    number[labels[rows, columns]] = np.arange(len(rows))
    row, column = rows[number[labels]], columns[number[labels]]
    y, x = np.indices(fixed.shape)
    away = np.stack([y - row, x - column], -1)
    return np.asarray(uv[row, column] + np.einsum("hwij,hwj->hwi", slopes[row, column], away), np.float64)


def first_differences(used: Bools, wanted: Bools, axis: int) -> tuple[sparse.csr_array, Ints]:
    """Return the differences along an axis between `used` pixels (H, W), one `wanted` (H, W), and where each begins."""
    number = np.moveaxis(np.arange(used.size).reshape(used.shape), axis, 0)
    here, there = number[:-1].ravel(), number[1:].ravel()
    both = used.ravel()[here] & used.ravel()[there] & (wanted.ravel()[here] | wanted.ravel()[there])
    here, there = here[both], there[both]
    rows, signs = np.repeat(np.arange(len(here)), 2), np.tile([-1.0, 1.0], len(here))
    places = np.stack([here, there], -1).ravel()
    return sparse.csr_array((signs, (rows, places)), shape=(len(here), used.size)), here


def extents(rows: sparse.csr_array, places: Floats) -> Floats:
    """Return how far the places (n, 2) of each row's entries lie apart."""
    if not rows.shape[0]:
        return np.zeros(0)
    at = places[rows.indices]
    ends = [part.reduceat(at, rows.indptr[:-1], axis=0) for part in (np.maximum, np.minimum)]
    return np.asarray(np.linalg.norm(ends[0] - ends[1], axis=-1), np.float64)
