"""Cloth whose pattern was lost, found again: carried straight on, it lies beside the photo's by a part of a texel.

By which part is one of a few shifts at every place. It costs how far the photo is from any shade of the texture so
shifted, over a neighbourhood, and a little more than none does. Cloth that has been followed is not shifted, and holds
the rest: a shift is the next one to that beside it, but where a fold hides some of the pattern, so that the coordinates
jump there. Other jumps are chance. The shifts are evened, held back where they would stretch the cloth, and dropped
where the photo is hardly nearer than before.
"""

import cv2
import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.filters.smoothing import gaussian
from core.overlay.palette import from_shades
from core.overlay.pixels.matching import best_shift, sum_along_paths
from core.overlay.texel import Texel
from core.overlay.tolerances import MOTIF, SHADES, STRETCH

STEP_PX, FEWEST, MOST = 1.75, 3, 10
"""Pixels between two shifts, and how many there are along a side of the texel."""
FURTHEST = 1.5
"""Most that a pixel counts, over the spread of the texel's colours, as the costs of changes do."""
HABIT = 0.12
"""What any shift costs at every place: the cloth lies as it is carried on unless the photo says otherwise."""
INSIDE = (0.6, 1.6)
"""Share of a neighbourhood that is lost, twice, up to which the cloth is not shifted, and from which it is wholly."""
WORTH, AROUND = (0.75, 0.9), 0.4
"""How far shifted cloth is from the photo, over what it was, up to which the shift is believed, and from which it is
chance; width of the neighbourhood, over the side of a texel."""
STEEPEST = 1.0
"""Most change of a shift over the distance of two places."""


def shifts_where_lost(
    photo: Singles, uv: Singles, shading: Singles, texel: Texel, basis: Floats, lost: Bools
) -> Floats:
    """Return by how many texels (H, W, 2) the coordinates `uv` (H, W, 2) move where the pattern is `lost` (H, W).

    `uv` and `shading` (H, W) are NaN outside the cloth, `photo` is (H, W, 3), `basis` (2, 2) pixels of undeformed cloth
    a texel.
    """
    covered, side = np.isfinite(shading), float(np.sqrt(abs(np.linalg.det(basis))))
    seen, cuts = (photo[lost], uv[lost].astype(np.float64), shading[lost]), cuts_in(uv, basis)
    costs = costs_of(seen, texel, basis, lost, covered)
    costs[1:] += HABIT
    sums = sum_along_paths(by_sides(costs, basis), covered, cuts)
    shift = even_out(unwrap(best_shift(sums), lost, cuts), lost, covered, 2 * MOTIF * side)
    shift *= hold_back(shift, cuts, covered, basis, 2 * MOTIF * side)[..., None]
    before, after = (mean_where(lost, unlike(seen, by, texel), AROUND * side) for by in (np.zeros(2), shift[lost]))
    worth = (WORTH[1] - after / np.maximum(before, 1e-3)) / (WORTH[1] - WORTH[0])
    return shift * np.clip(worth, 0, 1)[..., None]


def by_sides(costs: Singles, basis: Floats) -> Singles:
    """Return the costs (n, H, W) of shifts by those along either side (rows, columns, H, W)."""
    columns, rows = counts_of(basis)
    return costs.reshape(rows, columns, *costs.shape[1:])


def counts_of(basis: Floats) -> tuple[int, int]:
    """Return how many shifts are tried along either side of the texel."""
    columns, rows = (int(np.clip(round(float(n) / STEP_PX), FEWEST, MOST)) for n in np.linalg.norm(basis, axis=0))
    return columns, rows


def costs_of(
    seen: tuple[Singles, Floats, Singles], texel: Texel, basis: Floats, lost: Bools, covered: Bools
) -> Singles:
    """Return the costs (n, H, W) of the shifts, of which the first is none.

    `seen` are the photo (n, 3), coordinates (n, 2) and shading (n,) where the pattern is `lost` (H, W).
    """
    columns, rows = counts_of(basis)
    v, u = np.divmod(np.arange(rows * columns), columns)
    costs = np.zeros((rows * columns, *lost.shape), np.float32)
    costs[1:, covered & ~lost] = FURTHEST
    near = 2 * MOTIF * float(np.sqrt(abs(np.linalg.det(basis))))
    for plane, step in zip(costs, np.stack([u / columns, v / rows], -1), strict=True):
        plane[lost] += mean_where(lost, unlike(seen, step, texel), near)[lost]
    return costs


def mean_where(lost: Bools, values: Singles, sigma_px: float) -> Singles:
    """Return the mean (H, W) around each place of values (n,) at the `lost` ones (H, W)."""
    plane = np.zeros(lost.shape, np.float32)
    plane[lost] = values
    share = np.maximum(gaussian(lost.astype(np.float32), sigma_px), 1e-3)
    return np.asarray(gaussian(plane, sigma_px) / share, np.float32)


def unlike(seen: tuple[Singles, Floats, Singles], step: Floats, texel: Texel) -> Singles:
    """Return how far (n,) pixels are from any shade of the texture a step, (2,) or (n, 2), on, over its own spread.

    `seen` are the photo (n, 3), coordinates (n, 2) and shading (n,).
    """
    photo, uv, light = seen[0].astype(np.float64), seen[1], seen[2].astype(np.float64)[:, None]
    spread = float(np.sqrt(texel.pixels.var(axis=(0, 1)).sum()))
    off = from_shades(photo, light * texel.at(uv + step), SHADES) / np.maximum(light[:, 0] * spread, 1e-3)
    return np.minimum(off, FURTHEST).astype(np.float32)


def cuts_in(uv: Singles, basis: Floats) -> tuple[Bools, Bools]:
    """Return at which places (H, W) coordinates (H, W, 2) jump from the one above, and from the one to the left."""
    above, left = (
        np.linalg.norm(np.diff(uv.astype(np.float64), axis=axis, prepend=np.nan) @ basis.T, axis=-1) > STRETCH
        for axis in (0, 1)
    )
    return np.asarray(above, np.bool_), np.asarray(left, np.bool_)


def unwrap(shift: Floats, lost: Bools, cuts: tuple[Bools, Bools]) -> Floats:
    """Return shifts (H, W, 2), known but for whole texels, within half a texel of the mean of their part of `lost`."""
    _, labels = cv2.connectedComponents((lost & ~cuts[0] & ~cuts[1]).astype(np.uint8), connectivity=4)
    turns = np.exp(2j * np.pi * shift)
    sums = [[np.bincount(labels.ravel(), part[..., k].ravel()) for k in (0, 1)] for part in (turns.real, turns.imag)]
    middle = (np.arctan2(sums[1], sums[0]) / (2 * np.pi)).T[labels]
    return np.asarray(middle + (shift - middle + 0.5) % 1 - 0.5, np.float64)


def even_out(shift: Floats, lost: Bools, covered: Bools, sigma_px: float) -> Floats:
    """Return shifts (H, W, 2) that are means of those around on what is `covered` (H, W), and end where `lost` does."""
    mass = np.maximum(gaussian(covered.astype(np.float64), sigma_px), 1e-3)
    share = 2 * gaussian(lost.astype(np.float64), sigma_px) / mass
    inside = np.clip((share - INSIDE[0]) / (INSIDE[1] - INSIDE[0]), 0, 1) * lost
    soft = gaussian(np.where(lost[..., None], shift, 0.0), sigma_px) / mass[..., None]
    return np.asarray(inside[..., None] * soft, np.float64)


def hold_back(shift: Floats, cuts: tuple[Bools, Bools], covered: Bools, basis: Floats, sigma_px: float) -> Floats:
    """Return by how much (H, W), 0 to 1, shifts (H, W, 2) may go so that they stretch the cloth nowhere too far."""
    stretch = np.zeros(covered.shape)
    for axis, cut in enumerate(cuts):
        change = np.linalg.norm(np.diff(shift, axis=axis, prepend=0) @ basis.T, axis=-1)
        stretch = np.maximum(stretch, np.where(cut | ~covered, 0.0, change))
    around = 2 * round(2 * sigma_px) + 1
    worst = cv2.dilate(stretch, np.ones((around, around), np.uint8))
    return np.asarray(gaussian(np.minimum(1, STEEPEST / np.maximum(worst, 1e-6)), sigma_px), np.float64)
