"""Laying a texture into the cloth: I' = Wp T'(Wg) + α HF (NRT sec. 3.3), filtered where the folds shrink it.

A texture finer than `DENSITY` samples a pixel of the undeformed cloth is first resampled to that, as the mean texel is.
So laying the mean texel on its own cloth gives the reconstruction, to the bit.
"""

import math
from dataclasses import dataclass
from typing import TypeVar

import cv2
import numpy as np

from core.arrays import Bools, Floats, InputError, Singles
from core.overlay.filters.texture_filter import DENSITY, filter_texture

F = TypeVar("F", Floats, Singles)

WHOLE = 1.15
"""Times too many samples under which a texture stays as it is: the sides of a mean texel are rounded."""
TELLING = 1 << 18
"""So many pixels tell a median well enough."""
DIAGONAL_DEG = 15.0
"""By so much more must the sides of a texel lean than its diagonals for rows to go along those."""


MOST = 1_000_000
"""No number of a placement is larger, no repeat smaller than one over it."""


@dataclass(frozen=True)
class Placement:
    """How a texture lies on the cloth."""

    repeat: tuple[float, float] = (1.0, 1.0)
    """Copies to a texel, across and down; 0.2 lays one copy over five texels."""
    rotate_deg: float = 0.0
    """Clockwise, in the plane of the undeformed cloth."""
    offset: tuple[float, float] = (0.0, 0.0)
    """By how many copies the texture is moved."""
    mirror: bool = False
    """Whether every second copy is mirrored, so that any picture joins without an edge."""
    tile: bool = True
    """Whether the texture repeats; otherwise one copy, its middle on the middle of the cloth."""
    upright: bool = False
    """Whether a copy is a rectangle that stands on the cloth's rows; otherwise it has the shape of a texel.

    A texel whose sides are not at right angles leans, and so would a picture in its shape.
    """

    def __post_init__(self) -> None:
        values = (*self.repeat, self.rotate_deg, *self.offset)
        if not all(abs(value) <= MOST for value in values) or min(abs(r) for r in self.repeat) < 1 / MOST:
            raise InputError(f"placement: repeat must not be 0, and no value beyond {MOST}")

    def matrix(self, scale: Floats) -> Floats:
        """Return the matrix (2, 2) that takes texels to copies; `scale` (2, 2) is pixels a texel."""
        angle = np.radians(self.rotate_deg + (rows_deg(scale) if self.upright else 0.0))
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        texels = np.diag(1 / np.linalg.norm(scale, axis=0)) if self.upright else np.linalg.inv(scale)
        return np.asarray(np.diag(self.repeat) @ texels @ turn @ scale, np.float64)

    def affine(self, scale: Floats, middle: Floats) -> tuple[Floats, Floats]:
        """Return M (2, 2) and c (2,): what is at uv, in texels, is at M uv + c, in copies of the texture.

        `middle` (2,) is the middle of the cloth in texels. The texture is turned and scaled about it; whole copies
        there keep repeat 1 in step with the texels.
        """
        matrix, offset = self.matrix(scale), np.array(self.offset)
        if not self.tile:
            return matrix, np.asarray(0.5 - offset - matrix @ middle)
        pivot = np.rint(middle)
        return matrix, np.asarray(pivot - offset - matrix @ pivot)

    def __call__(self, uv: Floats, scale: Floats, middle: Floats) -> Floats:
        """Return places (..., 2) in copies of the texture."""
        matrix, shift = self.affine(scale, middle)
        return np.asarray(uv @ matrix.T + shift, np.float64)


@dataclass(frozen=True)
class Norm:
    """What placement and light are relative to."""

    scale: Floats
    """(2, 2), pixels of undeformed cloth a texel."""
    middle: Floats
    """(2,), the middle of the cloth, texels."""
    light: float
    """The usual shading."""

    @classmethod
    def of(cls, uv: Floats | Singles, shading: Floats | Singles, scale: Floats) -> "Norm":
        """Return the norm of a whole cloth."""
        return cls(scale, middle_of(uv), light_of(shading))


def compose(
    texture: Floats,
    uv: Floats,
    shading: Floats,
    detail: Floats,
    scale: Floats,
    *,
    placement: Placement | None = None,
    alpha: float = 1.0,
    strength: float = 1.0,
) -> tuple[Floats, Floats]:
    """Return a texture (h, w, 3 or 4), 0 to 1, on the cloth, and its opacity (H, W)  [NRT eq. 1].

    The picture (H, W, 3) is Wp T'(Wg) + α HF.

    `uv` (H, W, 2), `shading` (H, W) or (H, W, 3) and `detail` (H, W, 3) are NaN outside, where the opacity is 0.
    """
    norm = Norm.of(uv, shading, scale)
    return compose_layers(
        texture, (uv, shading, detail), norm, placement or Placement(), alpha=alpha, strength=strength
    )


def compose_layers(
    texture: Floats,
    layers: tuple[Floats, Floats, Floats],
    norm: Norm,
    placement: Placement,
    *,
    alpha: float,
    strength: float,
) -> tuple[Floats, Floats]:
    """Return what `compose` does for a part of a cloth of that norm; the layers are uv, shading and detail."""
    source = fit_samples(premultiply(texture), placement, norm.scale)
    return compose_prepared(source, layers, norm, placement, alpha=alpha, strength=strength)


def compose_prepared(
    source: Floats,
    layers: tuple[Floats, Floats, Floats],
    norm: Norm,
    placement: Placement,
    *,
    alpha: float,
    strength: float,
) -> tuple[Floats, Floats]:
    """Return what `compose_layers` does with a texture (h, w, 4) that is prepared for the placement."""
    uv, shading, detail = layers
    covered = finite(uv)
    light = relight(shading, strength, norm.light)
    colours = lay(source, placement, uv, norm, covered)
    wp = np.nan_to_num(light if light.ndim == 3 else light[..., None])
    return wp * colours[..., :3] + alpha * np.nan_to_num(detail), colours[..., 3] * covered


def premultiply(texture: F) -> F:
    """Return a texture (h, w, 3 or 4) with an alpha channel, premultiplied by it: (h, w, 4)."""
    alpha = texture[..., 3:] if texture.shape[-1] == 4 else np.ones_like(texture[..., :1])
    return np.concatenate([texture[..., :3] * alpha, alpha], -1)


def differ(layer: Singles, other: Singles) -> Bools:
    """Return where (H, W) two layers (H, W) or (H, W, C), NaN outside the cloth, are not the same."""
    if layer is other:
        return np.zeros(layer.shape[:2], np.bool_)
    off = (layer != other) & ~(np.isnan(layer) & np.isnan(other))
    return np.asarray(off if off.ndim == 2 else off.any(-1), np.bool_)


def middle_of(uv: Floats | Singles) -> Floats:
    """Return the middle (2,) of the cloth, in texels."""
    uv = _some(uv)
    covered = finite(uv)
    return np.asarray(np.median(uv[covered], axis=0) if covered.any() else np.zeros(2), np.float64)


def light_of(shading: Floats | Singles) -> float:
    """Return the median shading of the cloth."""
    shading = _some(shading)
    return float(np.nanmedian(shading)) if np.isfinite(shading).any() else 1.0


def _some(layer: Floats | Singles) -> Floats | Singles:
    """Return every so manieth row and column of a layer (H, W, …): about `TELLING` pixels, where it has more."""
    step = max(1, round(math.sqrt(layer.shape[0] * layer.shape[1] / TELLING)))
    return layer[::step, ::step]


def relight(shading: Floats, strength: float, usual_light: float) -> Floats:
    """Return the shading with its contrast, in stops about the usual light, times `strength`."""
    return shading if strength == 1 else np.asarray(usual_light * (shading / usual_light) ** strength)


def lay(source: Floats, placement: Placement, uv: Floats, norm: Norm, covered: Bools) -> Floats:
    """Return the prepared texture (H, W, 4), premultiplied by its opacity, as the cloth shows it; 0 outside."""
    copies = placement(np.nan_to_num(uv), norm.scale, norm.middle)
    at = copies / 2 if placement.mirror else copies
    colours = filter_texture(source, np.where(covered[..., None], at, np.nan))
    if not placement.tile:
        inside = (copies.min(-1) >= 0) & (copies.max(-1) < 1)
        colours = np.where(inside[..., None], colours, 0.0)
    straight = colours[..., :3] / np.maximum(colours[..., 3:], 1e-6)
    return np.concatenate([straight, colours[..., 3:]], -1)


def fit_samples(texture: F, placement: Placement, scale: Floats) -> F:
    """Return a premultiplied texture (h, w, 4) with its mirror images if it has such, and no finer than needed."""
    size = count_samples((texture.shape[1], texture.shape[0]), placement, scale)
    if placement.mirror:
        texture = np.concatenate([texture, texture[:, ::-1]], 1)
        texture = np.concatenate([texture, texture[::-1]], 0)
    if size == (texture.shape[1], texture.shape[0]):
        return texture
    fewer = cv2.resize(texture, size, interpolation=cv2.INTER_AREA)
    return np.asarray(fewer, texture.dtype).reshape(size[1], size[0], -1)


def count_samples(size: tuple[int, int], placement: Placement, scale: Floats) -> tuple[int, int]:
    """Return how many columns and rows a texture of `size`, (w, h), is laid with, mirror images included."""
    steps = np.linalg.norm(scale @ np.linalg.inv(placement.matrix(scale)), axis=0) / np.array(size)
    excess = 1 / (DENSITY * steps)
    w, h = (side * (1 + placement.mirror) for side in size)
    if max(excess) < WHOLE:
        return w, h
    return max(1, round(w / max(1.0, excess[0]))), max(1, round(h / max(1.0, excess[1])))


def rows_deg(scale: Floats) -> float:
    """Return the angle of the cloth's rows, clockwise in degrees from -45 to 45; `scale` (2, 2) is pixels a texel.

    Rows go along the texel's sides or, where those lean and the diagonals do not, along its diagonals.
    """
    first, second = scale.T
    pairs = (0.0, (first, second)), (DIAGONAL_DEG, (first + second, second - first))
    ways: list[tuple[float, float]] = []
    for dearer, pair in pairs:
        one, other = (float(np.degrees(np.arctan2(side[1], side[0]))) for side in pair)
        skew = abs((other - one) % 180 - 90)
        ways += [(abs(from_upright(way)) + skew + dearer, from_upright(way)) for way in (one, other)]
    return min(ways)[1]


def from_upright(angle: float) -> float:
    """Return by how many degrees, -45 to 45, a line at `angle` degrees misses the nearer of upright and level."""
    return (angle + 45) % 90 - 45


def finite(at: Floats | Singles) -> Bools:
    """Return which places (H, W) of (H, W, 2) are not NaN."""
    return np.asarray(np.isfinite(at[..., 0]) & np.isfinite(at[..., 1]), np.bool_)


def difference(photo: Floats | Singles, modelled: Singles, inside: Bools) -> Singles:
    """Return the photo less the model (H, W, 3), NaN outside."""
    out: Singles = np.subtract(photo, modelled, dtype=np.float32, casting="same_kind")
    out[~inside] = np.nan
    return out
