"""A cloth that was found and registered on a photo: it is compared with others by what comes of it in the end."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.linalg.blas import one_thread
from core.linalg.jobs_beside import PlannedJob, ProcessPool
from core.overlay.detection.seeding import NoPatternError
from core.overlay.filters.shrinking import shrunk_mask, working_scale
from core.overlay.likelihood import count_explained
from core.overlay.pixels.layers import spread_mask
from core.overlay.pixels.model import PixelModel, begin
from core.overlay.pixels.stages import FINISHING, LAYING, go_through
from core.overlay.registration.cloth import Fit, FittedCloth
from core.progress import Job, Progress, part

Explaining: TypeAlias = PlannedJob[tuple[float, PixelModel]]

EXPLAINING = "comparing with the photo"


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
    """Whether it is clear, and covers nearly all that may be cloth (`Find`)."""
    is_clear: bool
    """Whether no doubt is left about what it covers (`Find`)."""
    is_told: bool
    """Whether somebody said where the cloth is."""

    @property
    def covered(self) -> Bools:
        """Pixels (H, W) of the photo in which it is registered."""
        return spread_mask(self.cloth.valid & self.cloth.mesh.pixels_of(self.fit.cells), self.valid.shape)

    @cached_property
    def laid(self) -> PixelModel:
        """What is told at every pixel of the photo as it was searched."""
        with one_thread():
            laid = go_through(begun_model(self), LAYING)
        return replace(laid, cloth=laid.cloth.without_results)

    @cached_property
    def model(self) -> PixelModel:
        """What all stages tell at every pixel of the photo, kept: that of a large photo is much memory."""
        return finished_model(self.laid)

    @cached_property
    def explained(self) -> float:
        """What speaks for it beside another find, as it comes out on the photo as it was searched (`count_explained`).

        -inf where no pixel of the photo is explained.
        """
        model = self.model if self.scale == 1 else finished_model(self.laid.as_searched)
        return count_explained(model.photo, model.modelled, model.inside) if model.has_cloth else -math.inf

    def is_to_explain(self, pool: ProcessPool) -> bool:
        """Return whether what speaks for it is not known, and may be told in another process."""
        return pool.is_beside and "explained" not in vars(self)

    def take(self, explained: float, model: PixelModel | None) -> None:
        """Keep what speaks for it, and what all stages tell if that is of the photo's size, as told in a job."""
        vars(self)["explained"] = explained
        if model is not None and self.scale == 1:
            vars(self)["model"] = model

    def forget_model(self) -> None:
        """Let go of what is told at every pixel, which takes memory: it is told again when it is asked for."""
        for name in ("model", "laid"):
            vars(self).pop(name, None)

    @property
    def searched(self) -> "FoundCloth":
        """The find on the photo as it was searched."""
        if self.scale == 1:
            return self
        valid = shrunk_mask(self.valid, self.scale)
        return replace(self, photo=self.cloth.photo, valid=valid, scale=1, opacity=np.float32(1))


def choose(finds: list[FoundCloth]) -> FoundCloth:
    """Return that find which explains most, the only one that keeps its model.

    Raises `NoPatternError` where none of several explains a pixel.
    """
    best = keep_best_model(finds)
    if len(finds) > 1 and best.explained == -math.inf:
        raise NoPatternError
    return best


def keep_best_model(finds: list[FoundCloth]) -> FoundCloth:
    """Return that find which explains most, the first of equals; the others let go of their models, each at once."""
    best = finds[0]
    for find in finds[1:]:
        worse, best = (best, find) if find.explained > best.explained else (find, best)
        worse.forget_model()
    return best


def explain_each(finds: list[FoundCloth], pool: ProcessPool) -> Job[None]:
    """Tell what speaks for each find, at once where the `pool` has other processes; else it is told when asked for."""
    begun = begin_to_explain(finds[1:], pool)
    first = [(found, pool.plan(explain, found.searched)) for found in finds[:1] if found.is_to_explain(pool)]
    yield from take_explained(first + begun)


def begin_to_explain(finds: list[FoundCloth], pool: ProcessPool) -> list[tuple[FoundCloth, Explaining]]:
    """Begin to tell what speaks for each find, where that is not known and the `pool` has other processes."""
    return [(found, pool.begin(explain, found.searched)) for found in finds if found.is_to_explain(pool)]


def take_explained(begun: list[tuple[FoundCloth, Explaining]]) -> Job[None]:
    """Keep with each find what speaks for it, and with the best one what is told at every pixel."""
    best: FoundCloth | None = None
    for found, explaining in begun:
        found.take(*(yield from part(explaining.result(), 0.0, 0.0)))
        best = found if best is None else keep_best_model([best, found])


def explain(found: FoundCloth) -> Job[tuple[float, PixelModel]]:
    """Return what speaks for a find of a photo as it was searched, and what all stages tell of it."""
    yield Progress(0.0, EXPLAINING)
    return found.explained, found.model


def begun_model(found: FoundCloth) -> PixelModel:
    """Return what is known of a find before any stage."""
    return begin(found.cloth, found.fit, found.photo, found.valid, is_told=found.is_told)


def finished_model(laid: PixelModel) -> PixelModel:
    """Return what all stages tell of cloth that was laid on the photo as it was searched."""
    with one_thread():
        return go_through(laid, FINISHING)


def at_photo_size(found: FoundCloth, photo: Floats | Singles, region: Bools | Singles | None) -> FoundCloth:
    """Return a find on a photo as it was searched on the photo (H, W, 3); what may be cloth is that in a region told.

    What speaks for it stays known.
    """
    scale, shape = working_scale(photo.shape), photo.shape[:2]
    if scale == 1:
        return found
    if region is None:
        opacity = found.opacity
        if isinstance(opacity, np.ndarray):
            opacity = spread_mask(np.asarray(opacity > 0, np.bool_), shape).astype(np.float32)
        large = replace(found, photo=photo, valid=spread_mask(found.valid, shape), scale=scale, opacity=opacity)
    else:
        large = within(replace(found, photo=photo, scale=scale), region)
    if "explained" in vars(found):
        large.take(found.explained, None)
    return large


def within(found: FoundCloth, region: Bools | Singles | None) -> FoundCloth:
    """Return a find of which what lies in a region (H, W) of the photo may be cloth."""
    return replace(found, valid=may_be_cloth(found.photo, region), opacity=opacity_of(region))


def may_be_cloth(photo: Floats | Singles, region: Bools | Singles | None) -> Bools:
    """Return where (H, W) cloth may be."""
    return np.ones(photo.shape[:2], bool) if region is None else np.asarray(region > 0, np.bool_)


def opacity_of(region: Bools | Singles | None) -> Singles | np.float32:
    """Return the opacity (H, W), or one number, of what is laid."""
    return np.float32(1) if region is None else region.astype(np.float32)
