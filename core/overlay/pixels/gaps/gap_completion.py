"""Cloth between the parts whose pattern was surely followed, sewn to them.

In a ruffle, a narrow fold or beside an edge the photo says how the cloth lies but for whole texels, or not at all, and
what fits it piece by piece is jumble. What is sure stays; sheets of it that lie apart are moved by whole texels, to
miss each other least; between them the cloth goes on with as little strain as it can, and jumps only where a fold must
hide some of it.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Singles
from core.overlay.composition import finite
from core.overlay.detail.model_validity import trust_in
from core.overlay.filters.distances import nearest_of
from core.overlay.filters.smoothing import gaussian
from core.overlay.filters.texture_filter import steepness
from core.overlay.pixels.extension import extend, find_sound, slopes_of
from core.overlay.pixels.filling import parts_with
from core.overlay.pixels.gaps.sheet_translation import find_translations
from core.overlay.pixels.gaps.weak_plate import Plate
from core.overlay.pixels.jacobian_validity import jumps, no_cloth
from core.overlay.texel import Texel
from core.overlay.tolerances import NEARBY_PX, STRETCH

SAMPLES, EVERY = 10, (2, 3)
"""Places along the side of a texel at which the cloth is looked at, as far as they are so many pixels apart."""
SURE = 0.5
"""How far cloth has to be trusted that stays."""
CRUMB, SHARE = 1.5, 0.2
"""Least area of a sheet, in lattice steps or over that of all cloth, whichever is less."""
AROUND = 1.5
"""Width, in lattice steps, of the neighbourhood whose slopes the cloth goes on with."""
TEAR = 0.03
"""Most that a strain costs, in lattice steps: a gap of w is closed where its sides miss each other by √(TEAR w)."""


@dataclass(frozen=True)
class Sewn:
    """Cloth of which every so many pixels are looked at."""

    sheet: Ints
    """(h, w), the number of the sheet that a place is surely of, -1 for none."""
    moved: Floats
    """(h, w, 2), whole texels by which the sheet is moved that a place is of, or nearest to."""
    uv: Floats
    """(h, w, 2), what is found, NaN where it is torn or crushed."""


def sew(
    photo: Floats | Singles,
    layers: tuple[Singles, Singles],
    texel: Texel,
    basis: Floats,
    step_px: float,
    *,
    hidden: Bools | None = None,
) -> tuple[Singles, Bools]:
    """Return coordinates (H, W, 2) that are those of cloth, and which pixels (H, W) were laid anew.

    `layers` are the coordinates and the shading (H, W) on the photo (H, W, 3), NaN outside the cloth; what is `hidden`
    (H, W) lies under another thing. `basis` (2, 2) is pixels of undeformed cloth a texel, `step_px` the side of a
    lattice step.
    """
    every = int(np.clip(round(float(np.sqrt(abs(np.linalg.det(basis)))) / SAMPLES), *EVERY))
    few = slice(None, None, every), slice(None, None, every)
    small = photo[few].astype(np.float32), layers[0][few].astype(np.float64), layers[1][few]
    under = np.zeros(small[2].shape, bool) if hidden is None else hidden[few]
    sure = sure_cloth(*small, texel, basis / every) & ~under
    sewn = between_sheets(small[1], sure, basis / every, step_px / every)
    if sewn is None:
        return layers[0], np.zeros(layers[1].shape, bool)
    return finer(layers[0], sewn, basis / every, NEARBY_PX / every, every)


def sure_cloth(photo: Singles, uv: Floats, light: Singles, texel: Texel, basis: Floats) -> Bools:
    """Return where (H, W) the photo (H, W, 3) shows that cloth lies as it was followed, or carried on from there."""
    covered, side = finite(uv), float(np.sqrt(abs(np.linalg.det(basis))))
    trust = trust_in(photo, uv.astype(np.float32), light, texel, covered, side)
    return np.asarray(covered & ~no_cloth(uv, basis, side) & (trust > SURE), np.bool_)


def between_sheets(uv: Floats, sure: Bools, basis: Floats, step_px: float) -> Sewn | None:
    """Return coordinates (H, W, 2) of which those of sheets that are `sure` (H, W) stay, but for whole texels.

    Where there is no sheet it is None.
    """
    covered = finite(uv)
    sheet = find_sheets(uv, sure, basis, min(CRUMB * step_px**2, SHARE * float(covered.sum())))
    fixed: Bools = sheet >= 0
    if not fixed.any():
        return None
    slopes = slopes_around(uv @ basis.T, fixed, AROUND * step_px)
    moved = find_translations(uv, sheet, slopes, basis, step_px)[sheet.ravel()[nearest_of(fixed)[1]]]
    return Sewn(sheet, moved, bridge(uv + moved, fixed, covered & ~fixed, slopes, basis, step_px))


def bridge(uv: Floats, fixed: Bools, free: Bools, slopes: Floats, basis: Floats, step_px: float) -> Floats:
    """Return coordinates (H, W, 2) that go on from where the cloth is `fixed` (H, W) over what is `free`.

    They are NaN where it would be torn or crushed; what does not hang together with anything fixed stays as it is.
    `slopes` are those of `slopes_around`.
    """
    free = free & parts_with(fixed, fixed | free)
    if not free.any():
        return uv
    found, plate = uv.copy(), Plate(uv @ basis.T, fixed, free, slopes)
    found[free] = plate.weakened(TEAR * step_px) @ np.linalg.inv(basis).T
    found[free & ~find_sound(slopes_of(found), abs(float(np.linalg.det(basis))))] = np.nan
    return found


def find_sheets(uv: Floats, sure: Bools, basis: Floats, least: float) -> Ints:
    """Return the number (H, W), from 0, of each sheet of sure cloth of so many pixels at least, -1 beside them.

    A sheet ends where its coordinates (H, W, 2) jump.
    """
    whole = sure & ~(finite(uv) & (jumps(uv, basis) > STRETCH))
    _, labels, stats, _ = cv2.connectedComponentsWithStats(whole.astype(np.uint8), connectivity=4)
    large = stats[:, cv2.CC_STAT_AREA] >= least
    large[0] = False
    return np.asarray(np.where(large, np.cumsum(large) - 1, -1)[labels], np.int64)


def slopes_around(places: Floats, fixed: Bools, sigma_px: float) -> Floats:
    """Return the mean slopes (H, W, 2, 2) of places (H, W, 2) by row and column around each pixel, of those `fixed`.

    They are as steep as the slopes themselves: those of sheets that lie differently would cancel.
    """
    own = np.stack([steepness(np.where(fixed[..., None], places, np.nan), axis) for axis in (0, 1)], -1)
    planes = np.concatenate([own.reshape(*fixed.shape, 4), (own**2).sum((-1, -2))[..., None]], -1)
    mass = gaussian(fixed.astype(np.float64), sigma_px)[..., None]
    means = gaussian(np.where(fixed[..., None], planes, 0.0), sigma_px) / np.maximum(mass, 1e-6)
    means = np.where(mass > 1e-3, means, planes[fixed].mean(0))
    slopes = means[..., :4].reshape(own.shape)
    steeper = np.sqrt(means[..., 4] / np.maximum((slopes**2).sum((-1, -2)), 1e-6))
    return np.asarray(slopes * np.clip(steeper, 1, 3)[..., None, None], np.float64)


def finer(uv: Singles, small: Sewn, basis: Floats, sigma_px: float, every: int) -> tuple[Singles, Bools]:
    """Return coordinates (H, W, 2), moved with their sheets or as found, and where (H, W) they were laid anew.

    What is found is of every so many pixels, in which `basis` (2, 2) and `sigma_px` are; from there the cloth goes
    straight on, with slopes that are means over `sigma_px`.
    """
    few = (slice(None, None, every),) * 2
    nearest = nearest_of(finite(uv[few]))[1]
    down, across = (
        np.minimum((np.arange(n) + every // 2) // every, m - 1)
        for n, m in zip(uv.shape[:2], nearest.shape, strict=True)
    )
    near = np.ix_(down, across)
    moved, found = (plane.reshape(-1, 2)[nearest].astype(np.float32) for plane in (small.moved, small.uv))
    out = uv + moved[near]
    # Beside a jump a pixel may be of another sheet than the place nearest to it.
    other = np.linalg.norm((out - found[near]) @ basis.T.astype(np.float32), axis=-1) > STRETCH
    anew = ((small.sheet.ravel()[nearest] < 0)[near] | other) & finite(uv)
    out[few] = small.uv
    mark = np.where(anew, np.float32(np.nan), np.float32(1))
    mark[few] = np.where(finite(small.uv), 1, np.nan)
    layers, texel_px = (out, mark), abs(float(np.linalg.det(basis)))
    return extend(layers, anew, texel_px, sigma_px, every)[0], anew
