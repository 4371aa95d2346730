"""Cloth laid anew where its coordinates cannot be those of cloth.

Where the pattern cannot be followed, in a ruffle seen from its edge or a sleeve in deep folds, what fits the photo
piece by piece is folded over, or blown up: cloth hardly stretches. There the sheet around goes on, as smooth as it can;
where that would still be blown up, for what a fold hides, its sides may meet in a jump.
"""

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Singles
from core.overlay.composition import finite, steepness
from core.overlay.continuation import Slopes, continuation
from core.overlay.distances import within
from core.overlay.joining import STRAIN, borders, finer, jumps
from core.overlay.mesh import around
from core.overlay.smoothing import gaussian
from core.overlay.texel import Texel
from core.overlay.trust import trust_in

SAMPLES, EVERY = 10, (2, 3)
"""Places along the side of a texel at which the cloth is looked at, as far as they are so many pixels apart."""
SIZES = (0.36, 2.2)
"""Pixels of undeformed cloth to a place, over its distance from the next one, that cloth may have in any direction."""
NEAR, SHARE = 0.12, 0.25
"""Width of a neighbourhood, over the side of a texel, and how much of it is no cloth around a place that is none."""
RIM, WIDER = 0.12, 0.3
"""Lattice steps around that are laid anew too, and around what is still no cloth then."""
SHEET, LEAST_SHARE = 4.0, 0.05
"""Area of a sheet that stays, in lattice steps or over that of all cloth, whichever is less."""
CRUMB, MOSTLY, SURE = 1.5, 0.95, 0.5
"""The same in lattice steps for one that lies as the photo shows, the share of it that does, and how far it has to be
trusted there."""
HOLD = Slopes(around=1.5, weight=0.02)
"""Slopes of the cloth that goes on: not those of its very rim, which may be torn itself."""
BESIDE_PX = 1.5
"""Distance from another sheet up to which a jump is one between sheets."""
REACH = 3.0
"""Lattice steps around what goes on whose slopes count."""


def relaid(
    photo: Floats, layers: tuple[Singles, Singles], texel: Texel, basis: Floats, step_px: float, scale: int = 1
) -> tuple[Singles, Bools]:
    """Return coordinates (H, W, 2) that are those of cloth, and which pixels (H, W) were laid anew.

    `layers` are the coordinates and the shading (H, W) on the photo (H, W, 3), NaN outside the cloth. Lengths are in
    `scale` pixels: `basis` (2, 2), pixels of undeformed cloth a texel, and `step_px`, the side of a lattice step.
    """
    side = float(np.sqrt(abs(np.linalg.det(basis))))
    every = int(np.clip(round(side / SAMPLES), *EVERY))
    few = slice(None, None, scale * every), slice(None, None, scale * every)
    uv, light = layers[0][few], layers[1][few]
    side, covered = side / every, np.isfinite(light)
    wild = no_cloth(uv.astype(np.float64), basis / every, side)
    if not wild.any():
        return layers[0], np.zeros(layers[1].shape, bool)
    sure = trust_in(photo[few].astype(np.float32), uv, light, texel, np.asarray(covered, np.bool_), side) > SURE
    found, anew = _relaid(uv.astype(np.float64), wild, sure, basis / every, step_px / every)
    return finer(layers[0], found, anew, scale * every)


def _relaid(uv: Floats, wild: Bools, sure: Bools, basis: Floats, step_px: float) -> tuple[Floats, Bools]:
    """Do what `relaid` does in each pixel to coordinates (H, W, 2) that are no cloth here, and sure there (H, W)."""
    covered, jump = finite(uv), np.asarray(jumps(uv, basis) > STRAIN, np.bool_)
    side = float(np.sqrt(abs(np.linalg.det(basis))))
    least = min(SHEET * step_px**2, LEAST_SHARE * float(covered.sum()))
    out, anew, torn = uv, np.zeros(covered.shape, bool), np.zeros(covered.shape, bool)
    for rim in (RIM, WIDER):
        if not wild.any():
            break
        lost = covered & (anew | within(wild, rim * step_px))
        owner, kept = sheets(np.asarray(covered & ~lost & ~jump, np.bool_), sure, (CRUMB * step_px**2, least))
        if not kept.any():
            return uv, kept
        # Beside a jump between two sheets cloth is as it should be.
        anew = covered & ~kept & (lost | ~jump | ~within(borders(owner, covered), BESIDE_PX))
        torn = parts_with(wild, anew) if out is not uv else torn
        out = uv.copy()
        for number in range(int(owner.max()) + 1):
            mine: Bools = np.asarray(covered & (owner == number), np.bool_)
            wanted = mine & anew
            if wanted.any():
                box = around(wanted, 3 + round(REACH * step_px))
                fixed, more = (mine & kept)[box], wanted[box]
                out[box][more] = continuation(uv[box], fixed, more, basis, step_px, may_tear=torn[box], hold=HOLD)
        wild = no_cloth(out, basis, side) & anew
    return out, anew


def no_cloth(uv: Floats, basis: Floats, side_px: float) -> Bools:
    """Return where (H, W) coordinates (H, W, 2) are folded over, blown up or crushed over a neighbourhood."""
    covered, at = finite(uv), uv @ basis.T
    J = np.stack([steepness(at, 1), steepness(at, 0)], -1)
    area = J[..., 0, 0] * J[..., 1, 1] - J[..., 0, 1] * J[..., 1, 0]
    if covered.any():
        area *= np.sign(np.median(area[covered]))
    # Both singular values, from their product and the sum of their squares.
    squares = np.einsum("...ij,...ij", J, J) / 2
    root = np.sqrt(np.maximum(squares**2 - area**2, 0))
    least, most = (np.sqrt(np.maximum(squares + sign * root, 0)) for sign in (-1, 1))
    wild = covered & ((area <= 0) | (least < SIZES[0]) | (most > SIZES[1]))
    share = gaussian(wild.astype(np.float32), NEAR * side_px)
    return np.asarray(wild & (share > SHARE * gaussian(covered.astype(np.float32), NEAR * side_px)), np.bool_)


def sheets(sound: Bools, sure: Bools, least: tuple[float, float]) -> tuple[Ints, Bools]:
    """Return the connected parts (H, W) of `sound` cloth (H, W) that stay, and before them which is nearest (H, W).

    Those do that have the larger one of `least` pixels, or the smaller one where they are mostly `sure` (H, W).
    """
    count, labels, stats, _ = cv2.connectedComponentsWithStats(sound.astype(np.uint8), connectivity=4)
    area = stats[:, cv2.CC_STAT_AREA]
    believed = np.bincount(labels.ravel(), sure.ravel(), count) > MOSTLY * area
    large = 1 + np.flatnonzero(area[1:] >= np.where(believed, min(least), max(least))[1:])
    number = np.full(count, -1)
    number[large] = np.arange(len(large))
    kept = number[labels] >= 0
    if not kept.any():
        return number[labels], kept
    _, places = cv2.distanceTransformWithLabels(
        (~kept).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    owner = np.empty(int(places.max()) + 1, np.int64)
    owner[places[kept]] = number[labels[kept]]
    return owner[places], np.asarray(kept, np.bool_)


def parts_with(marks: Bools, mask: Bools) -> Bools:
    """Return the connected parts of a mask (H, W) that have a mark (H, W)."""
    _, labels = cv2.connectedComponents(mask.astype(np.uint8), connectivity=4)
    return np.asarray(mask & np.isin(labels, np.unique(labels[marks & mask])), np.bool_)
