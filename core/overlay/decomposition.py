"""The decomposition of a photo of patterned cloth into texel, mesh, shading and detail (NRT eq. 1).

I(x) = Wp(x) T(Wg(x)) + HF(x)
"""

import time
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TypeVar

from core.arrays import Bools, Floats, InputError, Singles
from core.imaging.image import Image
from core.linalg.jobs_beside import ProcessPool
from core.masks.object_masks import whole_object
from core.overlay.cloth_search import Known, as_guess, find_all, find_whole, follow
from core.overlay.composition import difference, finite
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError
from core.overlay.filters.shrinking import shrunk_mask
from core.overlay.found_cloth import (
    FoundCloth,
    at_photo_size,
    begin_to_explain,
    begun_model,
    choose,
    explain_each,
    finished_model,
    may_be_cloth,
    take_explained,
    within,
)
from core.overlay.laying.compositing import encode, searchable
from core.overlay.likelihood import count_explained
from core.overlay.pixels.laid_lattice import measure_basis, read_lattice
from core.overlay.pixels.model import PixelModel
from core.overlay.pixels.stages import leave_out
from core.overlay.texel import Texel
from core.progress import Job, Progress, part

T = TypeVar("T")

SPLITTING = "splitting off the detail"
NO_BETTER = "no more of the pattern is found on the whole cloth"


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
    """S (2, 2), pixels of the undeformed cloth a texel, by the median slopes of `uv`."""
    explained: float = 0.0
    """What speaks for it beside another one of the same photo (`count_explained`)."""
    seconds: dict[str, float] = field(default_factory=dict)
    """Time by stage."""
    found: FoundCloth | None = None
    """What was split, at its working size: a search for more of the cloth goes on from there."""

    @property
    def covered(self) -> Bools:
        """Pixels that have texture coordinates."""
        return finite(self.uv)


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

    Under `use_all_processors` other processes work too, at once on what may be needed, and it comes to the same.
    """
    seconds: dict[str, float] = {}
    with ProcessPool() as pool:
        job = find_all(photo, Known(region, texel_px, start, lattice, seed), pool)
        finds = yield from part(time_stages(job, seconds), 0.0, 0.9)
        return (yield from part(split_best(finds, seconds, pool), 0.9, 1.0))


def decompose_whole_cloth(
    image: Image,
    *,
    region: Bools | Singles | None = None,
    texel_px: float | None = None,
    start: Proposal | None = None,
    lattice: list[Lattice] | None = None,
    seed: int = 0,
    finds: list[FoundCloth] | None = None,
) -> Job[Decomposition]:
    """Return the decomposition of all of the cloth of which the pattern is found in `region` (H, W).

    Without one, what stands out in the photo is said to be cloth. What is found is followed on over the object that
    stands out there; where that is no better it stays as it was. What is given and raised is as for `decompose`.
    `finds` may be what decompositions of the image have kept, none if they found none: then it is not looked for again,
    and `InputError` is raised where nothing better is found than one of them.
    """
    seconds: dict[str, float] = {}
    photo = encode(image)
    with ProcessPool() as pool:
        known = Known(region, texel_px, start, lattice, seed)
        best = yield from part(find_best_of_whole(photo, known, finds, seconds, pool), 0.0, 0.6)
        begun = begin_to_explain([best], pool)
        compared, fault = [best], InputError(NO_BETTER)
        try:
            compared.append((yield from part(time_stages(follow_on(image, best, seed, pool), seconds), 0.6, 0.9)))
        except InputError as reason:
            fault = reason
        yield from part(explain_each(compared[1:], pool), 0.9, 0.9)
        yield from part(take_explained(begun), 0.9, 0.9)
        best = choose(compared)
        if finds is not None and any(best.cloth is given.cloth for given in finds):
            raise fault
        return (yield from part(split_best([best], seconds, pool), 0.9, 1.0))


def find_best_of_whole(
    photo: Floats | Singles, known: Known, finds: list[FoundCloth] | None, seconds: dict[str, float], pool: ProcessPool
) -> Job[FoundCloth]:
    """Return the best of what `find_whole` finds; the others, each with masks of the photo's size, are let go of."""
    found = yield from time_stages(find_whole(photo, known, finds, pool), seconds)
    if len(found) > 1:
        yield from part(explain_each(found, pool), 1.0, 1.0)
    # Finds are compared on what stands out: of the ground beyond it a wrong one may explain more.
    return choose(found) if known.is_told else as_guess(choose(found))


def follow_on(image: Image, found: FoundCloth, seed: int, pool: ProcessPool) -> Job[FoundCloth]:
    """Return a find followed on over the object that is cut out of the `image` around it.

    Raises `InputError` where it is all of the object.
    """
    cloth = yield from part(whole_object(image, found.covered), 0.0, 0.1)
    whole = within(found, searchable(image, None))
    inside = shrunk_mask(may_be_cloth(found.photo, searchable(image, cloth)), found.scale)
    wider = yield from part(pool.run(partial(follow, is_told=False), whole.searched, inside, seed), 0.1, 1.0)
    return at_photo_size(wider, whole.photo, searchable(image, None))


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
    return finish(found, found.model if found.scale == 1 else finished_model(found.laid))


def split_best(finds: list[FoundCloth], seconds: dict[str, float], pool: ProcessPool) -> Job[Decomposition]:
    """Return the parts of that find that explains most, with the `seconds` that stages took.

    Raises `NoPatternError` where no find explains a pixel.
    """
    yield Progress(0.0, SPLITTING)
    started = time.perf_counter()
    if len(finds) > 1 or finds[0].scale == 1:
        yield from explain_each(finds, pool)
    best = choose(finds)
    result = split(best)
    kept = replace(best.searched, cloth=best.cloth.without_results)
    return replace(result, seconds=seconds | {SPLITTING: time.perf_counter() - started}, found=kept)


def split_without(found: FoundCloth, names: Collection[str]) -> Iterator[tuple[str, Decomposition | None]]:
    """Yield what comes of leaving out each stage of these names by turns, then of all stages; None for no cloth."""
    for name, model in leave_out(begun_model(found), names):
        yield name, finish(found, model) if model.has_cloth else None


def finish(found: FoundCloth, model: PixelModel) -> Decomposition:
    """Return the parts that a model tells, at the photo's size; raise `NoPatternError` where it has no cloth."""
    if not model.has_cloth:
        raise NoPatternError
    lattice, basis = read_lattice(model), measure_basis(model)
    modelled, inside = model.modelled, model.inside
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
        lattice=lattice,
        basis=basis,
        explained=count_explained(found.photo, modelled, inside, found.scale),
    )
