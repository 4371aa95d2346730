"""Cloth carried straight on: into a gap in which the mesh would be crushed or torn, and past the cloth's border.

Beside a fold the pattern jumps: what is hidden leaves its two sides with coordinates that do not meet. A place there
belongs to the nearest cloth, whose coordinates go on with the slope that they have around it.
"""

import numpy as np

from core.arrays import Bools, Floats, Ints, Singles
from core.overlay.filters.distances import nearest_of
from core.overlay.filters.smoothing import mean
from core.overlay.filters.texture_filter import steepness
from core.overlay.tolerances import STRETCH

Layers = tuple[Singles, Singles]
"""Texture coordinates (H, W, 2) and shading (H, W) or (H, W, 3), NaN where there are none."""


def extend(layers: Layers, wanted: Bools, texel_px: float, sigma_px: float, scale: int = 1) -> Layers:
    """Return layers that also have what goes straight on at the `wanted` pixels (H, W) that had nothing.

    Cloth goes on from where it is sound: neither crushed nor blown up beyond a texel's area `texel_px` of cloth that
    lies flat. Slopes and light are means over `sigma_px`. Both lengths are in `scale` pixels; every `scale`-th pixel
    is looked at.
    """
    few = slice(None, None, scale), slice(None, None, scale)
    light = layers[1] if layers[1].ndim == 3 else layers[1][..., None]
    uv, slopes = layers[0][few].astype(np.float64), slopes_of(layers[0][few].astype(np.float64))
    sound = np.asarray(np.isfinite(light[few][..., 0]) & find_sound(slopes, texel_px), np.bool_)
    rows, columns = np.nonzero(wanted & np.isnan(light[..., 0]))
    if not sound.any() or not len(rows):
        return layers
    planes = np.where(sound[..., None], np.concatenate([slopes, light[few]], -1), 0).astype(np.float32)
    planes = mean(planes, sound[..., None].astype(np.float32), sigma_px)
    places = np.stack([rows, columns], -1) / scale
    down, across = nearest_to(places, nearest_of(sound)[1])
    usual = planes[down, across].astype(np.float64)
    away = places - np.stack([down, across], -1)
    out = layers[0].copy(), layers[1].copy()
    out[0][rows, columns] = uv[down, across] + np.einsum("nij,ni->nj", usual[:, :4].reshape(-1, 2, 2), away)
    out[1][rows, columns] = usual[:, 4:].reshape(-1, *layers[1].shape[2:])
    return out


def nearest_to(places: Floats, nearest: Ints) -> tuple[Ints, Ints]:
    """Return row and column (n,) of the pixel nearest to places (n, 2) between pixels, of those of the four around.

    `nearest` (H, W) has the number of the one nearest to each pixel.
    """
    low = places.astype(np.int64)
    found, least = np.zeros_like(low), np.full(len(low), np.inf)
    for step in np.ndindex(2, 2) if (low != places).any() else [(0, 0)]:
        row, column = np.minimum(low + step, np.array(nearest.shape) - 1).T
        pixel = np.stack(np.divmod(nearest[row, column], nearest.shape[1]), -1)
        off = ((pixel - places) ** 2).sum(-1)
        nearer = off < least
        found[nearer], least[nearer] = pixel[nearer], off[nearer]
    return found[:, 0], found[:, 1]


def slopes_of(uv: Floats) -> Floats:
    """Return the slopes (H, W, 4) of coordinates (H, W, 2): of both by row, then by column."""
    return np.concatenate([steepness(uv, axis) for axis in (0, 1)], -1)


def find_sound(slopes: Floats, texel_px: float) -> Bools:
    """Return where (H, W) slopes (H, W, 4) neither crush the cloth nor blow it up, beyond so many pixels a texel."""
    area = np.abs(slopes[..., 0] * slopes[..., 3] - slopes[..., 1] * slopes[..., 2]) * texel_px
    return np.asarray((area > 1 / STRETCH) & (area < STRETCH), np.bool_)
