"""Features one by one: which pixels of a mask are whose.

A document has a mask (H, W), over 127 for features, and numbers (H, W): pixels with the same number, wherever they lie,
are one feature; each 8-connected part of the mask that has no number, 0, is one, too. So strokes that touch are two
features where they have two numbers, and parts far from one another are one where they have the same.
"""

from collections.abc import Collection, Mapping

import cv2
import numpy as np

from core.arrays import Bools, Bytes, InputError, Ints, Points
from core.rasters.raster import Box, Raster

MARKED = 127
MOST = 255
"""Numbers go so far."""


def free_number(numbers: Raster | None, *, taken: Collection[int] = (), first: int = 1) -> int:
    """Return the least number from `first` on, or else of all, that no pixel has and that is not `taken`.

    Raises `InputError` where there is none.
    """
    used = set() if numbers is None else {int(n) for n in np.unique(numbers.array)}
    candidates: tuple[int, ...] = (*range(first, MOST + 1), *range(1, min(first, MOST + 1)))
    free = next((number for number in candidates if number not in used and number not in taken), None)
    if free is None:
        raise InputError(f"a picture holds {MOST} numbered features at most")
    return free


def without_numbered(mask: Raster, numbers: Raster) -> Raster:
    """Return the mask without the pixels that have a number; tiles without any are the mask's own."""

    def cut(tile: Bytes, box: Box) -> Bytes:
        number = numbers.tile_at(box)
        return np.where(number == 0, tile, 0).astype(np.uint8) if number.any() else tile

    return mask.edited((0, 0, mask.width_px, mask.height_px), cut)


def only_marked(numbers: Raster, mask: Raster) -> Raster | None:
    """Return the numbers of pixels that are marked, None where no pixel has one."""

    def cut(tile: Bytes, box: Box) -> Bytes:
        if not tile.any():
            return tile
        marked = mask.tile_at(box) > MARKED
        return tile if marked[tile > 0].all() else np.where(marked, tile, 0).astype(np.uint8)

    kept = numbers.edited((0, 0, numbers.width_px, numbers.height_px), cut)
    return None if kept.is_empty else kept


def number_area(numbers: Raster | None, area: Bools, number: int) -> Raster:
    """Return the numbers with all pixels of an area (H, W) given one, in their tiles wherever nothing changes."""
    before = np.zeros(area.shape, np.uint8) if numbers is None else numbers.array
    now = Raster.from_array(np.where(area, number, before).astype(np.uint8))
    return now if numbers is None else now.sharing(numbers)


def extend_numbers(numbers: Raster, before: Raster, after: Raster, *, touching: bool = False) -> Raster:
    """Return the numbers with what only `after` marks given that of the nearest pixel that `before` marks.

    With `touching` only pixels that it touches count, and its parts that touch none keep their numbers.
    """
    was = before.array > MARKED
    new = (after.array > MARKED) & ~was
    seeds = was & _widened(new) if touching else was
    if not (new.any() and seeds.any()):
        return numbers
    if touching:
        _, parts = cv2.connectedComponents(new.astype(np.uint8), connectivity=8)
        new &= np.isin(parts, np.unique(parts[new & _widened(seeds)]))
    found = np.where(new, numbers.array.ravel()[_nearest(seeds)], numbers.array)
    return Raster.from_array(found.astype(np.uint8)).sharing(numbers)


def _widened(area: Bools) -> Bools:
    """Return an area (H, W) and the pixels that touch it."""
    return np.asarray(cv2.dilate(area.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0)


def _nearest(known: Bools) -> Ints:
    """Return which of the pixels that are `known` is the nearest to each (H, W), counted along the rows."""
    away = (~known).astype(np.uint8)
    _, nearest = cv2.distanceTransformWithLabels(away, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL)
    of_label = np.zeros(int(nearest.max()) + 1, np.intp)
    of_label[nearest[known]] = np.flatnonzero(known)
    return np.asarray(of_label[nearest])


def split_along(area: Bools, line: Points) -> list[Bools]:
    """Return the parts (H, W) that a line (n, 2) of pixels cuts an area (H, W) into, the largest first.

    The line itself goes to the part that is nearest. An area that it does not cut through is one part.
    """
    cut = np.zeros(area.shape, np.uint8)
    cv2.polylines(cut, [np.rint(line).astype(np.int32)], isClosed=False, color=(1,), thickness=1)
    # A line of pixels that touch by their corners parts what hangs together by its sides.
    rest = (area & (cut == 0)).astype(np.uint8)
    count, parts = cv2.connectedComponents(rest, connectivity=4)
    if count <= 2:
        return [area]
    owner = np.where(area, parts.ravel()[_nearest(rest > 0)], 0)
    found = [owner == number for number in range(1, count)]
    return sorted(found, key=lambda part: -int(part.sum()))


def parts_of(mask: Bytes, numbers: Bytes | None) -> np.ndarray[tuple[int, ...], np.dtype[np.int32]]:
    """Return which feature each pixel (H, W) is of: its number, or 256 and more for those without; 0 for none."""
    marked = mask > MARKED
    loose = marked if numbers is None else marked & (numbers == 0)
    _, parts = cv2.connectedComponents(loose.astype(np.uint8), connectivity=8)
    found = np.where(parts > 0, parts + MOST, 0).astype(np.int32)
    return found if numbers is None else np.where(marked & (numbers > 0), numbers, found).astype(np.int32)


def number_joined(numbers: Raster | None, before: Raster, after: Raster, wanted: Mapping[int, int]) -> Raster | None:
    """Return the numbers with one for every feature that had none, where another mask would make one of several.

    Of what is `wanted`, see `number_loose`.
    """
    parts = parts_of(before.array, None if numbers is None else numbers.array)
    _, wholes = cv2.connectedComponents((after.array > MARKED).astype(np.uint8), connectivity=8)
    pairs = np.unique(np.stack([wholes, parts])[:, (wholes > 0) & (parts > 0)], axis=1)
    is_joined = len(np.unique(pairs[0])) < pairs.shape[1]
    return number_loose(numbers, before, wanted) if is_joined else numbers


def number_loose(numbers: Raster | None, mask: Raster, wanted: Mapping[int, int]) -> Raster | None:
    """Return the numbers with one for every feature of a mask that had none.

    A feature gets the number that is `wanted` for it, by what `parts_of` calls it, or another one that is free. Where
    there are too few of them nothing is changed.
    """
    parts = parts_of(mask.array, None if numbers is None else numbers.array)
    known = np.unique(parts).tolist()
    loose = [part for part in known if part > MOST]
    free = [number for number in range(1, MOST + 1) if number not in known]
    if len(free) < len(loose):
        return numbers
    table = np.arange(int(parts.max()) + 1)
    for part in sorted(loose, key=lambda part: part not in wanted):
        table[part] = wanted[part] if wanted.get(part) in free else free[0]
        free.remove(table[part])
    return Raster.from_array(table[parts].astype(np.uint8))
