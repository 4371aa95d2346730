"""The decomposition of a photo of patterned cloth into texel, mesh, shading and detail (NRT eq. 1).

I(x) = Wp(x) T(Wg(x)) + HF(x)
"""

import time
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from operator import attrgetter
from typing import TypeVar

import numpy as np

from core.arrays import Bools, Floats, InputError, Singles
from core.imaging.image import Image
from core.linalg.blas import on_one_thread, one_thread
from core.masks.object_masks import object_under
from core.overlay.composition import difference, finite
from core.overlay.detection.alignment import FlatPicture, PatchFrames
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError, flat_canvas
from core.overlay.filters.shrinking import shrunk, to_small, working_scale
from core.overlay.laying.compositing import encode, searchable
from core.overlay.likelihood import count_explained
from core.overlay.pixels.layers import painted, spread_mask
from core.overlay.pixels.model import PixelModel, begin
from core.overlay.pixels.stages import go_through, leave_out
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.vertices import whole_lattice
from core.overlay.search.finding import LEAST_UNTOLD, Find, find_cloth, find_print, follow_within, register_lattice
from core.overlay.texel import Texel
from core.overlay.whole_cloth import widen
from core.progress import Job, Progress, part
from core.selection.features import MARKED
from core.selection.importance import importance, propose

T = TypeVar("T")

SPLITTING = "splitting off the detail"
OBJECTS = 0.4
"""Share of a photo that is taken for what stands out, before the object is cut out: garments fill about so much."""


@dataclass(frozen=True)
class Decomposition:
    """The parts of a photo; pixels outside the cloth are NaN in `uv`, `shading` and `detail`."""

    photo: Floats | Singles
    """(H, W, 3), 0 to 1."""
    uv: Singles
    """(H, W, 2), texels."""
    texel: Texel
    shading: Singles
    """(H, W), the factor Wp, or (H, W, 3) where the light's colour changes."""
    detail: Singles
    """(H, W, 3), HF = I - Wp T(Wg); NRT eq. 10 prints the opposite sign."""
    reconstruction: Singles
    """(H, W, 3), Wp T(Wg), 0 outside."""
    coverage: Singles
    """(H, W), the share of cloth in each pixel: 1 on cloth that the model explains, soft at its border."""
    lattice: Lattice
    """Its scores are the confidence of the quad to the lower right of each vertex, 0 to 1."""
    basis: Floats
    """S (2, 2), pixels of the undeformed cloth a texel."""
    explained: float = 0.0
    """What speaks for it beside another one of the same photo (`count_explained`)."""
    seconds: dict[str, float] = field(default_factory=dict)
    """Time by stage."""
    found: "FoundCloth | None" = None
    """What was split, at its working size: a search for more of the cloth goes on from there."""

    @property
    def covered(self) -> Bools:
        """Pixels that have texture coordinates."""
        return finite(self.uv)


@dataclass(frozen=True)
class FoundCloth:
    """A cloth that was found and registered on a photo 1 / `scale` of the size."""

    cloth: FittedCloth
    fit: Fit
    photo: Floats | Singles
    """(H, W, 3), 0 to 1."""
    valid: Bools
    """(H, W), where cloth may be."""
    scale: int
    opacity: Singles | np.float32
    """(H, W), or one number: of what is laid there."""
    is_sure: bool
    """Whether no doubt is left about it (`Find`)."""
    stands_alone: bool
    """Whether it needs nobody's word that there is cloth (`Find`)."""
    is_told: bool
    """Whether somebody said where the cloth is."""

    @property
    def covered(self) -> Bools:
        """Pixels (H, W) of the photo in which it is registered."""
        return spread_mask(self.cloth.valid & self.cloth.mesh.pixels_of(self.fit.cells), self.valid.shape)

    @cached_property
    def explained(self) -> float:
        """What speaks for it as it is registered, before single pixels are looked at (`count_explained`)."""
        masks = [self.cloth.mesh.pixels_of(piece.cells) for piece in self.fit.pieces]
        uv, light = painted(self.cloth.mesh, list(self.fit.pieces), masks, self.cloth.valid)
        modelled = np.nan_to_num(light)[..., None] * self.fit.texel.singles(np.nan_to_num(uv))
        return count_explained(self.cloth.photo, modelled, finite(uv))


@dataclass(frozen=True)
class Known:
    """What is known of a cloth before it is looked for, as `decompose` takes it."""

    region: Bools | Singles | None = None
    texel_px: float | None = None
    start: Proposal | None = None
    lattice: list[Lattice] | None = None
    seed: int = 0

    def side_px(self, scale: int) -> float | None:
        """Return about the side of a texel, pixels of a photo 1 / `scale` of the size, if that is known."""
        return None if self.texel_px is None else self.texel_px / scale


def decompose(
    photo: Floats | Singles,
    *,
    region: Bools | Singles | None = None,
    texel_px: float | None = None,
    start: Proposal | None = None,
    lattice: list[Lattice] | None = None,
    seed: int = 0,
) -> Job[Decomposition]:
    """Split a photo (H, W, 3), 0 to 1, into texel, mesh, shading and detail.

    `region` (H, W) is the opacity, 0 to 1, of what is to be laid there: cloth is looked for, and covered, where it is
    not 0. `texel_px` says about how large the side of a texel is. The search begins at
    `start` alone if it is given, and is left out if the `lattice` is, in connected parts. Raises `NoPatternError`
    where no lattice is found, and where one explains no pixel of the photo.

    Where the find within a region leaves doubts alike patches of the region are asked too, and if they tell nothing all
    of the photo is searched; of both finds that is kept that explains the region better. Where a find without a region
    leaves doubts, it is looked for on the object that stands out.
    """
    seconds: dict[str, float] = {}
    job = find_all(photo, Known(region, texel_px, start, lattice, seed))
    finds = yield from part(time_stages(job, seconds), 0.0, 0.9)
    return (yield from part(split_best(finds, seconds), 0.9, 1.0))


def decompose_whole_cloth(
    image: Image,
    *,
    region: Bools | Singles | None = None,
    texel_px: float | None = None,
    lattice: list[Lattice] | None = None,
    seed: int = 0,
) -> Job[Decomposition]:
    """Return the decomposition of all of the cloth of which the pattern is found in `region` (H, W).

    What is found is followed on over the object that stands out there; where that is no better it stays as it was. What
    is given and raised is as for `decompose`.
    """
    seconds: dict[str, float] = {}
    job = find_all(encode(image), Known(region, texel_px, None, lattice, seed))
    finds = yield from part(time_stages(job, seconds), 0.0, 0.6)
    best = choose(finds)
    with suppress(InputError):
        return (yield from part(decompose_object(image, best, seed, seconds), 0.6, 1.0))
    return (yield from part(split_best([best], seconds), 0.9, 1.0))


def decompose_object(
    image: Image, found: FoundCloth, seed: int, seconds: dict[str, float] | None = None
) -> Job[Decomposition]:
    """Return the decomposition of what is found, followed on over the object that stands out there.

    `found` may be one that a decomposition of the image has kept, `seconds` the time that was taken so far. Raises
    `InputError` where that is no better.
    """
    seconds = {} if seconds is None else seconds

    def follow_on(cloth: Bools) -> Job[FoundCloth]:
        return follow(whole, searchable(image, cloth), seed, is_told=False)

    whole = at_photo_size(found, image)
    wider = yield from part(time_stages(widen(image, whole, follow_on), seconds), 0.0, 0.8)
    return (yield from part(split_best([wider], seconds), 0.8, 1.0))


def find_all(photo: Floats | Singles, known: Known) -> Job[list[FoundCloth]]:
    """Return the finds that are compared; raise `NoPatternError` if there is none.

    Where a find leaves doubts it is looked for otherwise too: within a region by alike patches, or else in all of the
    photo; without one on the object that stands out.
    """
    finds: list[FoundCloth] = []
    with suppress(NoPatternError):
        finds += yield from part(find(photo, known), 0.0, 0.5)
    is_given = known.start is not None or known.lattice is not None
    is_enough = any(found.stands_alone if known.region is None else found.is_sure for found in finds)
    if not is_given and not is_enough:
        more = find_on_object(photo, known) if known.region is None else find_again(photo, known)
        with suppress(NoPatternError):
            finds.append((yield from part(more, 0.5, 1.0)))
    if not finds:
        raise NoPatternError
    return finds


def find_again(photo: Floats | Singles, known: Known) -> Job[FoundCloth]:
    """Return the cloth of a region told by alike patches, else of all of the photo; raise `NoPatternError` if none."""
    small, canvas, scale = working_picture(photo, known.region)
    job = find_print(small, canvas, known.seed, alike="patches", texel_px=known.side_px(scale))
    with suppress(NoPatternError):
        return found_on(photo, known.region, scale, (yield from part(on_one_thread(job), 0.0, 0.5)))
    return (yield from part(find_in_all(photo, known), 0.5, 1.0))


def find_in_all(photo: Floats | Singles, known: Known) -> Job[FoundCloth]:
    """Return the cloth of all of a photo, restricted to the region; raise `NoPatternError` if there is none there."""
    bare = yield from part(find(photo, replace(known, region=None)), 0.0, 0.8)
    return (yield from part(follow(max(bare, key=attrgetter("explained")), known.region, known.seed), 0.8, 1.0))


def find_on_object(photo: Floats | Singles, known: Known) -> Job[FoundCloth]:
    """Return the print on the object that stands out in a photo; raise `NoPatternError` if there is none.

    Nobody said that there is cloth. Large texels alone are looked for: of them the object tells more than all of the
    photo does, in which fewer of the alike keypoints are theirs. A lattice begins wherever its texels are alike.
    """
    image = Image(photo.astype(np.float32))
    try:
        rough = propose((yield from part(importance(image), 0.0, 0.05)), OBJECTS, image.size_px)
        inside = (yield from part(object_under(image, rough), 0.05, 0.1)) > MARKED
    except InputError as error:
        raise NoPatternError from error
    small, canvas, scale = working_picture(photo, inside)
    job = find_print(small, canvas, known.seed, least=LEAST_UNTOLD, texel_px=known.side_px(scale))
    return replace(found_on(photo, inside, scale, (yield from part(on_one_thread(job), 0.1, 1.0))), is_told=False)


def find(photo: Floats | Singles, known: Known) -> Job[list[FoundCloth]]:
    """Return what may be the cloth of a photo, registered; raise `NoPatternError` if there is none."""
    small, canvas, scale = working_picture(photo, known.region)
    if known.lattice is None:
        start = known.start
        marked = None if start is None else Proposal(to_small(start.point, scale), start.basis / scale, 1.0)
        job = find_cloth(small, canvas, known.seed, texel_px=known.side_px(scale), start=marked)
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
    small, valid = shrunk(photo, scale), shrunk(may_be_cloth(photo, region)[..., None], scale)[..., 0] > 0.5
    return small, flat_canvas(small, np.asarray(valid, np.bool_)), scale


def may_be_cloth(photo: Floats | Singles, region: Bools | Singles | None) -> Bools:
    """Return where (H, W) cloth may be."""
    return np.ones(photo.shape[:2], bool) if region is None else np.asarray(region > 0, np.bool_)


def opacity_of(region: Bools | Singles | None) -> Singles | np.float32:
    """Return the opacity (H, W), or one number, of what is laid."""
    return np.float32(1) if region is None else region.astype(np.float32)


def found_on(photo: Floats | Singles, region: Bools | Singles | None, scale: int, found: Find) -> FoundCloth:
    """Return what was found on the working picture as that of the photo (H, W, 3)."""
    valid, opacity = may_be_cloth(photo, region), opacity_of(region)
    sure, is_told = (found.is_sure, found.stands_alone), region is not None
    return FoundCloth(found.cloth, found.followed, photo, valid, scale, opacity, *sure, is_told)


def time_stages(job: Job[T], seconds: dict[str, float]) -> Job[T]:
    """Run a job and add the time after each of its notes to `seconds`; what the watcher takes is not counted."""
    note = "starting"
    while True:
        started = time.perf_counter()
        try:
            step = next(job)
        except StopIteration as end:
            result: T = end.value
            return result
        finally:
            seconds[note] = seconds.get(note, 0.0) + time.perf_counter() - started
        note = step.note
        yield step


def split(found: FoundCloth) -> Decomposition:
    """Return the parts at every pixel of a photo whose cloth was found."""
    return finish(found, go_through(begun_model(found)))


def split_best(finds: list[FoundCloth], seconds: dict[str, float]) -> Job[Decomposition]:
    """Return the parts of that find that explains most, with the `seconds` that stages took.

    Several of a large photo are compared at its working size. Raises `NoPatternError` where no find explains a pixel.
    """
    yield Progress(0.0, SPLITTING)
    started = time.perf_counter()
    with one_thread():
        if len(finds) == 1:
            best, result = finds[0], split(finds[0])
        else:
            best, result = compare(finds)
            if result.photo is not best.photo:
                result = split(best)
    kept = replace(at_working_size(best), cloth=best.cloth.without_results)
    return replace(result, seconds=seconds | {SPLITTING: time.perf_counter() - started}, found=kept)


def choose(finds: list[FoundCloth]) -> FoundCloth:
    """Return that find which explains most; raise `NoPatternError` where none of several explains a pixel."""
    return finds[0] if len(finds) == 1 else compare(finds)[0]


def compare(finds: list[FoundCloth]) -> tuple[FoundCloth, Decomposition]:
    """Return that find which explains most of the photo as it was searched, and the parts it leads to there.

    Raises `NoPatternError` where none explains a pixel.
    """
    results: list[tuple[FoundCloth, Decomposition]] = []
    for found in finds:
        with suppress(NoPatternError), one_thread():
            results.append((found, split(at_working_size(found))))
    if not results:
        raise NoPatternError
    return max(results, key=lambda pair: pair[1].explained)


def at_working_size(found: FoundCloth) -> FoundCloth:
    """Return a find on the photo as it was searched."""
    if found.scale == 1:
        return found
    few = slice(None, None, found.scale)
    return replace(found, photo=found.cloth.photo, valid=found.valid[few, few], scale=1, opacity=np.float32(1))


def at_photo_size(found: FoundCloth, image: Image) -> FoundCloth:
    """Return a find, which may be kept as it was searched, on all of the image that is opaque."""
    photo = found.photo if found.photo.shape[:2] == image.pixels.shape[:2] else encode(image)
    opaque, scale = searchable(image, None), working_scale(photo.shape)
    return replace(found, photo=photo, valid=may_be_cloth(photo, opaque), scale=scale, opacity=opacity_of(opaque))


def split_without(found: FoundCloth, names: Collection[str]) -> Iterator[tuple[str, Decomposition | None]]:
    """Yield what comes of leaving out each stage of these names by turns, then of all stages; None for no cloth."""
    for name, model in leave_out(begun_model(found), names):
        yield name, finish(found, model) if np.isfinite(model.shading).any() else None


def begun_model(found: FoundCloth) -> PixelModel:
    """Return what is known before any stage."""
    return begin(found.cloth, found.fit, found.photo, found.valid, found.scale, is_told=found.is_told)


def finish(found: FoundCloth, model: PixelModel) -> Decomposition:
    """Return the parts that a model tells, at the photo's size; raise `NoPatternError` where it has no cloth."""
    cloth, scale = found.cloth, found.scale
    if not np.isfinite(model.shading).any():
        raise NoPatternError
    lattice = whole_lattice(cloth, list(model.pieces), found.fit)
    frames = PatchFrames(
        scale * lattice.frames.points + (scale - 1) / 2, scale * lattice.frames.bases, lattice.frames.scores
    )
    modelled, inside = model.modelled, np.asarray(np.isfinite(model.shading), np.bool_)
    uv, texel, light, coverage = model.uv, model.texel, model.light, model.coverage * found.opacity
    # What the rest of the model takes, its texture above all, would be the most memory of a large photo here.
    del model
    return Decomposition(
        photo=found.photo,
        uv=uv,
        texel=texel,
        shading=light[..., 0] if light.shape[-1] == 1 else light,
        detail=difference(found.photo, modelled, inside),
        reconstruction=modelled,
        coverage=coverage,
        lattice=replace(lattice, frames=frames),
        basis=cloth.basis * scale,
        explained=count_explained(found.photo, modelled, inside, scale),
    )
