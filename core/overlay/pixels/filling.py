"""Cloth that is seen but not followed: beside folds, between pieces and at the rim of a region that the user gave.

It has the colours of the texel. Cloth that is followed is carried on there: by the mesh, or from the nearest cloth
alone where the mesh would be crushed. A button or a belt has others and keeps the photo's pixels. In a region that the
user gave it may be however far from cloth that is followed, and however large, if it is as solid as cloth is; where
nobody said where the cloth is, only what cloth encloses is filled, and within a lattice step.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from core.arrays import Bools, Singles
from core.overlay.detail.sparse_reflectance import mean_light
from core.overlay.filters.distances import distance, open_by_disc
from core.overlay.filters.smoothing import gaussian
from core.overlay.mesh import Box, around
from core.overlay.palette import GROUPS, from_shades, palette
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.region import clean, continue_on
from core.overlay.registration.registration import ClothState
from core.overlay.tolerances import SHADES, STRETCH

GLARING = 2.2
"""Most light over that of the cloth around (`SHADES`), for a spot amid the cloth of a region that the user gave."""
OFF = 0.1
"""Least distance, at a shading of one, up to which a colour is one of the texel's."""
STRAIGHT = 0.5
"""Lattice steps by which the nearest cloth alone is carried on, but in a region that the user gave."""
SOLID = 0.2
"""Lattice steps of the radius of a disc that fits into cloth further away."""
SPOT = 3.5
"""Area, in lattice steps, up to which a spot amid cloth is cloth however it shines."""
AMID = 0.6
"""Share of the border of such a spot that it has with cloth."""
AROUND_PX = 1.5
"""Width of the neighbourhood of which most has to have a pixel's colour."""


@dataclass(frozen=True)
class Filling:
    """What is filled, as seen by the fit; the masks (H, W) do not overlap."""

    pieces: list[ClothState]
    """Pieces carried on."""
    masks: list[Bools]
    """What each of them fills."""
    apart: Bools
    """(H, W), what the nearest cloth alone fills."""


def filled(cloth: FittedCloth, found: Fit, pieces: list[ClothState], masks: list[Bools]) -> Filling:
    """Return what there is to fill beside the pixels (H, W) that the pieces explain."""
    covered = np.asarray(np.any(masks, axis=0), np.bool_)
    gaps = np.stack([distance(mask) for mask in masks])
    open_to = cloth.valid & ~covered
    if not cloth.in_region:
        open_to &= find_enclosed(covered, 2 * cloth.step_px) & (gaps.min(0) < cloth.step_px)
    owner = gaps.argmin(0)
    carried, possible = [], []
    photo, few = cloth.photo.astype(np.float32), palette(found.texel, GROUPS)
    margin = round(4 * AROUND_PX)  # a pixel's neighbourhood reaches no further
    alike = np.zeros(covered.shape, bool)
    for number, piece in enumerate(pieces):
        mine = open_to & (owner == number)
        further, sound = carried_on(cloth, piece, mine)
        carried.append(further)
        possible.append(sound)
        box = box_around(mine, margin)
        light = cloth.mesh.smooth_to_pixels(further.rho[..., None], box).astype(np.float32)
        alike[box] |= mine[box] & find_coloured_as(few, photo[box], found, light, SHADES)
    coloured = alike.copy()
    # Straight on, the pattern soon lies beside what the photo shows.
    reached = np.any(possible, axis=0) & (gaps.min(0) < cloth.step_px)
    whole = covered | (alike & (reached | (gaps.min(0) < STRAIGHT * cloth.step_px)))
    if cloth.in_region:
        box, colours = box_around(open_to, margin), palette(found.texel)
        seen, light = photo[box], mean_light(photo, cloth.valid, found.texel, cloth.basis)[box][..., None]
        alike[box] |= open_to[box] & find_coloured_as(colours, seen, found, light, SHADES)
        coloured[box] |= open_to[box] & find_coloured_as(colours, seen, found, light, (SHADES[0], GLARING))
        whole |= open_by_disc(covered | alike, SOLID * cloth.step_px)
    whole = clean(whole, cloth.sigma_px / 2)
    # What is left amid cloth, and no larger than this, is no belt.
    spots = amid(cloth.valid & ~whole, whole, SPOT * cloth.step_px**2) & open_to & coloured
    whole = clean(whole | spots, cloth.sigma_px / 2)
    masks = [np.asarray(mask & whole, np.bool_) for mask in possible]
    apart = open_to & whole & ~np.any(masks, axis=0)
    used = [number for number, mask in enumerate(masks) if mask.any()]
    return Filling([carried[number] for number in used], [masks[number] for number in used], apart)


def find_enclosed(covered: Bools, width_px: float) -> Bools:
    """Return what a mask (H, W) encloses: its holes, and gaps that no disc of so many pixels across gets into.

    Beyond the picture's edge nothing is covered.
    """
    _, labels = cv2.connectedComponents(np.pad(~covered, 1, constant_values=True).astype(np.uint8), connectivity=4)
    hole = labels[1:-1, 1:-1] != labels[0, 0]
    margin = round(width_px)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * (margin // 2) + 1,) * 2)
    closed = cv2.morphologyEx(np.pad(covered, margin).astype(np.uint8), cv2.MORPH_CLOSE, disc)
    closed = closed[margin : margin + covered.shape[0], margin : margin + covered.shape[1]]
    return np.asarray(~covered & (hole | (closed > 0)), np.bool_)


def carried_on(cloth: FittedCloth, piece: ClothState, wanted: Bools) -> tuple[ClothState, Bools]:
    """Return a piece with values at the nodes around wanted pixels (H, W), and those at which they are sound."""
    mesh, texel_px = cloth.mesh, abs(float(np.linalg.det(cloth.basis)))
    cells = piece.cells | (mesh.cell_means(wanted.astype(float)) > 0)
    cells = np.asarray(cv2.dilate(cells.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0, np.bool_)
    further = continue_on(mesh, piece, cells)
    low, usual, high = np.percentile(piece.rho[mesh.nodes_of(piece.cells)], [2, 50, 98])
    rho = np.where(mesh.nodes_of(cells), np.clip(further.rho, low, high), usual)
    areas = mesh.areas(further.uv, cells) * texel_px / mesh.cell**2
    areas *= np.sign(np.median(mesh.areas(piece.uv, piece.cells)))
    sound = cells.copy()
    sound[cells] = (areas.min(1) > 1 / STRETCH) & (areas.max(1) < STRETCH)
    near = gaussian(mesh.pixels_of(sound | piece.cells).astype(np.float64), mesh.cell / 2) > 0.5
    return replace(further, rho=rho, cells=piece.cells), np.asarray(wanted & near, np.bool_)


def parts_with(marks: Bools, mask: Bools) -> Bools:
    """Return the connected parts of a mask (H, W) that have a mark (H, W)."""
    _, labels = cv2.connectedComponents(mask.astype(np.uint8), connectivity=4)
    return np.asarray(mask & np.isin(labels, np.unique(labels[marks & mask])), np.bool_)


def amid(mask: Bools, covered: Bools, most: float) -> Bools:
    """Return those parts of a mask (H, W) of at most so many pixels that have mostly what is `covered` around them."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    sides = np.zeros((2, count))
    around = np.pad(covered, 1, mode="edge")
    beside = np.pad(mask, 1, mode="edge")
    for down, across in ((0, 1), (2, 1), (1, 0), (1, 2)):
        there = slice(down, down + mask.shape[0]), slice(across, across + mask.shape[1])
        for plane, total in zip((around[there], ~around[there] & ~beside[there]), sides, strict=True):
            total += np.bincount(labels[mask & plane], minlength=count)
    share = sides[0] / np.maximum(sides.sum(0), 1)
    return np.asarray(mask & ((stats[:, cv2.CC_STAT_AREA] <= most) & (share >= AMID))[labels], np.bool_)


def box_around(mask: Bools, margin: int) -> Box:
    """Return the rows and columns in which a mask (H, W) has marks, and `margin` more on each side where there are."""
    rows, columns = around(mask, margin)
    return slice(rows.start, min(rows.stop, len(mask))), slice(columns.start, min(columns.stop, mask.shape[1]))


def find_coloured_as(
    colours: Singles, photo: Singles, found: Fit, light: Singles, shades: tuple[float, float]
) -> Bools:
    """Return which pixels (H, W) of a photo (H, W, 3) have one of the colours (k, 3) in a shade of light (H, W, 1)."""
    off = np.min([from_shades(photo, light * colour, shades) for colour in colours], axis=0)
    limit = max(OFF, 3 * float(np.sqrt(found.tolerance.noise)))
    # Most of what is around a pixel has to have them.
    return np.asarray(gaussian((off < limit * light[..., 0]).astype(np.float32), AROUND_PX) > 0.6, np.bool_)
