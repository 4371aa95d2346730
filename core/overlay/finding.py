"""The cloth of a photo: several proposals are registered, and the one that explains most of the photo is kept.

Stripes of a tartan repeat more often than its sett, and a lattice of them may be found that is none of the cloth's.
Where there is reason to doubt a find, the pattern is looked for in the whole picture too, if a region bounded the
search, and then among large texels.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from core.arrays import Floats
from core.overlay.detection.alignment import Canvas
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.lattice import Lattice, connected
from core.overlay.detection.seeding import LEAST_VERTICES, NoPatternError, divides, find_lattices, flat_canvas
from core.overlay.detection.stages import Stage
from core.overlay.registration.cloth import Cloth, Fit
from core.overlay.registration.evidence import Evidence, weigh
from core.overlay.registration.fitting import begun, completed
from core.overlay.registration.following import followed, pruned
from core.overlay.wide import find_wide
from core.progress import Job, Progress, part

AS_MUCH = 0.9
"""Share of what a lattice explains that a finer one of the same pattern explains at least: the rest is noise."""


@dataclass(frozen=True)
class Find:
    """A cloth as far as it was followed from where it was found."""

    cloth: Cloth
    followed: Fit
    weight: Evidence


def find_cloth(
    photo: Floats, canvas: Canvas, seed: int, *, texel_px: float | None = None, start: Proposal | None = None
) -> Job[tuple[Cloth, Fit]]:
    """Return the registered cloth of a photo (H, W, 3).

    `texel_px` is the side of a texel where the user knows it; the search begins at `start` alone if it is given.
    Raises `NoPatternError` if there is no pattern.
    """
    if start is not None:
        marked = find_lattices(canvas, np.random.default_rng(seed), start=start)
        lattice = (yield from part(marked, 0.0, 0.4))[0]
        first = yield from part(begun(photo, canvas, lattice, seed), 0.4, 0.45)
        return (yield from part(completed(*first, [], seed), 0.45, 1.0))
    finds = yield from part(found_by_lattice(photo, canvas, canvas, seed, texel_px), 0.0, 0.3)
    if not any(find.weight.is_clear for find in finds) and not canvas.valid.all():
        whole = flat_canvas(photo, np.ones(canvas.shape, np.bool_))
        finds += yield from part(found_by_lattice(photo, canvas, whole, seed, texel_px), 0.3, 0.45)
    if not any(find.weight.is_clear for find in finds):
        try:
            wide = find_wide(photo, canvas, np.random.default_rng(seed), texel_px=texel_px, is_finer_known=bool(finds))
            cloth, grown = yield from part(wide, 0.45, 0.6)
            finds.append(Find(cloth, grown, weigh(cloth, grown)))
        except NoPatternError:
            pass
    return (yield from part(best_completed(finds, seed), 0.6, 1.0))


def found_by_lattice(
    photo: Floats, canvas: Canvas, place: Canvas, seed: int, texel_px: float | None
) -> Job[list[Find]]:
    """Return what is found of the cloth that `canvas` bounds from the lattices of `place`, until one is clear."""
    finds: list[Find] = []
    try:
        search = find_lattices(place, np.random.default_rng(seed), texel_px=texel_px)
        lattices = yield from part(search, 0.0, 0.8)
    except NoPatternError:
        return finds
    for lattice in lattices:
        try:
            finds.append((yield from part(registered(photo, canvas, inside(lattice, canvas), seed), 0.8, 1.0)))
        except NoPatternError:
            continue
        if finds[-1].weight.is_clear:
            finer = (other for other in lattices if divides(other, lattice))
            finds[-1] = yield from least_texel(photo, canvas, finds[-1], finer, seed)
            break
    return finds


def least_texel(photo: Floats, canvas: Canvas, found: Find, finer: Iterator[Lattice], seed: int) -> Job[Find]:
    """Return the find, or the one of a `finer` lattice that explains as much: several texels explain what one does."""
    for lattice in finer:
        try:
            other = yield from registered(photo, canvas, inside(lattice, canvas), seed)
        except NoPatternError:
            continue
        if other.weight.share > AS_MUCH * found.weight.share:
            return other
    return found


def inside(lattice: Lattice, canvas: Canvas) -> Lattice:
    """Return the largest connected part of a lattice whose vertices may be cloth; refuse it if that has too few."""
    x, y = np.clip(np.rint(lattice.frames.points).astype(int), 0, np.array(canvas.shape[::-1]) - 1).T
    kept = connected(lattice[canvas.valid[y, x, 0] > 0])
    if len(kept) < LEAST_VERTICES:
        raise NoPatternError
    return kept


def registered(photo: Floats, canvas: Canvas, lattice: Lattice, seed: int) -> Job[Find]:
    """Return the cloth registered and followed from a lattice; raise `NoPatternError` where it cannot be followed."""
    yield Progress(0.0, "registering", Stage("lattice", lattice, shape=canvas.shape))
    cloth, found = yield from begun(photo, canvas, lattice, seed)
    found = yield from followed(cloth, pruned(cloth, found), Progress(0.5, "following the cloth"))
    if not found.cells.any():
        raise NoPatternError
    return Find(cloth, found, weigh(cloth, found))


def best_completed(finds: list[Find], seed: int) -> Job[tuple[Cloth, Fit]]:
    """Return the find that explains most, completed; the next one where it then proves to be none."""
    for find in sorted(finds, key=lambda find: -find.weight.explained):
        if not find.weight.is_credible:
            continue
        try:
            return (yield from completed(find.cloth, find.followed, [], seed))
        except NoPatternError:
            continue
    raise NoPatternError
