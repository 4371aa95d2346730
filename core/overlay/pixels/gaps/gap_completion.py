"""Cloth between the parts whose pattern was surely followed, sewn to them.

In a ruffle, a narrow fold or beside an edge the photo says how the cloth lies but for whole texels, or not at all, and
what fits it piece by piece is jumble. What is sure stays; sheets of it that lie apart are moved by whole texels, to
miss each other least; between them the cloth goes on with as little strain as it can, and jumps only where a fold must
hide some of it. A small sheet that would be torn from the others all around is chance and goes on with them.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Singles
from core.overlay.composition import finite
from core.overlay.detail.model_validity import trust_in
from core.overlay.filters.bands import bands
from core.overlay.filters.distances import distance, nearest_of, open_by_disc, within
from core.overlay.filters.smoothing import gaussian
from core.overlay.filters.texture_filter import steepness
from core.overlay.pixels.gaps.sheet_translation import find_translations
from core.overlay.pixels.gaps.unwrapping import unwrap
from core.overlay.pixels.gaps.weak_plate import Plate
from core.overlay.pixels.jacobian_validity import jumps, no_cloth
from core.overlay.texel import Texel
from core.overlay.tolerances import STRETCH

SAMPLES, EVERY = 10, (2, 3)
"""Places along the side of a texel at which the cloth is looked at, as far as they are so many pixels apart."""
SURE = 0.5
"""How far cloth has to be trusted that stays."""
THIN = 0.15
"""Radius, in lattice steps, of a disc that fits into cloth that was carried on."""
RIM = 0.15
"""Lattice steps beside a jump of the coordinates that are not sure."""
CRUMB, SHARE = 1.5, 0.2
"""Least area of a sheet, in lattice steps or over that of all cloth, whichever is less."""
AROUND = 1.5
"""Width, in lattice steps, of the neighbourhood whose slopes the cloth goes on with."""
TEAR = 0.1
"""Most that a strain costs, in lattice steps: a gap of w is closed where its sides miss each other by √(TEAR w)."""
TORN = 1.5
"""Strain of a step that is torn."""
WORTH, MOST, LARGE = 0.75, 25.0, 0.1
"""Area of a sheet, in lattice steps, over the length by which it is torn from others that it is worth; the area from
which it stays in any case, and the same over that of all cloth."""


@dataclass(frozen=True)
class Sewn:
    """Cloth of which every so many pixels are looked at."""

    sheet: Ints
    """(h, w), the number of the sheet that a place is surely of, -1 for none."""
    moved: Floats
    """(h, w, 2), whole texels by which what is surely of a sheet is moved."""
    uv: Floats
    """(h, w, 2), what is found, NaN where it is torn."""


def sew(
    photo: Floats | Singles,
    layers: tuple[Singles, Singles],
    followed: Bools,
    texel: Texel,
    basis: Floats,
    step_px: float,
    scale: int = 1,
    *,
    hidden: Bools | None = None,
) -> tuple[Singles, Bools]:
    """Return coordinates (H, W, 2) that are those of cloth, and which pixels (H, W) were laid anew.

    `layers` are the coordinates and the shading (H, W) on the photo (H, W, 3), NaN outside the cloth, of which the
    `followed` (H, W) has been registered; what is `hidden` (H, W) lies under another thing. Lengths are in `scale`
    pixels: `basis` (2, 2), pixels of undeformed cloth a texel, and `step_px`, the side of a lattice step.
    """
    every = int(np.clip(round(float(np.sqrt(abs(np.linalg.det(basis)))) / SAMPLES), *EVERY))
    few = slice(None, None, scale * every), slice(None, None, scale * every)
    small = photo[few].astype(np.float32), layers[0][few].astype(np.float64), layers[1][few]
    under = np.zeros(small[2].shape, bool) if hidden is None else hidden[few]
    sure = sure_cloth(small, followed[few], texel, basis / every, step_px / every) & ~under
    return finer(layers[0], between_sheets(small[1], sure, under, basis / every, step_px / every), scale * every)


def sure_cloth(
    seen: tuple[Singles, Floats, Singles], followed: Bools, texel: Texel, basis: Floats, step_px: float
) -> Bools:
    """Return where (H, W) the photo shows that cloth lies as it was followed, or carried on from there.

    `seen` are the photo (H, W, 3), the coordinates and the shading.
    """
    (photo, uv, light), side = seen, float(np.sqrt(abs(np.linalg.det(basis))))
    covered = finite(uv)
    sound = covered & ~no_cloth(uv, basis, side)
    trust, carried = (
        trust_in(photo, uv.astype(np.float32), light, texel, held, side) for held in (followed & covered, covered)
    )
    wide = open_by_disc(np.asarray(sound & (carried > SURE), np.bool_), THIN * step_px)
    return np.asarray((sound & followed & (trust > SURE)) | wide, np.bool_)


def between_sheets(uv: Floats, sure: Bools, hidden: Bools, basis: Floats, step_px: float) -> Sewn:
    """Return coordinates (H, W, 2) of which those that are `sure` (H, W) stay, but for whole texels.

    Tears in what is `hidden` (H, W) do no harm.
    """
    covered = finite(uv)
    labels, torn = label_followed(uv, sure, basis, step_px)
    turned, sure = unwrap(uv, labels, torn, basis, step_px)
    uv = uv + turned
    labels, _ = label_followed(uv, sure, basis, step_px)
    large = np.bincount(labels.ravel()) >= min(CRUMB * step_px**2, SHARE * float(covered.sum()))
    large[0] = False
    while True:
        sheet = numbered(labels, large)
        fixed: Bools = sheet >= 0
        free = covered & ~fixed
        if not fixed.any() or not free.any():
            return Sewn(np.where(covered, 0, -1), turned, uv)
        slopes = slopes_around(uv @ basis.T, fixed, AROUND * step_px)
        moved = np.where(fixed[..., None], find_translations(uv, sheet, slopes, basis, step_px)[sheet], 0.0)
        found = uv + moved
        plate = Plate(found @ basis.T, fixed, free, slopes)
        places, strain = plate.torn(TEAR * step_px)
        tears = plate.ends[strain > TORN]
        chance = least_worth(sheet, tears[~hidden.ravel()[tears].all(1)], covered, step_px)
        if not chance.any():
            found[free] = places @ np.linalg.inv(basis).T
            found.reshape(-1, 2)[tears[~fixed.ravel()[tears]]] = np.nan
            return Sewn(sheet, moved + turned, found)
        large[np.flatnonzero(large)[chance]] = False


def label_followed(uv: Floats, sure: Bools, basis: Floats, step_px: float) -> tuple[Ints, Bools]:
    """Return the number (H, W) of each connected sheet of sure cloth, from 1, 0 for none, and what is beside a jump."""
    jumping = np.asarray(finite(uv) & (jumps(uv, basis) > STRETCH), np.bool_)
    torn = within(jumping, max(RIM * step_px, 1.0))
    return np.asarray(cv2.connectedComponents((sure & ~torn).astype(np.uint8), connectivity=4)[1], np.int64), torn


def numbered(labels: Ints, kept: Bools) -> Ints:
    """Return labels (H, W) as the numbers, from 0, of those that are kept (n,), -1 for others."""
    return np.asarray(np.where(kept, np.cumsum(kept) - 1, -1)[labels], np.int64)


def least_worth(sheet: Ints, tears: Ints, covered: Bools, step_px: float) -> Bools:
    """Return which sheets (H, W) are too small for the tears (n, 2) beside them: of those the half that is smallest.

    Tears are given by the numbers of the pixels on both sides; all cloth is what is `covered` (H, W). What was not sure
    beside a jump is the sheet's too.
    """
    area, length = np.zeros((2, int(sheet.max()) + 1))
    for number in range(len(area)):
        away = distance(np.asarray(sheet == number, np.bool_))
        area[number] = (away <= RIM * step_px).sum()
        length[number] = (away.ravel()[tears].min(1) < step_px).sum()
    worth = area / np.maximum(WORTH * step_px * length, 1e-9)
    worth[(area == area.max()) | (area > min(MOST * step_px**2, LARGE * float(covered.sum())))] = np.inf
    little = worth < 1
    return np.asarray(worth <= np.median(worth[little]) if little.any() else little, np.bool_)


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


def finer(uv: Singles, small: Sewn, every: int) -> tuple[Singles, Bools]:
    """Return coordinates (H, W, 2), moved with their sheets or as found, and where (H, W) they were laid anew.

    What is found is of every so many pixels; from the nearest of them the cloth goes straight on.
    """
    h, w = small.sheet.shape
    nearest = nearest_of(finite(small.uv))[1]
    slopes = np.stack([steepness(small.uv, 0), steepness(small.uv, 1)], -1).reshape(-1, 2, 2)
    free, moved = small.sheet.ravel()[nearest] < 0, small.moved.reshape(-1, 2)[nearest]
    down, across = (
        np.minimum((np.arange(n) + every // 2) // every, m - 1) for n, m in zip(uv.shape[:2], (h, w), strict=True)
    )
    out, anew = uv.copy(), np.zeros(uv.shape[:2], bool)
    for _, top, bottom, _ in bands(uv.shape, margin=0):
        near = np.ix_(down[top:bottom], across)
        if moved[near[0].ravel()].any():
            out[top:bottom] += moved[near]
        rows, columns = np.nonzero(free[near] & finite(uv[top:bottom]))
        place = nearest[down[top:bottom][rows], across[columns]]
        rows += top
        way = np.stack([rows / every - place // w, columns / every - place % w], -1)
        out[rows, columns] = small.uv.reshape(-1, 2)[place] + np.einsum("nij,nj->ni", slopes[place], way)
        anew[rows, columns] = True
    return out, anew
