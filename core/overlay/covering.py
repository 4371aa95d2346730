"""Cloth that was left out and is painted by hand: what lies around it goes on there, whatever the photo shows.

So a place is taken in that shows a thing, or cloth that was followed badly and taken for one. What was found stays.
"""

from dataclasses import replace

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.composition import finite
from core.overlay.filters.distances import distance
from core.overlay.filters.shrinking import working_scale
from core.overlay.laying.compositing import Parts, encode
from core.overlay.mesh import around
from core.overlay.pixels.extension import Layers, extend
from core.overlay.pixels.gaps.gap_completion import AROUND, EVERY, SAMPLES, Sewn, bridge, finer, slopes_around
from core.overlay.storage.layers_file import detail_of
from core.overlay.texel import Texel
from core.overlay.tolerances import NEARBY_PX


def cover_parts(parts: Parts, painted: Singles) -> Parts:
    """Return parts with the cloth laid, too, where something is `painted` (H, W), the opacity there, 0 to 1.

    A texture lies as before elsewhere.
    """
    (uv, shading), coverage = cover_painted((parts.uv, parts.shading), parts.coverage, painted, parts.basis)
    detail = detail_of(encode(parts.source), uv, shading, Texel(parts.texel))
    return replace(parts, uv=uv, shading=shading, detail=detail, coverage=coverage, about=parts.middle)


def cover_painted(layers: Layers, coverage: Singles, painted: Singles, basis: Floats) -> tuple[Layers, Singles]:
    """Return layers and coverage (H, W) of cloth that is laid, too, where something is `painted` (H, W).

    That is the opacity there, 0 to 1; `basis` (2, 2) is pixels of undeformed cloth a texel. Nothing is laid where no
    cloth is known at all.
    """
    covered = finite(layers[0])
    wanted = np.asarray((painted > 0) & ~covered, np.bool_)
    if wanted.any() and covered.any():
        side_px = float(np.sqrt(abs(np.linalg.det(basis))))
        box = around(wanted, int(distance(covered)[wanted].max() + 3 * AROUND * side_px))
        uv, shading = (layer.copy() for layer in layers)
        every = int(np.clip(round(side_px / SAMPLES), EVERY[0], EVERY[1] * working_scale(covered.shape)))
        uv[box], shading[box] = go_on((uv[box], shading[box]), wanted[box], basis, every)
        layers = uv, shading
    return layers, np.maximum(coverage, np.where(finite(layers[0]), painted, 0)).astype(np.float32)


def go_on(layers: Layers, wanted: Bools, basis: Floats, every: int) -> Layers:
    """Return layers with the cloth carried on over the `wanted` pixels (H, W), with as little strain as it can.

    Every so many pixels are looked at.
    """
    few, fine = (slice(None, None, every),) * 2, basis / every
    side_px = float(np.sqrt(abs(np.linalg.det(basis))))
    straight, light = extend(layers, wanted, (side_px / every) ** 2, AROUND * side_px / every, every)
    uv, fixed = straight[few].astype(np.float64), finite(layers[0][few])
    free = finite(uv) & ~fixed
    if free.any() and fixed.any():
        slopes = slopes_around(uv @ fine.T, fixed, AROUND * side_px / every)
        found = bridge(uv, fixed, free, slopes, fine, side_px / every)
        sheet = np.where(fixed, 0, -1)
        straight, _ = finer(straight, Sewn(sheet, np.zeros(uv.shape), found), fine, NEARBY_PX / every, every)
    return np.where(wanted[..., None], straight, layers[0]), light
