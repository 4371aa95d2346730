"""Where patches go, in which order, and which place of the source belongs to each."""

from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.retexture.deformation.coordinates import Feet, SpineCurves
from core.retexture.deformation.diffusion import Diffusion
from core.retexture.origins import Origins
from core.retexture.source_outside_frame import find_stand_ins, has_surroundings

AHEAD = 2
"""How many patches a row is ahead of the next."""
MOSTLY = 0.5
"""From this share on a place's source is mostly found along the curve."""
PACE_PX = 4.0
"""The pace of a curve is measured over this length to either side."""


@dataclass(frozen=True)
class PatchGrid:
    """Distances between neighbouring origins, px."""

    along: float
    across: float
    shift: float = 0.0
    """Where it begins, as a share of the spacing: at 0.5 origins fall upon the seams of a lattice at 0."""


@dataclass(frozen=True, eq=False)
class Correspondence:
    """What leads from a place of the result to its place in the source."""

    source: SpineCurves
    target: SpineCurves
    grid: Diffusion
    displacement: Floats
    """(R, C, 2) D of the plain deformation at the grid's nodes."""
    compression: Floats
    """(R, C) at the nodes, from 1 to 3."""
    inner: Singles
    nearness: Singles
    """(H, W) shares of texture's own scale and of the curves' coordinates, see `region.Region`."""
    contrast: Singles
    """(H, W) of fine texture, see `region.contrast`."""
    free: Singles
    """(H, W) see `region.Region`."""
    missing: Bools
    """(H, W) where the source would lie outside the picture, and other parts of the curve stand for it."""
    rib: int
    """Half size of patches across the curve, px."""

    def origins(self, places: Points) -> Origins:
        """Return origins at `places` (n, 2).

        Near a curve the source lies at the same distance from the curve, at the same parameter; towards the edge of
        the region it goes over into where the deformation has it (DPD sec. 3.3: q + D(q)), and turns as the
        deformation does, so that both join there. Where the source would lie outside the picture, another part of the
        curve stands for it, except where the deformation mostly does.
        """
        feet, along_curve, source_heading = along_curves(self.source, self.target, places)
        height, width = self.nearness.shape
        x, y = np.clip(np.rint(places).astype(int), 0, [width - 1, height - 1]).T
        share = np.where(feet.beyond, 0, self.nearness[y, x])
        lost = (
            (share >= MOSTLY)
            & self.missing[y, x]
            & ~has_surroundings(along_curve, places, self.nearness.shape, self.rib)
        )
        found, *other = find_missed(
            self.source, self.target, feet.taken(lost), places[lost], self.nearness.shape, self.rib
        )
        lost[lost] = found
        along_curve[lost], source_heading[lost] = (part[found] for part in other)
        share[lost] = 1
        plain, carried = self._deformed(places, feet.heading)
        place = share[:, None] * along_curve + (1 - share[:, None]) * plain
        turn = (1 - share) * _angle(self.source.feet(place).heading, carried)
        scale = self.scale_at(places)
        source_heading = np.where(share[:, None] < 0.5, carried, source_heading)
        free = self.free[y, x].astype(np.float64)
        return Origins(places, feet.heading, place, source_heading, turn, feet.offset, feet.curve, free, scale)

    def _deformed(self, places: Points, heading: Points) -> tuple[Points, Points]:
        """Return where the deformation has `places` (n, 2) in the source, and `heading` there."""
        step = 2 * heading
        ahead, behind = (p + self.grid.at(self.displacement, p) for p in (places + step, places - step))
        return places + self.grid.at(self.displacement, places), ahead - behind

    def scale_at(self, places: Points) -> Floats:
        """Return by how much patches at `places` (n, 2) are smaller: 1, 2 or 3."""
        return np.rint(self.grid.at(self.compression[..., None], places)[:, 0])


def along_curves(source: SpineCurves, target: SpineCurves, places: Points) -> tuple[Feet, Points, Points]:
    """Return the feet of `places` (n, 2) on target curves, what corresponds at the source, and the tangents there.

    That is the place as far from the source curve, at the same parameter (or share of the length, see
    `bezier.pair_parameters`).
    """
    feet = target.feet(places)
    length = _source_length(source, target, feet.curve, feet.length)
    return feet, *source.place(feet.curve, length, feet.offset)


def find_missed(
    source: SpineCurves, target: SpineCurves, feet: Feet, places: Points, size: tuple[int, ...], rib: int
) -> tuple[Bools, Points, Points]:
    """Return what stands for the sources of `places` (n, 2) with these feet on target curves."""
    length = _source_length(source, target, feet.curve, feet.length)
    return find_stand_ins(source, feet.curve, length, feet.offset, places, size, rib)


def pace(source: SpineCurves, target: SpineCurves, feet: Feet) -> Floats:
    """Return how many px of the source curve (n,) go by at feet (n,) on the target for each px there."""
    before, after = (_source_length(source, target, feet.curve, feet.length + step) for step in (-PACE_PX, PACE_PX))
    return (after - before) / (2 * PACE_PX)


def _source_length(source: SpineCurves, target: SpineCurves, curve: Ints, length: Floats) -> Floats:
    """Return the arc lengths (n,) on source curves that belong to those on their targets."""
    found = np.empty(len(length))
    for i, (there, here) in enumerate(zip(source.curves, target.curves, strict=True)):
        mine = curve == i
        if there.segments == here.segments:
            found[mine] = there.length_at(here.parameter_at(length[mine]))
        else:
            found[mine] = length[mine] * there.length / here.length
    return found


def _angle(start: Points, end: Points) -> Floats:
    """Return by how much to turn `start` (n, 2) into the line of `end` (n, 2), from -90 to 90 degrees."""
    angle = np.arctan2(end[:, 1], end[:, 0]) - np.arctan2(start[:, 1], start[:, 0])
    return np.asarray((angle + np.pi / 2) % np.pi - np.pi / 2)


def order_origins(way: Correspondence, wanted: Bools, lattice: PatchGrid) -> Origins:
    """Return origins over the pixels `wanted` (H, W): nearest to the curves first, each row from its ends inwards.

    That is DPD's priority (sec. 3.4): at the ends rows are beside what stands already. But a row begins as soon as the
    one before it is two patches ahead: patches that do not touch follow each other. Where the patches are smaller, so
    are the distances between them, and they come after the larger ones.
    """
    wanted = cv2.dilate(wanted.astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
    sample = 8.0 * np.argwhere(wanted[::8, ::8])[:, ::-1].astype(np.float64)
    reach_px = float(way.target.distance(sample).max(initial=0.0)) + 12
    places = []
    for scale in range(1, round(float(way.compression.max())) + 1):
        finer = PatchGrid(lattice.along / scale, lattice.across / scale, lattice.shift)
        place, offset, along = _rows(way.target, reach_px, finer)
        fits = np.flatnonzero(_touching(place, wanted))
        fits = fits[way.scale_at(place[fits]) == scale]
        # Behind the line where a bend's ribs meet, another part of the curve is nearer.
        fits = fits[np.abs(way.target.distance(place[fits]) - np.abs(offset[fits])) < 1.0]
        row = np.rint(np.abs(offset[fits]) / finer.across)
        order = np.lexsort((row, AHEAD * row + np.rint(along[fits] / finer.along)))
        places.append(place[fits[order]])
    return way.origins(np.concatenate(places))


def _rows(curves: SpineCurves, reach_px: float, lattice: PatchGrid) -> tuple[Points, Floats, Floats]:
    """Return places (n, 2) in rows parallel to the curves, distances from these, and from where rows begin (n,).

    At distance d the curve has length s - d turn(s): rows keep their own spacing, so that patches neither crowd
    inside a bend nor part outside.
    """
    count = int(reach_px // lattice.across) + 1
    rows = []
    for i, curve in enumerate(curves.curves):
        length, turn = curves.length[curves.index == i], curves.turn[curves.index == i]
        for row in (np.arange(-count, count + 1) + lattice.shift) * lattice.across:
            along = np.maximum.accumulate(length - row * turn)
            number = max(int(np.ceil(along[-1] / lattice.along)), 1)
            share = (np.arange(number + (not curve.closed and lattice.shift == 0)) + lattice.shift) / number
            at = np.interp(share * along[-1], along, length)
            first = np.abs(share - 0.5) if curve.closed else np.minimum(share, 1 - share)
            rows.append(np.stack([np.full(len(at), i), at, np.full(len(at), row), first * along[-1]]))
    which, length, offset, first = np.concatenate(rows, axis=1)
    return curves.place(which.astype(np.int64), length, offset)[0], offset, first


def _touching(places: Points, wanted: Bools) -> Bools:
    """Return which `places` (n, 2) lie on a wanted pixel, or just beyond the picture beside one."""
    size = np.array(wanted.shape[::-1])
    pixel = np.rint(places).astype(int)
    beside = ((pixel > -8) & (pixel < size + 8)).all(axis=1)
    x, y = np.clip(pixel, 0, size - 1).T
    return np.asarray(beside & wanted[y, x])


def gap_places(bare: Bools, spacing: int) -> Points:
    """Return one place (n, 2) in each square of `spacing` px that holds bare pixels, the most central of them."""
    y, x = np.nonzero(bare)
    square = (y // spacing) * (bare.shape[1] // spacing + 1) + x // spacing
    off = np.hypot(y % spacing - spacing / 2, x % spacing - spacing / 2)
    order = np.lexsort((off, square))
    chosen = order[np.diff(square[order], prepend=-1) > 0]
    return np.column_stack([x[chosen], y[chosen]]).astype(np.float64)
