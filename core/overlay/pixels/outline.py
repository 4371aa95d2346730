"""The outline of the cloth, to the pixel.

What the registered texture explains is judged over neighbourhoods, an object is cut out by what its ground looks like
anywhere, and a region is painted by hand: all of them end a few pixels beside the cloth. There a pixel belongs to the
cloth if the photo is rather a shade of one of the pattern's colours than of what surrounds the cloth nearby, by the
likelihood of both:

    min |I - s ρ c|² / 2 σ² + 3 log σ  <  |I - s μ|² / 2 τ² + 3 log τ,

with ρ as it is further inside, s the best of a few shades, c the pattern's colours, μ the mean of the surroundings, and
σ and τ the usual errors of both. Where the colours are the same that tells little: the outline is the cheapest one,
along edges in the photo.
"""

import cv2
import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.filters.distances import distance, within
from core.overlay.filters.smoothing import gaussian
from core.overlay.palette import GROUPS, from_shades, palette
from core.overlay.pixels.filling import parts_with
from core.overlay.pixels.graph_cut import EVIDENCE, MOST, SURELY, cut_out
from core.overlay.texel import Texel
from core.overlay.tolerances import RIM_PX, SHADES

REACH = 2.0
"""Width of the band beyond what is covered in which cloth is looked for, over that of the neighbourhood."""
PRIOR = 2.0
"""What speaks for cloth where it is covered, and against it beyond, as a natural logarithm."""
LEAST_SPREAD = 0.02
"""Least error of a colour."""


def reach(covered: Bools, width_px: float) -> Bools:
    """Return the pixels (H, W) beside those that are covered in which the outline of the cloth may be."""
    return within(covered, REACH * width_px) & ~covered


def find_outline(
    photo: Floats | Singles, texel: Texel, rho: Floats | Singles, covered: Bools, further: Bools, width_px: float
) -> Bools:
    """Return which covered and further pixels (H, W) show the cloth, up to its outline.

    `photo` is (H, W, 3), `rho` (H, W) the light where it is covered. At most `width_px` are taken off what is covered;
    that is also the width of the neighbourhood that tells the light and the surroundings of a pixel.
    """
    whole, core = covered | further, covered & (distance(~covered) > width_px)
    around = ~whole & (distance(whole) > RIM_PX)
    band = whole & ~core
    for sides in (core, around):
        band &= within(sides, (REACH + 1.5) * width_px)
    if not band.any():
        return covered
    photo = np.asarray(photo, np.float32)
    speaks = np.where(covered, -MOST, MOST)
    light = nearby(rho, core, width_px)[..., None]
    unlike = misfit(photo, [light * colour for colour in palette(texel, GROUPS)], core, width_px)
    other = misfit(photo, [nearby(photo, around, width_px)], around, width_px)
    odds = (unlike - other)[band] + np.where(covered[band], -PRIOR, PRIOR)
    speaks[band] = EVIDENCE * np.clip(odds, -SURELY, SURELY)
    outside = from_outside(cut_out(photo, covered, speaks) & whole, whole)
    # What is cut off from the cloth is none of it.
    return parts_with(covered & ~outside, whole & ~outside)


def misfit(photo: Singles, colours: list[Singles], where: Bools, width_px: float) -> Singles:
    """Return how unlikely (H, W), as a logarithm, pixels are a shade of one of the colours, each (H, W, 3).

    What is usual `where` (H, W) something surely is a shade of them tells, within `width_px`.
    """
    off = np.min([from_shades(photo, colour, SHADES) ** 2 for colour in colours], axis=0)
    # Shades leave two of three channels.
    variance = nearby(off, where, width_px) / 2 + LEAST_SPREAD**2
    return np.asarray(off / (2 * variance) + 1.5 * np.log(variance), np.float32)


def from_outside(candidates: Bools, covered: Bools) -> Bools:
    """Return the candidates (H, W) that are connected with what is not covered."""
    _, labels = cv2.connectedComponents((candidates | ~covered).astype(np.uint8), connectivity=4)
    return np.asarray(candidates & np.isin(labels, np.unique(labels[~covered])), np.bool_)


def nearby(values: Floats | Singles, where: Bools, sigma_px: float) -> Singles:
    """Return the mean of values (H, W) or (H, W, C) over the marked pixels of a neighbourhood."""
    weight = where.astype(np.float32)
    spread = weight if values.ndim == 2 else weight[..., None]
    sums = gaussian(np.where(spread > 0, values.astype(np.float32), np.float32(0)), sigma_px)
    mass = gaussian(weight, sigma_px)
    return np.asarray(sums / np.maximum(mass if values.ndim == 2 else mass[..., None], 1e-9), np.float32)
