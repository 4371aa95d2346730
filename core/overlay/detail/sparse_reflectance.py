"""The light in which a photo shows the few colours of a pattern, wherever they lie (Gehler et al. 2011).

Where the mesh lies beside the pattern, the photo over T(uv) is the old pattern and no light, and so is the edge of a
thin line a pixel off. So each pixel may show the model's colour or, less likely, any other one of the pattern's, and of
several lights that is likely in which most pixels around a place do. The light is about its mean over a texel, which
knows nothing of where the pattern lies. What is taken is the mean over all lights, each by how likely it is. In that
light the colour of each pixel is told in the same way, for a fold may be narrower than what has one light.
"""

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.filters.sampling import spread
from core.overlay.filters.smoothing import gaussian
from core.overlay.palette import MANY, palette
from core.overlay.texel import Texel, draw_sample
from core.overlay.tolerances import DRAWN, MOTIF_PX, SHADES

WIDTH, MOST_PX = 0.2, 5.0
"""Width of the neighbourhood that has one light, over the side of a texel, and in pixels of the working size."""
LEAST_SPREAD, LEAST = 0.015, 1e-3
"""Spread, of a channel, of a colour that is one of the pattern's, at least, and the least light."""
OTHER, NONE = 2.0, 4.0
"""How much less likely another colour of the pattern is than the model's, and a colour that is none: nats."""
SPEAK = 3.0
"""Pixels of a neighbourhood that speak for themselves: others follow from those."""
SPREAD = 0.15
"""Spread of the light around its mean over a texel, as its logarithm, and of a fold's in that light."""
LIGHTS = np.linspace(-0.9, 0.6, 13), np.linspace(-0.15, 0.15, 7)
"""Logarithms of the lights that are tried, over the mean over a texel, and then around what that tells."""
WHOLE = 0.8
"""Width of a neighbourhood that has every colour of a texel in its share, over the texel's longer side."""


def estimate_bare_light(layers: tuple[Singles, Singles, Singles], texel: Texel, basis: Floats, scale: int) -> Singles:
    """Return the light (H, W) of a photo without what the model's has of the pattern.

    `layers` are detail (H, W, 3), uv (H, W, 2) and light (H, W), NaN outside the cloth; `basis` (2, 2) is pixels of
    undeformed cloth a texel, `scale` how much larger the photo is than one of the working size.
    """
    shape, side = layers[2].shape, float(np.sqrt(abs(np.linalg.det(basis))))
    width = min(WIDTH * side, MOST_PX * scale)
    every = max(scale, int(width / 2))
    few = slice(None, None, every), slice(None, None, every)
    detail, uv, own = (layer[few] for layer in layers)
    covered = np.isfinite(own)
    shown = texel.singles(np.nan_to_num(uv).astype(np.float64))
    photo = np.nan_to_num(detail + own[..., None] * shown)
    whole = np.log(np.maximum(mean_light(photo, covered, texel, basis / every), LEAST))
    off = 2 * spread_of(detail, covered)
    change = np.zeros_like(whole)
    for lights in LIGHTS:
        costs = costs_of(photo, shown, palette(texel, MANY), whole + change, lights, off)
        change += choose(costs, lights, change, covered, width / every)
    return np.where(np.isfinite(layers[2]), np.exp(spread(whole + change, shape, every)), np.float32(np.nan))


def spread_of(detail: Singles, covered: Bools) -> float:
    """Return by how much a channel of a photo usually misses the colour that it shows; `detail` is (H, W, 3)."""
    return max(float(np.median(np.abs(detail[draw_sample(covered, DRAWN)]))), LEAST_SPREAD)


def find_reflectance(photo: Singles, light: Singles, shown: Singles, colours: Singles, off: float) -> Singles:
    """Return the mean (H, W, 3) of the colours that a photo (H, W, 3) may show, each by how likely it is.

    That is in equal shares the model's, `shown` (H, W, 3), and one of the pattern's `colours` (k, 3), wherever it lies.
    In a `light` ρ (H, W, 1 or 3) that varies by `SPREAD` a colour c is seen as ρc, with covariance off² 1 + SPREAD² ρc
    (ρc)ᵀ, which is what cloth is off by and what a fold makes of it.
    """
    lit, level = photo * light, np.broadcast_to(light, photo.shape) ** 2
    # (I - ρc)·ρc is made of I·ρc and |ρc|², one plane for each colour.
    along = np.stack([np.einsum("hwc,hwc->hw", lit, shown), *np.einsum("kc,hwc->khw", colours, lit)])
    square = np.stack([np.einsum("hwc,hwc->hw", level, shown**2), *np.einsum("kc,hwc->khw", colours**2, level)])
    costs = (square - 2 * along - (along - square) ** 2 / (square + np.float32(off / SPREAD) ** 2)) / (2 * off**2)
    share = np.exp(costs.min(0) - costs)
    share[1:] /= len(colours)
    seen = share[0][..., None] * shown + np.einsum("khw,kc->hwc", share[1:], colours)
    return np.asarray(seen / share.sum(0)[..., None], np.float32)


def find_shade(detail: Singles, seen: Singles, off: float) -> Singles:
    """Return by what share (H, W, 1) the light is more, or less, where a detail (H, W, 3) is a shade of the cloth.

    `seen` (H, W, 3) is what cloth looks like without that; both are 0 where there is none. Shares are `SPREAD` wide.
    """
    along, square = (np.einsum("hwc,hwc->hw", plane, seen) for plane in (detail, seen))
    share = gaussian(along, MOTIF_PX) / (gaussian(square, MOTIF_PX) + np.float32(off / SPREAD) ** 2)
    return np.asarray(np.clip(share, SHADES[0] - 1, SHADES[1] - 1)[..., None], np.float32)


def costs_of(photo: Singles, shown: Singles, colours: Singles, light: Singles, lights: Floats, off: float) -> Singles:
    """Return how unlikely a photo (H, W, 3) is, nats, in each of several lights (n, H, W) over a `light` (H, W).

    A pixel has the colour that is `shown` (H, W, 3), another one of the `colours` (k, 3), or none, `off` by about that.
    Lights are logarithms.
    """
    squares, level = np.einsum("hwc,hwc->hw", photo, photo), np.exp(light)
    others = np.einsum("hwc,kc->khw", photo, colours) * level, (colours**2).sum(1)[:, None, None] * level**2
    model = np.einsum("hwc,hwc->hw", photo, shown) * level, np.einsum("hwc,hwc->hw", shown, shown) * level**2
    out = np.empty((len(lights), *light.shape), np.float32)
    for cost, factor in zip(out, np.exp(lights).astype(np.float32), strict=True):
        np.min(factor**2 * others[1] - 2 * factor * others[0], axis=0, out=cost)
        cost += np.float32(2 * OTHER * off**2)
        np.minimum(cost, factor**2 * model[1] - 2 * factor * model[0], out=cost)
        cost += squares
    return np.minimum(out / np.float32(2 * off**2), np.float32(NONE))


def choose(costs: Singles, lights: Floats, change: Singles, covered: Bools, width_px: float) -> Singles:
    """Return the mean (H, W) of lights (n,), each by how likely what it costs (n, H, W) makes it in a neighbourhood.

    Lights are logarithms over what differs by `change` (H, W) from their mean over a texel.
    """
    inside = covered.astype(np.float32)
    mass = np.maximum(gaussian(inside, width_px), 1e-3)
    total = np.stack([SPEAK * gaussian(cost * inside, width_px) / mass for cost in costs])
    total += (change + lights[:, None, None].astype(np.float32)) ** 2 / (2 * SPREAD**2)
    share = np.exp(total.min(0) - total)
    mean = np.tensordot(lights.astype(np.float32), share, (0, 0)) / share.sum(0)
    smooth = gaussian(mean * inside, width_px / 2) / np.maximum(gaussian(inside, width_px / 2), 1e-3)
    return np.asarray(smooth, np.float32)


def mean_light(photo: Floats | Singles, covered: Bools, texel: Texel, basis: Floats) -> Singles:
    """Return the light (H, W) in which the texel has the brightness that the photo (H, W, 3) has around each pixel.

    It is the light whatever lies where. Only `covered` pixels (H, W) count; `basis` (2, 2) is pixels of undeformed
    cloth a texel.
    """
    width = WHOLE * float(np.linalg.norm(basis, axis=0).max())
    mass = np.maximum(gaussian(covered.astype(np.float32), width), 1e-3)
    seen = gaussian(photo.mean(-1) * covered, width) / mass
    return np.asarray(seen / max(float(texel.pixels.mean()), 1e-3), np.float32)
