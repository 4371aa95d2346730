"""The listed stages from registered pieces of mesh to the parts of the photo (NRT eq. 1).

I(x) = Wp(x) T(Wg(x)) + HF(x)
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import replace

import cv2
import numpy as np

from core.arrays import Bools, Singles
from core.overlay.filters.distances import distance, open_by_disc, within
from core.overlay.filters.texture_filter import filter_large
from core.overlay.laying.albedo_scale import gauge_of
from core.overlay.mesh import around
from core.overlay.palette import MANY, palette
from core.overlay.pixels.extension import extend
from core.overlay.pixels.filling import carried_on, filled
from core.overlay.pixels.gaps.gap_completion import sew
from core.overlay.pixels.jacobian_validity import find_untorn
from core.overlay.pixels.layers import explained, paint, spread_mask, spread_plane
from core.overlay.pixels.matting import matte_of
from core.overlay.pixels.model import PixelModel, begin
from core.overlay.pixels.occluders import find_occluders
from core.overlay.pixels.outline import find_outline, reach
from core.overlay.pixels.refinement import refine
from core.overlay.pixels.shading.chromatic_shading import find_tint
from core.overlay.pixels.shading.multiscale_light import estimate_light
from core.overlay.pixels.shading.relighting import recover
from core.overlay.pixels.surroundings import find_surroundings
from core.overlay.registration.constrained_registration import FIRM, settle
from core.overlay.registration.fine_mesh import register_finely
from core.overlay.texel import Texel, draw_sample, estimate_texel
from core.overlay.tolerances import DRAWN, NEARBY_PX, RIM_PX

PixelStage = Callable[[PixelModel], PixelModel]

AROUND = 8
"""Widths of a neighbourhood around the cloth beyond which nothing tells of it."""
TINT_STEPS = 1.5
"""Lattice steps over which the light's colour is taken as one."""
TINT_SAMPLES = 12
"""Samples to that width."""


def refine_mesh(model: PixelModel) -> PixelModel:
    """Register the pieces on a mesh whose cells are small beside folds."""
    cloth, found = register_finely(model.cloth, model.found)
    return begin(cloth, found, model.own_photo, model.own_valid, is_told=model.is_told)


def explain_pixels(model: PixelModel) -> PixelModel:
    """Tell pixel by pixel what each piece explains."""
    return replace(model, masks=tuple(explained(model.cloth, model.found, list(model.pieces))))


def paint_pieces(model: PixelModel) -> PixelModel:
    """Take coordinates and shading from the mesh where the pieces explain the photo."""
    layers = model.uv.copy(), model.shading.copy()
    paint(layers, model.cloth.mesh, list(model.pieces), list(model.masks), model.valid)
    return replace(model, uv=layers[0], shading=layers[1], followed=np.isfinite(layers[1]))


def fill_gaps(model: PixelModel) -> PixelModel:
    """Carry the pieces on to cloth that is seen but was not followed."""
    cloth, masks = model.cloth, list(model.masks)
    if not (cloth.valid & ~np.any(masks, axis=0)).any():
        return model
    layers = model.uv.copy(), model.shading.copy()
    more = filled(cloth, model.found, list(model.pieces), masks)
    covered = np.asarray(np.any(masks, axis=0), np.bool_)
    carried = [settle(cloth, model.found, *filling, covered) for filling in zip(more.pieces, more.masks, strict=True)]
    paint(layers, cloth.mesh, carried, more.masks, model.valid)
    return extend_to(replace(model, uv=layers[0], shading=layers[1]), more.apart)


def find_border(model: PixelModel) -> PixelModel:
    """Carry the cloth on to where its outline is seen, and take away what lies beyond that."""
    seen, _, rho, covered = layers_of(model)
    width_px = border_width_px(model)
    further = reach(covered, width_px) & model.valid & ~model.hidden
    box, inside = around(covered | further, int(AROUND * width_px)), np.zeros_like(covered)
    inside[box] = find_outline(seen[box], model.texel, rho[box], covered[box], further[box], width_px)
    border = without_pixels(extend_to(model, further & inside), covered & ~inside)
    return settle_border(border, further & inside, covered & inside)


def settle_border(model: PixelModel, wanted: Bools, covered: Bools) -> PixelModel:
    """Register what was carried straight on to wanted pixels (H, W), where the mesh can go on from `covered` ones."""
    if not wanted.any():
        return model
    layers = model.uv.copy(), model.shading.copy()
    owner = np.stack([distance(mask) for mask in model.masks]).argmin(0)
    for number, piece in enumerate(model.pieces):
        further, sound = carried_on(model.cloth, piece, wanted & (owner == number))
        for layer in layers:
            layer[sound] = np.nan
        settled = settle(model.cloth, model.found, further, sound, covered, FIRM)
        paint(layers, model.cloth.mesh, [settled], [sound], model.valid)
    return replace(model, uv=layers[0], shading=layers[1])


def border_width_px(model: PixelModel) -> float:
    """Return the width of the neighbourhood that tells where the cloth ends."""
    return max(NEARBY_PX, model.cloth.sigma_px)


def cut_surroundings(model: PixelModel) -> PixelModel:
    """Take ground that the mesh has gone on over for the surroundings, where nobody said that there is cloth."""
    if model.is_told:
        return model
    seen, _, _, covered = layers_of(model)
    beyond = ~(covered | reach(covered, border_width_px(model)))
    # What is thinner is told pixel by pixel, by the outline.
    ground = find_surroundings(seen, covered, model.followed, beyond, model.cloth.side_px)
    return hide(model, open_by_disc(ground, RIM_PX))


def cut_occluders(model: PixelModel) -> PixelModel:
    """Tell what lies on the cloth."""
    seen, texture, rho, covered = layers_of(model)
    box, things = around(covered, int(AROUND * RIM_PX)), np.zeros_like(covered)
    layers = seen[box], texture[box], rho[box]
    things[box] = find_occluders(*layers, model.texel, model.cloth.side_px, covered[box])
    return hide(model, things)


def complete_gaps(model: PixelModel) -> PixelModel:
    """Sew together what was surely followed; cloth goes on under what lies on it."""
    layers, lengths = (model.uv, model.shading), (model.cloth.basis, model.cloth.step_px)
    uv, other = sew(model.photo, layers, model.texel, *lengths, hidden=model.hidden)
    return replace(model, uv=uv, followed=model.followed & ~other)


def uncover_hidden(model: PixelModel) -> PixelModel:
    """Leave to the photo what shows another thing; the outline is that of what remains."""
    seen = without_pixels(model, model.hidden)
    return replace(seen, outline=np.isfinite(seen.shading))


def relight(model: PixelModel) -> PixelModel:
    """Find light and pattern anew where the model cannot be trusted."""
    layers = model.uv, model.shading
    uv, shading = recover(model.photo, layers, model.texel, model.basis, model.followed)
    return replace(model, uv=uv, shading=shading)


def refine_pixels(model: PixelModel) -> PixelModel:
    """Move single pixels, where the mesh is too coarse, and once more by the texel that is told from where they lie.

    Both times they are moved from where the mesh has them: further on, the cloth would bend. A third changes little.
    """
    return refine_by(model, refine_by(model, model.texel).texel)


def refine_by(model: PixelModel, texel: Texel) -> PixelModel:
    """Return the model with single pixels moved to where a texel explains them best, and the texel told from there."""
    every, uv = max(1, model.scale - 1), model.uv.copy()
    box = around(model.inside, int(AROUND * every * RIM_PX))
    layers = model.photo[box], uv[box], model.shading[box]
    uv[box] = refine(*layers, texel, model.basis, every=every)
    return estimate_finer_texel(replace(model, uv=uv))


def enlarge(model: PixelModel) -> PixelModel:
    """Take what was laid on the photo as it was searched to the photo's own size.

    Between pixels coordinates and light are linear; beside a jump and at the border the cloth goes straight on. Then
    the texel is told, and single pixels are moved, from all that the photo shows.
    """
    if model.own_valid.shape == model.valid.shape:
        return model
    own, shape = model.own_valid, model.own_valid.shape
    near = cv2.dilate(model.outline.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    # Cloth that fills all that may be cloth ends where that does, and not with a pixel of the searched photo.
    inside = own & spread_mask(model.outline | (~model.valid & near), shape)
    torn = np.where(find_untorn(model.uv.astype(np.float64), model.basis), np.float32(0), np.float32(np.nan))
    large = replace(
        model,
        photo=model.own_photo,
        valid=own,
        uv=spread_plane(model.uv + torn[..., None], shape),
        shading=spread_plane(model.shading + torn, shape),
        followed=spread_mask(model.followed, shape),
        outline=inside,
    )
    laid = estimate_finer_texel(extend_to(without_pixels(large, ~(inside & spread_mask(model.outline, shape))), inside))
    return refine_by(laid, laid.texel)


def estimate_finer_texel(model: PixelModel) -> PixelModel:
    """Estimate the texel at the resolution of the photo, from what is followed.

    It is the mean of all that: things that lie on the cloth are not followed, and where texels differ it leaves least.
    """
    covered = draw_sample(model.followed, DRAWN)
    size = tuple(samples * model.scale for samples in model.cloth.texel_samples)
    texel = estimate_texel(model.photo, model.uv, model.shading, covered, (size[0], size[1]), is_robust=False)
    return replace(model, texel=model.cloth.as_woven(texel))


def scale_albedo(model: PixelModel) -> PixelModel:
    """Share brightness out between texel and light."""
    gauge = gauge_of(model.shading, model.texel.pixels)
    return replace(model, texel=Texel(model.texel.pixels / gauge), shading=model.shading * np.float32(gauge))


def soften_border(model: PixelModel) -> PixelModel:
    """Carry the cloth a few pixels past its outline, where the border may be soft."""
    return extend_to(model, within(model.outline, RIM_PX) & ~spread_mask(model.hidden, model.valid.shape))


def draw_model(model: PixelModel) -> PixelModel:
    """Draw what texel and light make; the texel is rounded as its file is, so that parts that are written recombine."""
    texel = Texel(np.rint(255 * np.clip(model.texel.pixels, 0, 1)) / 255)
    light, texture = model.shading[..., None], filter_large(texel.pixels, model.uv)
    return replace(model, texel=texel, light=light, texture=texture, coverage=model.outline.astype(np.float32))


def light_folds(model: PixelModel) -> PixelModel:
    """Find the light in folds that are finer than the mesh."""
    box, light = around(model.inside, 1), model.light.copy()
    layers = model.texture[box], light[box], model.uv[box]
    light[box] *= estimate_light(model.photo[box], *layers, model.texel, model.basis, scale=model.scale)
    return replace(model, light=light)


def tint_light(model: PixelModel) -> PixelModel:
    """Give each channel a light of its own where the light's colour changes."""
    sigma_px = TINT_STEPS * model.cloth.step_px
    colour = estimate_coloured_light(model, sigma_px)
    return model if colour is None else replace(model, light=model.light * colour)


def matte_border(model: PixelModel) -> PixelModel:
    """Tell what share of a pixel is cloth, where the border is soft; nothing is laid where none is."""
    inside = model.inside
    colours, light_at = palette(model.texel, MANY), model.light.__getitem__
    coverage = matte_of(model.photo, model.modelled_at, light_at, colours, model.outline, inside)
    seen, off = without_pixels(model, coverage == 0), (coverage == 0)[..., None]
    return replace(seen, coverage=coverage, light=np.where(off, np.float32(np.nan), model.light))


LAYING: tuple[PixelStage, ...] = (
    refine_mesh,
    explain_pixels,
    paint_pieces,
    fill_gaps,
    cut_surroundings,
    find_border,
    cut_occluders,
    complete_gaps,
    uncover_hidden,
    relight,
    refine_pixels,
)
"""On the photo as it was searched."""
FINISHING: tuple[PixelStage, ...] = (
    enlarge,
    scale_albedo,
    soften_border,
    draw_model,
    light_folds,
    tint_light,
    matte_border,
)
"""On the photo at its own size."""
STAGES = LAYING + FINISHING
NEEDED = frozenset((paint_pieces, uncover_hidden, enlarge, draw_model))
"""Stages without which there is no result, or one with pixels where there may be none."""
OPTIONAL = tuple(stage.__name__ for stage in STAGES if stage not in NEEDED)
"""The names of those that can be left out, to see what they are worth."""
WHOLE = "nothing"
"""What is left out where all are gone through."""


def go_through(model: PixelModel, stages: Iterable[PixelStage] = STAGES) -> PixelModel:
    """Return the model after some stages."""
    for stage in stages:
        model = stage(model)
    return model


def leave_out(model: PixelModel, names: Collection[str]) -> Iterator[tuple[str, PixelModel]]:
    """Yield for each stage of one of these names the model after all the others; what goes before is done once."""
    for number, stage in enumerate(STAGES):
        if stage.__name__ in names:
            yield stage.__name__, go_through(model, STAGES[number + 1 :])
        model = stage(model)
    yield WHOLE, model


def extend_to(model: PixelModel, wanted: Bools) -> PixelModel:
    """Return the model with the cloth carried straight on to the wanted pixels (H, W) where it may be."""
    texel_px = abs(float(np.linalg.det(model.cloth.basis)))
    layers = (model.uv, model.shading), wanted & model.valid
    uv, shading = extend(*layers, texel_px, model.cloth.sigma_px, model.scale)
    return replace(model, uv=uv, shading=shading)


def layers_of(model: PixelModel) -> tuple[Singles, Singles, Singles, Bools]:
    """Return photo, T(uv) (H, W, 3) and shading (H, W), 0 where there is none, and which pixels show cloth so far."""
    texture = model.texel.singles(np.nan_to_num(model.uv.astype(np.float64)))
    covered = np.asarray(np.isfinite(model.shading) & ~model.hidden, np.bool_)
    return np.asarray(model.photo, np.float32), texture, np.nan_to_num(model.shading), covered


def hide(model: PixelModel, off: Bools) -> PixelModel:
    """Return the model with more pixels (h, w) taken for another thing."""
    return replace(model, hidden=model.hidden | off)


def without_pixels(model: PixelModel, off: Bools) -> PixelModel:
    """Return the model with nothing laid at some pixels (H, W)."""
    if not off.any():
        return model
    uv = np.where(off[..., None], np.float32(np.nan), model.uv)
    return replace(
        model, uv=uv, shading=np.where(off, np.float32(np.nan), model.shading), followed=model.followed & ~off
    )


def estimate_coloured_light(model: PixelModel, sigma_px: float) -> Singles | None:
    """Return each channel's own factor (H, W, 3), or None where light has one colour.

    `sigma_px` is of the searched photo; as few pixels are looked at as that allows.
    """
    every = max(1, int(sigma_px / TINT_SAMPLES))
    few = (slice(None, None, model.scale * every),) * 2
    photo, modelled = (plane.astype(np.float64) for plane in (model.photo[few], model.modelled_at(few)))
    colour = find_tint(photo, modelled, model.followed[few], sigma_px / every)
    if colour is None:
        return None
    size = model.followed.shape[::-1]
    return np.asarray(cv2.resize(colour.astype(np.float32), size, interpolation=cv2.INTER_LINEAR))
