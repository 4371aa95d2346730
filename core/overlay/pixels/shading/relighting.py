"""Cloth on which the model cannot be trusted: its light is the photo's, its pattern is looked for again."""

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.detail.model_validity import trust_in
from core.overlay.detail.sparse_reflectance import mean_light
from core.overlay.filters.distances import open_by_disc
from core.overlay.filters.sampling import spread
from core.overlay.laying.albedo_scale import BRIGHTEST
from core.overlay.mesh import around
from core.overlay.pixels.semi_global_rematching import shifts_where_lost
from core.overlay.pixels.shading.multiscale_light import estimate_light
from core.overlay.texel import Texel
from core.overlay.tolerances import SHADES

EVERY, SAMPLES, MARGIN = 2, 14, 4
"""Least pixels from one place to the next at which the cloth is looked at, places along the side of a texel where there
can be as many, and places around where the pattern is lost."""
HALF = 0.5
"""Trust under which the pattern is lost."""
LEAST = 0.1
"""Radius of a disc that fits into cloth where it is lost, over the side of a texel: a rim is held by what is inside."""


def recover(
    photo: Floats | Singles,
    layers: tuple[Singles, Singles],
    texel: Texel,
    basis: Floats,
    followed: Bools,
) -> tuple[Singles, Singles]:
    """Return coordinates (H, W, 2) and shading (H, W) that suit the photo (H, W, 3) also where the model does not.

    `layers` are the model's, NaN outside the cloth; `followed` (H, W) has been registered; `basis` (2, 2) is pixels of
    undeformed cloth a texel.
    """
    every = max(EVERY, round(float(np.sqrt(abs(np.linalg.det(basis)))) / SAMPLES))
    few, (uv, shading) = slice(None, None, every), layers
    seen, basis = photo[few, few].astype(np.float32), basis / every
    small, light, held = uv[few, few], shading[few, few], followed[few, few]
    covered, side = np.isfinite(light), float(np.sqrt(abs(np.linalg.det(basis))))
    trust = trust_in(seen, small, light, texel, held, side)
    if trust[covered].min(initial=1) == 1:
        return layers
    own = mean_light(seen, covered, texel, basis)
    most = np.float32(np.percentile(light[covered & held], BRIGHTEST) if (covered & held).any() else np.inf)
    own = np.minimum(own, most)
    lost = open_by_disc(np.asarray(covered & (~held | (trust < HALF)), np.bool_), LEAST * side)
    light = trust * light + (1 - trust) * own
    uv = move((seen, uv, light), texel, basis, lost, every)
    small = uv[few, few]
    texture = texel.singles(np.nan_to_num(small.astype(np.float64)))
    own = np.minimum(own * estimate_light(seen, texture, own[..., None], small, texel, basis)[..., 0], most)
    trust, own = (spread(plane, shading.shape, every) for plane in (trust, own))
    return uv, np.asarray(np.minimum(trust * shading + (1 - trust) * own, SHADES[1] * own), np.float32)


def move(seen: tuple[Singles, Singles, Singles], texel: Texel, basis: Floats, lost: Bools, every: int) -> Singles:
    """Return the coordinates (H, W, 2) moved to where the pattern is, where that is `lost` (h, w).

    `seen` are the photo (h, w, 3), these coordinates, and shading (h, w), of which the small ones are every so many
    pixels.
    """
    if not lost.any():
        return seen[1]
    box, (photo, uv, light) = around(lost, MARGIN), seen
    shift = np.zeros((*lost.shape, 2), np.float32)
    shift[box] = shifts_where_lost(photo[box], uv[::every, ::every][box], light[box], texel, basis, lost[box])
    return uv + spread(shift, uv.shape, every)
