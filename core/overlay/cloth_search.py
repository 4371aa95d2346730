"""The search for a patterned cloth on a photo: within a region, in all of the photo, on the object that stands out."""

from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from core.arrays import Bools, Floats, InputError, Singles
from core.imaging.image import Image
from core.linalg.blas import on_one_thread
from core.linalg.jobs_beside import HERE, PlannedJob, ProcessPool, run_meanwhile
from core.overlay.detection.alignment import FlatPicture
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError, flat_canvas
from core.overlay.filters.shrinking import shrunk, shrunk_mask, to_small, working_scale
from core.overlay.found_cloth import FoundCloth, at_photo_size, choose, explain_each, may_be_cloth, opacity_of, within
from core.overlay.search.finding import ENLARGING, Find, find_cloth, find_print, follow_within, register_lattice
from core.overlay.search.large_periods import NOTE, Correspondences
from core.progress import Job, Progress, Steps, forwards, part
from core.selection.salient_object import find_salient_object

S = TypeVar("S")
T = TypeVar("T")

LEAST_UNTOLD = 5.0
"""Texels, large ones, that are seen at least where nobody said that there is cloth: a leopard's spots show four."""


@dataclass(frozen=True)
class Known:
    """What is known of a cloth before it is looked for, as `decompose` takes it; lengths are pixels of its photo."""

    region: Bools | Singles | None = None
    texel_px: float | None = None
    start: Proposal | None = None
    lattice: list[Lattice] | None = None
    seed: int = 0
    may_be_large: bool = True
    """Whether texels so large that no lattice grows are looked for too."""

    @property
    def is_told(self) -> bool:
        """Whether somebody said where the cloth is."""
        return self.region is not None or self.start is not None or self.lattice is not None

    def shrunk(self, scale: int) -> "Known":
        """Return what is known on a photo 1 / `scale` of the size."""
        if scale == 1:
            return self
        return replace(
            self,
            region=None if self.region is None else shrunk_mask(np.asarray(self.region > 0, np.bool_), scale),
            texel_px=None if self.texel_px is None else self.texel_px / scale,
            start=self.start and Proposal(to_small(self.start.point, scale), self.start.basis / scale, 1.0),
            lattice=self.lattice and [piece.shrunk(scale) for piece in self.lattice],
        )


def find_all(photo: Floats | Singles, known: Known, pool: ProcessPool = HERE) -> Job[list[FoundCloth]]:
    """Return the finds that are compared; raise `NoPatternError` if there is none.

    Where a find leaves doubts it is looked for otherwise too: within a region by alike patches, or else in all of the
    photo; without one on the object that stands out. That is begun at once where the `pool` has other processes. Where
    doubts are left in a region still, the best find is followed there once more, with the texel as it is known by then.
    """
    scale = working_scale(photo.shape)
    finds = yield from find_all_searched(searched(photo), known.shrunk(scale), pool)
    return [at_photo_size(found, photo, known.region) for found in finds]


def find_all_searched(photo: Floats | Singles, known: Known, pool: ProcessPool) -> Job[list[FoundCloth]]:
    """Return what `find_all` does, of the photo as it is searched."""
    is_given = known.start is not None or known.lattice is not None
    other = pool.plan(find_on_object if known.region is None else find_again, photo, known)
    finds = yield from part(begin_in_doubt(pool.run(find_if_any, photo, known), other), 0.0, 0.5)
    is_enough = any(found.is_clear if known.region is None else found.is_sure for found in finds)
    if is_given or is_enough:
        other.stop()
    else:
        if not other.is_over:
            yield from part(explain_each(finds, pool), 0.5, 0.5)
        with suppress(NoPatternError):
            finds += yield from part(other.result(), 0.5, 0.9)
    if not finds:
        raise NoPatternError
    if not is_given and known.region is not None and not any(found.is_clear for found in finds):
        yield from part(explain_each(finds, pool), 0.9, 0.9)
        with suppress(NoPatternError):
            job = pool.run(follow, choose(finds), known.region, known.seed)
            finds.append((yield from part(job, 0.9, 1.0)))
    return finds


def find_whole(
    photo: Floats | Singles, known: Known, finds: list[FoundCloth] | None = None, pool: ProcessPool = HERE
) -> Job[list[FoundCloth]]:
    """Return what `find_all` does where the whole cloth is asked for: then what stands out is said to be cloth.

    So where nothing is painted, and no find lies on that without doubt, it is searched as a region is. `finds` may be
    what was found already, as it was searched, none if there is none.
    """
    if not known.is_told:
        finds = yield from find_on_whole_object(searched(photo), known.shrunk(working_scale(photo.shape)), finds, pool)
        finds = [at_photo_size(found, photo, None) for found in finds]
    elif finds is None:
        finds = yield from find_all(photo, known, pool)
    else:
        finds = [at_photo_size(found, photo, known.region) for found in finds]
    if not finds:
        raise NoPatternError
    return finds


def find_on_whole_object(
    photo: Floats | Singles, known: Known, finds: list[FoundCloth] | None, pool: ProcessPool
) -> Job[list[FoundCloth]]:
    """Return what is found in all of the photo, or given, and, if none of it is clear there, on what stands out.

    What stands out is searched as a region is, and what was found beside it does not count if anything is found there.
    Large texels are looked for in all of the photo only where nothing stands out.
    """
    if finds is None:
        bare = pool.begin(find_if_any, photo, replace(known, may_be_large=False))
    else:
        bare = HERE.plan(give, finds)
    try:
        inside = yield from part(find_object(photo), 0.0, 0.1)
    except NoPatternError:
        bare.stop()
        return finds if finds is not None else (yield from pool.run(find_if_any, photo, known))
    on_object = replace(known, region=inside)
    search, alike = pool.plan(find_if_any, photo, on_object), pool.plan(find_alike, photo, on_object)

    def go_on_in_doubt(found: list[FoundCloth]) -> bool:
        if any(one.is_clear and lies_on(one.covered, inside) for one in found):
            return False
        alike.begin()
        return True

    def those_that_count() -> list[FoundCloth]:
        # Ground with a pattern of its own may explain more than the garment on it.
        return [*(found for found in beside if not on_it or lies_on(found.covered, inside)), *on_it]

    beside, end = yield from part(forwards(run_meanwhile(bare, search, go_on_in_doubt)), 0.1, 0.7)
    if end is None:
        return beside
    on_it = end.result
    if any(found.is_sure for found in on_it):
        alike.stop()
    else:
        if not alike.is_over:
            yield from part(explain_each(those_that_count(), pool), 0.7, 0.7)
        with suppress(NoPatternError):
            on_it += yield from part(alike.result(), 0.7, 1.0)
    return those_that_count()


def give(finds: list[FoundCloth]) -> Job[list[FoundCloth]]:
    """Return finds that are known, as a job."""
    yield Progress(0.0)
    return finds


def begin_in_doubt(first: Job[T], other: PlannedJob[S]) -> Job[T]:
    """Return what the `first` job does; begin the other when that has doubts, and so looks at what is larger."""
    for step in (steps := Steps(first)):
        if step.note in (ENLARGING, NOTE):
            other.begin()
        yield step
    return steps.result


def lies_on(covered: Bools, inside: Bools) -> bool:
    """Return whether two places (H, W) have most of the smaller one in common."""
    return int((covered & inside).sum()) > 0.5 * min(int(covered.sum()), int(inside.sum()))


def find_if_any(photo: Floats | Singles, known: Known) -> Job[list[FoundCloth]]:
    """Return what `find` does; nothing where there is none."""
    try:
        return (yield from find(photo, known))
    except NoPatternError:
        return []


def find_again(photo: Floats | Singles, known: Known) -> Job[list[FoundCloth]]:
    """Return what may be the cloth of a region told by alike patches, else of all of the photo.

    Raises `NoPatternError` if there is none.
    """
    with suppress(NoPatternError):
        return (yield from part(find_alike(photo, known), 0.0, 0.5))
    return [(yield from part(find_in_all(photo, known), 0.5, 1.0))]


def find_alike(photo: Floats | Singles, known: Known) -> Job[list[FoundCloth]]:
    """Return what may be the cloth of a region told by alike patches; raise `NoPatternError` if there is none."""
    picture = working_picture(photo, known.region)
    job = find_print(*picture, known.seed, alike="patches", texel_px=known.texel_px)
    return [found_on(photo, known.region, found) for found in (yield from on_one_thread(job))]


def find_in_all(photo: Floats | Singles, known: Known) -> Job[FoundCloth]:
    """Return the cloth of all of a photo, restricted to the region; raise `NoPatternError` if there is none there."""
    bare = yield from part(find(photo, replace(known, region=None)), 0.0, 0.8)
    return (yield from part(follow(choose(bare), known.region, known.seed), 0.8, 1.0))


def find_on_object(photo: Floats | Singles, known: Known) -> Job[list[FoundCloth]]:
    """Return what may be the print on the object that stands out in a photo; raise `NoPatternError` if there is none.

    Nobody said that there is cloth. Large texels alone are looked for, by alike keypoints or, where these tell nothing,
    by patches: of them the object tells more than all of the photo does, in which less of what is alike is theirs. A
    lattice begins wherever its texels are alike.
    """
    inside = yield from part(find_object(photo), 0.0, 0.1)
    picture = working_picture(photo, inside)
    ways: tuple[tuple[Correspondences, float], ...] = ("keypoints", 0.1), ("patches", 0.55)
    for alike, done in ways:
        job = find_print(*picture, known.seed, alike=alike, least=LEAST_UNTOLD, texel_px=known.texel_px)
        with suppress(NoPatternError):
            finds = yield from part(on_one_thread(job), done, done + 0.45)
            return [replace(found_on(photo, inside, found), is_told=False) for found in finds]
    raise NoPatternError


def as_guess(found: FoundCloth) -> FoundCloth:
    """Return what was found on an object as cloth of which nobody said where it ends: it may go on, or end before."""
    return replace(within(found, None), is_told=False) if found.is_told else found


def find_object(photo: Floats | Singles) -> Job[Bools]:
    """Return where (H, W) the object is that stands out in a photo; raise `NoPatternError` where none does."""
    try:
        return (yield from find_salient_object(Image(photo.astype(np.float32))))
    except InputError as error:
        raise NoPatternError from error


def find(photo: Floats | Singles, known: Known) -> Job[list[FoundCloth]]:
    """Return what may be the cloth of a photo, registered; raise `NoPatternError` if there is none."""
    picture = working_picture(photo, known.region)
    if known.lattice is None:
        job = find_cloth(
            *picture, known.seed, texel_px=known.texel_px, start=known.start, with_large=known.may_be_large
        )
    else:
        job = register_lattice(*picture, known.lattice, known.seed)
    return [found_on(photo, known.region, found) for found in (yield from on_one_thread(job))]


def follow(found: FoundCloth, region: Bools | Singles | None, seed: int, *, is_told: bool = True) -> Job[FoundCloth]:
    """Return a cloth restricted to a `region` (h, w) and followed there; raise `NoPatternError` where nothing is left.

    Photo and region are as they are searched; `seed` is as for `decompose`; `is_told` says whether the user gave the
    region. Else where it ends is a guess, beyond which the outline is looked for too.
    """
    job = follow_within(found.cloth, found.fit, *working_picture(found.photo, region), seed)
    followed = found_on(found.photo, region, (yield from on_one_thread(job)))
    if is_told:
        return followed
    return replace(followed, is_told=False, valid=found.valid, opacity=found.opacity)


def searched(photo: Floats | Singles) -> Floats | Singles:
    """Return a photo (H, W, 3) as it is searched: (h, w, 3)."""
    scale = working_scale(photo.shape)
    return photo if scale == 1 else shrunk(photo, scale)


def working_picture(photo: Floats | Singles, region: Bools | Singles | None) -> tuple[Floats, FlatPicture]:
    """Return the photo (h, w, 3) as it is worked on, and its canvas with what may be cloth."""
    small = shrunk(photo, 1)
    return small, flat_canvas(small, may_be_cloth(photo, region))


def found_on(photo: Floats | Singles, region: Bools | Singles | None, found: Find) -> FoundCloth:
    """Return what was found on the photo (h, w, 3) as it is searched."""
    valid, opacity = may_be_cloth(photo, region), opacity_of(region)
    doubts = found.is_sure, found.is_clear
    # What the registration keeps for its next step takes memory.
    return FoundCloth(
        found.cloth.without_results, found.followed, photo, valid, 1, opacity, *doubts, is_told=region is not None
    )
