"""The decomposition of a photo of patterned cloth into texel, mesh, shading and detail (NRT eq. 1).

I(x) = Wp(x) T(Wg(x)) + HF(x)
"""

import time
from dataclasses import dataclass, field, replace
from typing import TypeVar

import cv2
import numpy as np

from core.arrays import Bools, Floats, Points, Singles
from core.linalg.blas import on_one_thread, one_thread
from core.overlay.albedo_scale import gauge_of
from core.overlay.composition import finite
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError, flat_canvas
from core.overlay.filters.bands import bands
from core.overlay.filters.texture_filter import filter_texture
from core.overlay.finding import find_cloth
from core.overlay.mesh import ClothMesh
from core.overlay.pixels.gap_completion import sew
from core.overlay.pixels.layers import add_rest, explained, other_things, painted
from core.overlay.pixels.matting import carried_past_border, matte_of
from core.overlay.pixels.refinement import refine
from core.overlay.pixels.shading.chromatic_shading import tint
from core.overlay.pixels.shading.fold_light import fold_light
from core.overlay.pixels.shading.relighting import recover
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.evidence import weigh
from core.overlay.registration.fitting import fit
from core.overlay.registration.integer_translation import in_phase
from core.overlay.registration.vertices import whole_lattice
from core.overlay.texel import Texel, draw_sample, estimate_texel
from core.progress import Job, Progress, part

T = TypeVar("T")

WORKING_PX = 1000
"""Longest side of the picture that is searched and registered; larger ones are shrunk for that by a whole number."""
TEXEL_PIXELS = 1_500_000
"""Most pixels from which the texel of a large photo is estimated."""
TINT_STEPS = 1.5
"""Lattice steps over which the light's colour is taken as one."""
TINT_SAMPLES = 12
"""Samples to that width."""


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
    """What speaks for it beside another one of the same photo (`Evidence`)."""
    seconds: dict[str, float] = field(default_factory=dict)
    """Time by stage."""

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
    """
    seconds: dict[str, float] = {}
    whole = np.ones(photo.shape[:2], bool) if region is None else np.asarray(region > 0, np.bool_)
    scale = -(-max(photo.shape[:2]) // WORKING_PX)
    small, valid = (
        shrunk(photo, scale),
        np.asarray(shrunk(whole.astype(float)[..., None], scale)[..., 0] > 0.5, np.bool_),
    )
    canvas = flat_canvas(small, valid)
    if lattice is None:
        side = None if texel_px is None else texel_px / scale
        marked = None if start is None else Proposal(to_small(start.point, scale), start.basis / scale, 1.0)
        job = find_cloth(small, canvas, seed, texel_px=side, start=marked)
    else:
        job = fit(small, canvas, [rescale(piece, scale) for piece in lattice], seed, trusted=True)
    cloth, found = yield from time_stages(part(on_one_thread(job), 0.0, 0.9), seconds)
    yield Progress(0.9, "splitting off the detail")
    started = time.perf_counter()
    with one_thread():
        result = split(cloth, found, photo, whole, scale)
    seconds["splitting off the detail"] = time.perf_counter() - started
    if not result.covered.any():
        raise NoPatternError
    opacity = np.float32(1) if region is None else region.astype(np.float32)
    explained = weigh(cloth, found).explained
    return replace(result, coverage=result.coverage * opacity, explained=explained, seconds=seconds)


def shrunk(image: Floats | Singles, scale: int) -> Floats:
    """Return the means (h, w, C) of squares of `scale` pixels; the last may be cut by the picture's edge."""
    if scale == 1:
        return image.astype(np.float64, copy=False)
    h, w = (-(-n // scale) for n in image.shape[:2])
    rest = h * scale - image.shape[0], w * scale - image.shape[1]
    padded = np.pad(image, ((0, rest[0]), (0, rest[1]), (0, 0)), mode="edge") if any(rest) else image
    return np.asarray(padded.reshape(h, scale, w, scale, -1).mean((1, 3), np.float64))


def to_small(points: Points, scale: int) -> Points:
    """Return where points of a picture lie in the picture that `shrunk` makes."""
    return (points - (scale - 1) / 2) / scale


def rescale(lattice: Lattice, scale: int) -> Lattice:
    """Return a lattice of a picture on the picture that `shrunk` makes."""
    frames = lattice.frames
    return replace(lattice, frames=PatchFrames(to_small(frames.points, scale), frames.bases / scale, frames.scores))


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


def split(cloth: FittedCloth, found: Fit, photo: Floats | Singles, valid: Bools, scale: int) -> Decomposition:
    """Return the parts at every pixel of the photo, of which the cloth was fitted at 1 / `scale` of the size."""
    pieces = in_phase(cloth.mesh, found.pieces, cloth.step_px)
    masks = explained(cloth, found, pieces)
    mesh = ClothMesh(photo.shape[:2], cloth.mesh.cell * scale)
    uv, shading = painted(mesh, pieces, masks, valid)
    followed = np.isfinite(shading)
    texel = found.texel if scale == 1 else finer_texel(cloth, photo, uv, shading, followed, scale)
    add_rest((uv, shading), cloth, found, mesh, pieces, masks, photo)
    uv[~valid], shading[~valid] = np.nan, np.nan
    off = other_things(photo, (uv, shading), texel, cloth, scale)
    # Cloth goes on under what lies on it.
    uv, other = sew(photo, (uv, shading), followed, texel, cloth.basis, cloth.step_px, scale, hidden=off)
    followed &= ~other
    uv[off], shading[off], followed[off] = np.nan, np.nan, False
    uv, shading = recover(photo, (uv, shading), texel, cloth.basis * scale, followed, scale=scale)
    uv = refine(photo, uv, shading, texel, cloth.basis * scale, every=max(1, scale // 2))
    texel = finer_texel(cloth, photo, uv, shading, followed, scale)
    gauge = gauge_of(shading, texel.pixels)
    # The texel is rounded as its file is, so that the parts that are written recombine.
    texel = Texel(np.rint(255 * np.clip(texel.pixels / gauge, 0, 1)) / 255)
    outline = np.asarray(np.isfinite(shading), np.bool_)
    uv, shading = carried_past_border(uv, shading, valid & ~off)
    inside, light = np.isfinite(shading), (shading * np.float32(gauge))[..., None]
    modelled = texture_at(texel, uv)
    modelled *= np.nan_to_num(light)
    folds = fold_light(photo, modelled, uv, followed, texel, cloth.basis * scale)
    light *= folds
    modelled *= folds
    del folds
    colour = estimate_coloured_light(photo, modelled, followed, scale, TINT_STEPS * cloth.step_px)
    if colour is not None:
        light, modelled = light * colour, modelled * colour
    lattice = whole_lattice(cloth, pieces, found)
    frames = PatchFrames(
        scale * lattice.frames.points + (scale - 1) / 2, scale * lattice.frames.bases, lattice.frames.scores
    )
    return Decomposition(
        photo=photo,
        uv=uv,
        texel=texel,
        shading=light[..., 0] if light.shape[-1] == 1 else light,
        detail=difference(photo, modelled, inside),
        reconstruction=modelled,
        coverage=matte_of(photo, modelled, outline, inside),
        lattice=replace(lattice, frames=frames),
        basis=cloth.basis * scale,
    )


def finer_texel(
    cloth: FittedCloth, photo: Floats | Singles, uv: Singles, shading: Singles, followed: Bools, scale: int
) -> Texel:
    """Return the texel at the photo's own resolution, from what is followed (H, W)."""
    covered = draw_sample(followed, TEXEL_PIXELS)
    h, w = cloth.texel_samples
    return estimate_texel(photo, uv, shading, covered, (h * scale, w * scale))


def texture_at(texel: Texel, uv: Singles) -> Singles:
    """Return the texture's colours (H, W, 3) at coordinates (H, W, 2), 0 where they are NaN."""
    out = np.empty((*uv.shape[:2], 3), np.float32)
    for first, top, bottom, last in bands(len(uv), margin=1):
        out[top:bottom] = filter_texture(texel.pixels, uv[first:last].astype(float))[top - first : bottom - first]
    return out


def estimate_coloured_light(
    photo: Floats | Singles, modelled: Singles, inside: Bools, scale: int, sigma_px: float
) -> Singles | None:
    """Return each channel's own factor (H, W, 3), or None where light has one colour.

    `sigma_px` is over every `scale`-th pixel; as few are looked at as that allows.
    """
    every = max(1, int(sigma_px / TINT_SAMPLES))
    few = slice(None, None, scale * every)
    colour = tint(photo[few, few].astype(float), modelled[few, few].astype(float), inside[few, few], sigma_px / every)
    if colour is None:
        return None
    return np.asarray(cv2.resize(colour.astype(np.float32), inside.shape[::-1], interpolation=cv2.INTER_LINEAR))


def difference(photo: Floats | Singles, modelled: Singles, inside: Bools) -> Singles:
    """Return the photo less the model (H, W, 3), NaN outside."""
    out: Singles = np.subtract(photo, modelled, dtype=np.float32, casting="same_kind")
    out[~inside] = np.nan
    return out
