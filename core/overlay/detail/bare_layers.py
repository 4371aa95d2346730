"""The layers of a cloth that go with a new texture: light and detail without the old pattern."""

import numpy as np

from core.arrays import Floats, Singles
from core.overlay.composition import finite
from core.overlay.detail.residual_cleanup import without_old_pattern
from core.overlay.detail.sparse_reflectance import COLOURS, estimate_bare_light, find_reflectance, spread_of
from core.overlay.filters.bands import in_bands
from core.overlay.mesh import around
from core.overlay.palette import palette
from core.overlay.texel import Texel


def find_bare_layers(
    detail: Singles, uv: Singles, shading: Singles, texel: Texel, basis: Floats
) -> tuple[Singles, Singles]:
    """Return the shading, in its own shape, and the detail (H, W, 3) of the cloth alone, to go with another texture.

    `uv` (H, W, 2), `shading` (H, W) or (H, W, 3) and `detail` are NaN outside the cloth; `basis` (2, 2) is pixels of
    undeformed cloth a texel. What the photo has over the colours of the pattern in that light, wherever these lie, is
    detail, freed of what the texel does not tell of the pattern.
    """
    covered = finite(uv)
    if not covered.any():
        return shading, detail
    box = around(covered)
    colours = shading if shading.ndim == 3 else shading[..., None]
    own = colours.mean(-1)
    changed, rest = np.full_like(colours, np.nan), np.full_like(detail, np.nan)
    light = estimate_bare_light((detail[box], uv[box], own[box]), texel, basis)
    changed[box] = colours[box] * (light / np.maximum(own[box], 1e-6))[..., None]
    known, off = palette(texel, COLOURS), spread_of(detail, covered)

    def move(_first: int, top: int, bottom: int, _last: int) -> None:
        rows = slice(top, bottom)
        shown = texel.singles(np.nan_to_num(uv[rows]).astype(np.float64))
        photo = detail[rows] + colours[rows] * shown
        rest[rows] = photo - changed[rows] * find_reflectance(photo, changed[rows], shown, known, off)

    in_bands(move, detail.shape)
    bare = changed.reshape(shading.shape)
    return bare, without_old_pattern(rest, uv, bare, texel, basis)
