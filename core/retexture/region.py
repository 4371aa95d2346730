"""Where texture is regrown, and where the plain deformation stands."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter

from core.arrays import Bools, Bytes, Floats, Singles
from core.retexture.coordinates import CurveSet
from core.retexture.diffusion import Diffusion, distortion

CALM = 0.06
"""Where the deformation stretches by less than this (as a logarithm), near a curve, it stands."""
STRAINED = 0.3
"""Where it stretches by more, texture is regrown beyond the usual reach too."""
FARTHEST = 2.5
"""But no farther from a curve than this many reaches."""
TEXEL_PX, CONTRAST = 15, 0.02
"""There the colours vary by this much, of 1, within a window of this many pixels."""
RIM_PX = 12
"""Width of the rim in which the seam between both may run."""


@dataclass(frozen=True, eq=False)
class Region:
    """Masks over the picture (H, W)."""

    must: Bools
    """Texture is regrown here."""
    may: Bools
    """And may be here: the rim around it."""
    nearness: Singles
    """(H, W) 1 well inside, falling to 0 at the outer edge and far from the curves: how much of a place's source is
    found along the curve's own coordinates, the rest being found by the deformation."""


def region(
    grid: Diffusion,
    field: Floats,
    curves: CurveSet,
    shown: Singles,
    *,
    reach_px: float,
    matte: Bytes | None = None,
) -> Region:
    """Return where to regrow texture: near the target curves, as far as the deformation is not rigid.

    Farther off, too, where it stretches much and `shown` (H, W, c), the deformed picture, has a texture to show it.
    """
    strain = grid.at_pixels(gaussian_filter(distortion(grid, field), 6 / grid.step)[..., None])[..., 0]
    distance = _distance(curves, grid.shape)
    far = (distance < FARTHEST * reach_px) & (strain > STRAINED) & _textured(shown)
    must = (distance < reach_px) & (strain > CALM) | far
    must = _cleaned(must)
    may = cv2.dilate(must.astype(np.uint8), _disc(RIM_PX)) > 0
    if matte is not None:
        allowed = matte > 127
        may &= allowed
        must &= cv2.erode(allowed.astype(np.uint8), _disc(RIM_PX // 2), borderValue=1) > 0
    depth = cv2.distanceTransform(np.pad(may, 1, mode="edge").astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    # A region without an outer edge is infinitely deep.
    inner = smoothstep(((np.minimum(depth, 1e4) - RIM_PX / 2) / (0.4 * reach_px)).astype(np.float32))
    return Region(must, may, inner * (1 - smoothstep(distance / reach_px - 1)))


def smoothstep(x: Singles) -> Singles:
    """Return 0 up to x = 0, 1 from x = 1, and 3x^2 - 2x^3 between."""
    x = np.clip(x, 0, 1)
    return x * x * (3 - 2 * x)


def _distance(curves: CurveSet, shape: tuple[int, int]) -> Singles:
    """Return the distance of every pixel (H, W) to the nearest curve, to about a pixel."""
    far = np.ones(shape, np.uint8)
    for curve in curves.curves:
        line = np.rint(curve.at(curve.parameters(step=0.5))).astype(int)
        inside = ((line >= 0) & (line < [shape[1], shape[0]])).all(axis=1)
        far[line[inside, 1], line[inside, 0]] = 0
    return np.asarray(cv2.distanceTransform(far, cv2.DIST_L2, 5), np.float32)


def _textured(picture: Singles) -> Bools:
    """Return where the colours (H, W, c) vary visibly within a few pixels: Var = E[x^2] - E[x]^2."""
    side = (TEXEL_PX, TEXEL_PX)
    varies = np.zeros(picture.shape[:2], np.uint8)
    for i in range(picture.shape[2]):
        plane = picture[..., i]
        varies |= cv2.blur(plane * plane, side) - cv2.blur(plane, side) ** 2 > CONTRAST**2
    return cv2.dilate(varies, _disc(TEXEL_PX)) > 0


def _cleaned(mask: Bools) -> Bools:
    """Close gaps and drop specks narrower than a patch."""
    closed = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, _disc(8))
    return cv2.morphologyEx(closed, cv2.MORPH_OPEN, _disc(4)) > 0


def _disc(radius: int) -> Bytes:
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1)), np.uint8)
