"""Crumbs of cloth, joined to the sheets beside them.

Pieces that were found apart, and cloth that is carried on from several sides, meet in jumps of the coordinates; between
jumps lie sheets. A crumb, too small to show a pattern of its own, and a sliver go on with the nearest sheet, whose
outline is rounded. Where both sides of a jump belong to one sheet, a short jump is closed over a neighbourhood; a long
one stays, as what lies between is hidden in a fold.
"""

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Singles
from core.overlay.composition import finite, steepness
from core.overlay.continuation import LARGEST, continuation
from core.overlay.distances import distance
from core.overlay.filling import solid
from core.overlay.mesh import around

STRAIN = 2.5
"""Pixels of undeformed cloth from one pixel to the next from which coordinates jump."""
CRUMB, SHARE = 2.0, 0.01
"""Least area of a sheet, in lattice steps and over that of all cloth."""
THIN = 0.25
"""Radius, in lattice steps, of a disc that fits into a sheet."""
CLOSED = 0.3
"""Lattice steps to each side over which a short jump within a sheet is closed."""
BORDER_PX = 3
"""Distance from another sheet up to which a jump is one between sheets."""
NEAR = 1.0
"""Lattice steps around what goes on whose slopes count."""


def joined(uv: Singles, basis: Floats, step_px: float, scale: int = 1) -> tuple[Singles, Bools]:
    """Return coordinates (H, W, 2) with crumbs and slivers joined to sheets, and which pixels (H, W) were laid anew.

    `uv` is NaN outside the cloth. Every `scale`-th pixel is looked at, in which `basis` (2, 2), pixels of undeformed
    cloth a texel, and `step_px`, the side of a lattice step, are.
    """
    few = uv[::scale, ::scale].astype(np.float64)
    found, other = whole(few, basis, step_px)
    return finer(uv, found, other, scale)


def finer(uv: Singles, found: Floats, anew: Bools, every: int) -> tuple[Singles, Bools]:
    """Return coordinates (H, W, 2) with those `found` (h, w, 2) where they are `anew` (h, w), and where (H, W) that is.

    The found ones are of every so many pixels.
    """
    if every > 1:
        # What is between two pixels may be torn from both.
        anew = (cv2.dilate(anew.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0) & finite(found)
    wide = np.repeat(np.repeat(anew, every, 0), every, 1)[: uv.shape[0], : uv.shape[1]] & finite(uv)
    rows, columns = np.nonzero(wide)
    r, c = rows // every, columns // every
    away = np.stack([columns - every * c, rows - every * r], -1) / every
    slopes = np.stack([steepness(found, 1)[r, c], steepness(found, 0)[r, c]], -1)
    out = uv.copy()
    out[rows, columns] = found[r, c] + np.einsum("nij,nj->ni", slopes, away)
    return out, np.asarray(wide, np.bool_)


def whole(uv: Floats, basis: Floats, step_px: float) -> tuple[Floats, Bools]:
    """Do what `joined` does to coordinates (H, W, 2) in each pixel."""
    covered, jump = finite(uv), jumps(uv, basis)
    owner, sound = sheets(covered, np.asarray(jump > STRAIN, np.bool_), step_px)
    crack = (jump > STRAIN) & (jump < LARGEST * step_px) & (distance(borders(owner, covered)) > BORDER_PX)
    if crack.any():
        sound &= distance(np.asarray(crack, np.bool_)) > CLOSED * step_px
    out, anew = uv.copy(), covered & ~sound & (owner >= 0)
    for number in range(int(owner.max(initial=-1)) + 1):
        mine: Bools = np.asarray(owner == number, np.bool_)
        wanted = mine & anew
        if wanted.any():
            box = around(wanted, 3 + round(NEAR * step_px))
            out[box][wanted[box]] = continuation(uv[box], mine[box] & sound[box], wanted[box], basis, step_px)
    return out, anew


def jumps(uv: Floats, basis: Floats) -> Floats:
    """Return the longest step (H, W), pixels of undeformed cloth, from each pixel to one beside it; 0 beyond."""
    out = np.zeros(uv.shape[:2])
    for here, there in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        length = np.nan_to_num(np.linalg.norm((uv[there] - uv[here]) @ basis.T, axis=-1))
        for side in (here, there):
            out[side] = np.maximum(out[side], length)
    return out


def sheets(covered: Bools, cut: Bools, step_px: float) -> tuple[Ints, Bools]:
    """Return the number (H, W) of the sheet that each pixel belongs to, -1 for none, and what of it is a sheet now.

    Sheets are what is `covered` (H, W) between the `cut` pixels.
    """
    _, labels, stats, _ = cv2.connectedComponentsWithStats((covered & ~cut).astype(np.uint8), connectivity=4)
    owner, sound = np.full(covered.shape, -1), np.zeros(covered.shape, bool)
    nearest = np.full(covered.shape, np.inf, np.float32)
    deep = distance(cut) > 2 * THIN * step_px
    least = max(CRUMB * step_px**2, SHARE * float(covered.sum()))
    large = 1 + np.flatnonzero(stats[1:, cv2.CC_STAT_AREA] >= least)
    for number, label in enumerate(large):
        mine: Bools = np.asarray(labels == label, np.bool_)
        core = solid(mine, THIN * step_px) | (mine & deep)
        away = distance(core) if core.any() else nearest
        nearer = away < nearest
        owner[nearer], nearest[nearer] = number, away[nearer]
        sound |= core
    return np.where(covered, owner, -1), sound


def borders(owner: Ints, covered: Bools) -> Bools:
    """Return the `covered` pixels (H, W) beside one of another `owner` (H, W)."""
    out = np.zeros(covered.shape, bool)
    for here, there in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        other = (owner[here] != owner[there]) & covered[here] & covered[there]
        out[here] |= other
        out[there] |= other
    return out
