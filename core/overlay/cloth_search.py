"""The search for a patterned cloth on a photo: within a region, in all of the photo, on the object that stands out."""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from core.arrays import Bools, Floats, InputError, Singles
from core.imaging.image import Image
from core.linalg.blas import on_one_thread
from core.overlay.detection.alignment import FlatPicture
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError, flat_canvas
from core.overlay.filters.shrinking import shrunk, shrunk_mask, to_small, working_scale
from core.overlay.found_cloth import FoundCloth, choose, may_be_cloth, opacity_of
from core.overlay.search.finding import Find, find_cloth, find_print, follow_within, register_lattice
from core.overlay.search.large_periods import Correspondences
from core.progress import Job, part
from core.selection.salient_object import find_salient_object

LEAST_UNTOLD = 5.0
"""Texels, large ones, that are seen at least where nobody said that there is cloth: a leopard's spots show four."""


@dataclass(frozen=True)
class Known:
    """What is known of a cloth before it is looked for, as `decompose` takes it."""

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

    def side_px(self, scale: int) -> float | None:
        """Return about the side of a texel, pixels of a photo 1 / `scale` of the size, if that is known."""
        return None if self.texel_px is None else self.texel_px / scale


def find_all(photo: Floats | Singles, known: Known) -> Job[list[FoundCloth]]:
    """Return the finds that are compared; raise `NoPatternError` if there is none.

    Where a find leaves doubts it is looked for otherwise too: within a region by alike patches, or else in all of the
    photo; without one on the object that stands out. Where doubts are left in a region still, the best find is followed
    there once more, with the texel as it is known by then.
    """
    finds = yield from part(find_if_any(photo, known), 0.0, 0.5)
    is_given = known.start is not None or known.lattice is not None
    is_enough = any(found.is_clear if known.region is None else found.is_sure for found in finds)
    if not is_given and not is_enough:
        more = find_on_object(photo, known) if known.region is None else find_again(photo, known)
        with suppress(NoPatternError):
            finds.append((yield from part(more, 0.5, 0.9)))
    if not finds:
        raise NoPatternError
    if not is_given and known.region is not None and not any(found.is_clear for found in finds):
        with suppress(NoPatternError):
            finds.append((yield from part(follow(choose(finds), known.region, known.seed), 0.9, 1.0)))
    return finds


def find_whole(photo: Floats | Singles, known: Known, finds: list[FoundCloth] | None = None) -> Job[list[FoundCloth]]:
    """Return what `find_all` does where the whole cloth is asked for: then what stands out is said to be cloth.

    So where nothing is painted, and no find lies on that without doubt, it is searched as a region is. `finds` may be
    what was found already, none if there is none.
    """
    if not known.is_told:
        finds = yield from find_on_whole_object(photo, known, finds)
    elif finds is None:
        finds = yield from find_all(photo, known)
    if not finds:
        raise NoPatternError
    return finds


def find_on_whole_object(
    photo: Floats | Singles, known: Known, finds: list[FoundCloth] | None
) -> Job[list[FoundCloth]]:
    """Return what is found in all of the photo, or given, and, if none of it is clear there, on what stands out.

    What stands out is searched as a region is, and what was found beside it does not count if anything is found there.
    Large texels are looked for in all of the photo only where nothing stands out.
    """
    try:
        inside = yield from part(find_object(photo), 0.0, 0.1)
    except NoPatternError:
        return (yield from find_if_any(photo, known)) if finds is None else finds
    if finds is None:
        finds = yield from part(find_if_any(photo, replace(known, may_be_large=False)), 0.1, 0.3)
    if any(found.is_clear and lies_on(found.covered, inside) for found in finds):
        return finds
    within = replace(known, region=inside)
    more = yield from part(find_if_any(photo, within), 0.3, 0.7)
    if not any(found.is_sure for found in more):
        with suppress(NoPatternError):
            more.append((yield from part(find_alike(photo, within), 0.7, 1.0)))
    # Ground with a pattern of its own may explain more than the garment on it.
    return [*(found for found in finds if not more or lies_on(found.covered, inside)), *more]


def lies_on(covered: Bools, inside: Bools) -> bool:
    """Return whether two places (H, W) have most of the smaller one in common."""
    return int((covered & inside).sum()) > 0.5 * min(int(covered.sum()), int(inside.sum()))


def find_if_any(photo: Floats | Singles, known: Known) -> Job[list[FoundCloth]]:
    """Return what `find` does; nothing where there is none."""
    try:
        return (yield from find(photo, known))
    except NoPatternError:
        return []


def find_again(photo: Floats | Singles, known: Known) -> Job[FoundCloth]:
    """Return the cloth of a region told by alike patches, else of all of the photo; raise `NoPatternError` if none."""
    with suppress(NoPatternError):
        return (yield from part(find_alike(photo, known), 0.0, 0.5))
    return (yield from part(find_in_all(photo, known), 0.5, 1.0))


def find_alike(photo: Floats | Singles, known: Known) -> Job[FoundCloth]:
    """Return the cloth of a region told by alike patches; raise `NoPatternError` if there is none."""
    small, canvas, scale = working_picture(photo, known.region)
    job = find_print(small, canvas, known.seed, alike="patches", texel_px=known.side_px(scale))
    return found_on(photo, known.region, scale, (yield from on_one_thread(job)))


def find_in_all(photo: Floats | Singles, known: Known) -> Job[FoundCloth]:
    """Return the cloth of all of a photo, restricted to the region; raise `NoPatternError` if there is none there."""
    bare = yield from part(find(photo, replace(known, region=None)), 0.0, 0.8)
    return (yield from part(follow(choose(bare), known.region, known.seed), 0.8, 1.0))


def find_on_object(photo: Floats | Singles, known: Known) -> Job[FoundCloth]:
    """Return the print on the object that stands out in a photo; raise `NoPatternError` if there is none.

    Nobody said that there is cloth. Large texels alone are looked for, by alike keypoints or, where these tell nothing,
    by patches: of them the object tells more than all of the photo does, in which less of what is alike is theirs. A
    lattice begins wherever its texels are alike.
    """
    inside = yield from part(find_object(photo), 0.0, 0.1)
    small, canvas, scale = working_picture(photo, inside)
    ways: tuple[tuple[Correspondences, float], ...] = ("keypoints", 0.1), ("patches", 0.55)
    for alike, done in ways:
        job = find_print(small, canvas, known.seed, alike=alike, least=LEAST_UNTOLD, texel_px=known.side_px(scale))
        with suppress(NoPatternError):
            found = yield from part(on_one_thread(job), done, done + 0.45)
            return replace(found_on(photo, inside, scale, found), is_told=False)
    raise NoPatternError


def find_object(photo: Floats | Singles) -> Job[Bools]:
    """Return where (H, W) the object is that stands out in a photo; raise `NoPatternError` where none does."""
    try:
        return (yield from find_salient_object(Image(photo.astype(np.float32))))
    except InputError as error:
        raise NoPatternError from error


def find(photo: Floats | Singles, known: Known) -> Job[list[FoundCloth]]:
    """Return what may be the cloth of a photo, registered; raise `NoPatternError` if there is none."""
    small, canvas, scale = working_picture(photo, known.region)
    if known.lattice is None:
        start = known.start
        marked = None if start is None else Proposal(to_small(start.point, scale), start.basis / scale, 1.0)
        job = find_cloth(
            small, canvas, known.seed, texel_px=known.side_px(scale), start=marked, with_large=known.may_be_large
        )
    else:
        job = register_lattice(small, canvas, [piece.shrunk(scale) for piece in known.lattice], known.seed)
    return [found_on(photo, known.region, scale, found) for found in (yield from on_one_thread(job))]


def follow(found: FoundCloth, region: Bools | Singles | None, seed: int, *, is_told: bool = True) -> Job[FoundCloth]:
    """Return a cloth restricted to a `region` (H, W) and followed there; raise `NoPatternError` where nothing is left.

    `region` and `seed` are as for `decompose`; `is_told` says whether the user gave the region. Else where it ends is a
    guess, beyond which the outline is looked for too.
    """
    small, canvas, scale = working_picture(found.photo, region)
    job = follow_within(found.cloth, found.fit, small, canvas, seed)
    followed = found_on(found.photo, region, scale, (yield from on_one_thread(job)))
    if is_told:
        return followed
    return replace(followed, is_told=False, valid=found.valid, opacity=found.opacity)


def working_picture(photo: Floats | Singles, region: Bools | Singles | None) -> tuple[Floats, FlatPicture, int]:
    """Return the photo (h, w, 3) as it is searched, its canvas with what may be cloth, and how much smaller it is."""
    scale = working_scale(photo.shape)
    small = shrunk(photo, scale)
    return small, flat_canvas(small, shrunk_mask(may_be_cloth(photo, region), scale)), scale


def found_on(photo: Floats | Singles, region: Bools | Singles | None, scale: int, found: Find) -> FoundCloth:
    """Return what was found on the working picture as that of the photo (H, W, 3)."""
    valid, opacity = may_be_cloth(photo, region), opacity_of(region)
    doubts = found.is_sure, found.is_clear
    # What the registration keeps for its next step takes memory.
    return FoundCloth(
        found.cloth.without_results, found.followed, photo, valid, scale, opacity, *doubts, is_told=region is not None
    )
