"""The grain of the cloth in the detail, without the errors that the model makes at the places of its texel.

At each place of the texel the fine part of the detail has the grain of the cloth, whose covariance of the channels is
the same everywhere, and errors that come with the place: at the edges of motifs, where colours change most. With C the
covariance that shows at a place over all texels, and U that where it is least, the grain is (Wiener)

    U C⁻¹ · fine.
"""

from dataclasses import dataclass

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.filters.bands import bands
from core.overlay.filters.smoothing import gaussian, mean
from core.overlay.texel import Texel, draw_sample, gather, splat
from core.overlay.tolerances import DRAWN, MOTIF_PX, NEARBY_PX, SMOOTH_PX

USUAL = 0.3
"""Share of the cloth on which the fine part is no stronger than usual."""
ODD = 4.0
"""Times the usual variance from which the coarse part is taken from elsewhere."""
LEAST_VARIANCE = 1e-8
SLACK = 0.5
"""Variance over the usual one that is chance."""
TINT = 0.1
"""Strength of a colour that is half believed to be of a thing on the cloth."""
ROW, COLUMN = np.triu_indices(3)
"""Of the products of two channels that differ."""


@dataclass(frozen=True)
class Grain:
    """How strong the fine part of the detail is at the places of a texel, and what of it is grain."""

    usual: Singles
    """(3,), the variance of each channel where it is least."""
    excess: Texel
    """Variance over that."""
    rows: tuple[Texel, Texel, Texel]
    """Rows of the matrix that leaves the grain."""

    def within(self, fine: Singles, at: Floats) -> Singles:
        """Return the grain in the fine part (H, W, 3) of the detail at coordinates (H, W, 2)."""
        kept = [np.einsum("...c,...c", row(at).astype(np.float32), fine) for row in self.rows]
        return np.asarray(np.stack(kept, -1), np.float32)


def grain_of(detail: Singles, uv: Singles, clear: Bools, shape: tuple[int, int], basis: Floats) -> Grain:
    """Return the grain of the detail (H, W, 3) at coordinates (H, W, 2), over a texel of `shape` (h, w).

    Pixels that are not `clear` (H, W) do not count; `basis` (2, 2) is pixels of undeformed cloth a texel.
    """
    drawn = draw_sample(clear, DRAWN)
    places, fine = uv[drawn].astype(np.float64), fine_at(detail, clear, drawn)
    # A stain or a fold is not the pattern's.
    fine = np.clip(fine, *np.percentile(np.abs(fine), 98.5, axis=0) * [[-1], [1]])
    even, index = np.ones(len(places)), splat(places, shape)
    products = fine[:, ROW] * fine[:, COLUMN]
    planes = Texel(gather(*index, products, even, even, shape)).blurred(SMOOTH_PX, basis).pixels
    variance = Texel(np.maximum(planes[..., ROW == COLUMN], LEAST_VARIANCE))
    size = variance.at(places).sum(-1)
    least = size <= np.percentile(size, 100 * USUAL)
    usual = products[least].mean(0) * size[least].max() / max(float(size[least].mean()), 1e-12)
    own = np.maximum(usual[ROW == COLUMN], LEAST_VARIANCE)
    usual[ROW == COLUMN] = own
    matrices = wiener(symmetric(usual), symmetric(planes))
    rows = (Texel(matrices[..., 0, :]), Texel(matrices[..., 1, :]), Texel(matrices[..., 2, :]))
    return Grain(own.astype(np.float32), Texel(variance.pixels / own), rows)


def fine_at(detail: Singles, clear: Bools, drawn: Bools) -> Floats:
    """Return the fine part (n, 3) of the detail (H, W, 3) at the pixels drawn (H, W)."""
    fine: list[Singles] = []
    for first, top, bottom, last in bands(detail.shape, margin=int(3 * NEARBY_PX)):
        part, own = slice(first, last), slice(top - first, bottom - first)
        coarse = mean(detail[part], clear[part].astype(np.float32)[..., None], NEARBY_PX)
        fine.append((detail[part] - coarse)[own][drawn[top:bottom]])
    return np.concatenate(fine).astype(np.float64)


def symmetric(products: Floats) -> Floats:
    """Return the matrices (..., 3, 3) of products (..., 6) of the channels by `ROW` and `COLUMN`."""
    out = np.empty((*products.shape[:-1], 3, 3))
    out[..., ROW, COLUMN] = out[..., COLUMN, ROW] = products
    return out


def wiener(grain: Floats, seen: Floats) -> Floats:
    """Return U C⁻¹ (..., 3, 3) for the covariance U (3, 3) of the grain and C (..., 3, 3) of all that is seen.

    With C = U + errors as U¹ᐟ² W U¹ᐟ² that is U¹ᐟ² W⁻¹ U⁻¹ᐟ², and no eigenvalue of W is less than one.
    """
    sizes, axes = np.linalg.eigh(grain + LEAST_VARIANCE * np.eye(3))
    root, inverse = (axes * sizes**power @ axes.T for power in (0.5, -0.5))
    sizes, axes = np.linalg.eigh(inverse @ seen @ inverse)
    kept = np.einsum("...ik,...k,...jk->...ij", axes, 1 / np.maximum(sizes - SLACK, 1), axes)
    return np.asarray(root @ kept @ inverse, np.float64)


def even_out(detail: Singles, uv: Singles, covered: Bools, grain: Grain) -> Singles:
    """Return the detail (H, W, 3) with the grain alone in its fine part; there is none where it is not `covered`."""
    inside, at = covered.astype(np.float32)[..., None], np.nan_to_num(uv).astype(np.float64)
    excess = grain.excess(at).astype(np.float32)
    fine = detail - mean(detail, inside, NEARBY_PX)
    here = gaussian(fine**2 * inside, MOTIF_PX) / grain.usual
    weight = inside * np.minimum(1, 1 / excess) * np.minimum(1, ODD / np.maximum(here, 1e-9))
    coarse = mean(detail, weight, NEARBY_PX)
    fine = inside * (detail - coarse)
    here = gaussian(fine**2, MOTIF_PX) / grain.usual
    # Where a place has errors, and more of them here than over all texels.
    more = np.clip(excess / 2 - 1, 0, 1) * here / np.maximum(excess, 1)
    fine = np.asarray(fine / np.sqrt(np.maximum(more, 1)), np.float32)
    return np.asarray(without_tint(coarse) + grain.within(fine, at), np.float32)


def without_tint(coarse: Singles) -> Singles:
    """Return the coarse part (H, W, 3) of the detail without its faint colours: light on folds has none."""
    grey = coarse.mean(-1, keepdims=True)
    colour = coarse - grey
    strength = np.einsum("...c,...c", colour, colour)[..., None] / TINT**2
    return np.asarray(grey + colour * strength**2 / (1 + strength**2), np.float32)
