"""A decomposed photo as a picture with a new texture, at the photo's own depth."""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.imaging import color
from core.imaging.image import Image
from core.overlay.composition import Norm, Placement, compose_prepared, fit_samples, light_of, middle_of, premultiply
from core.overlay.detail.bare_layers import find_bare_layers
from core.overlay.filters.bands import in_bands
from core.overlay.texel import Texel


@dataclass(frozen=True)
class Parts:
    """What laying a new texture needs of a decomposition."""

    source: Image
    uv: Singles
    shading: Singles
    detail: Singles
    coverage: Singles
    basis: Floats
    texel: Floats
    """(h, w, 3), the old pattern."""
    about: Floats | None = None
    """(2,), texels, what a texture is turned and scaled about; None for the middle of the cloth."""

    @property
    def middle(self) -> Floats:
        """What a texture is turned and scaled about (2,), texels."""
        return middle_of(self.uv) if self.about is None else self.about

    @property
    def norm(self) -> Norm:
        """What placement and light are relative to."""
        return Norm(self.basis, self.middle, light_of(self.shading))

    def rows(self, first: int, last: int) -> tuple[Floats, Floats, Floats, Floats]:
        """Return uv, shading, detail and coverage of the rows from `first` up to `last`."""
        layers = (self.uv, self.shading, self.detail, self.coverage)
        uv, shading, detail, coverage = (layer[first:last].astype(np.float64) for layer in layers)
        return uv, shading, detail, coverage

    def under(self, texture: Floats, placement: Placement) -> "Parts":
        """Return the parts that go with a texture: free of the old pattern unless that is laid again."""
        if placement == Placement() and np.array_equal(texture, self.texel):
            return self
        shading, detail = find_bare_layers(self.detail, self.uv, self.shading, Texel(self.texel), self.basis)
        return replace(self, shading=shading, detail=detail)


class Layered(Protocol):
    """What is laid on: a picture, and layers of it by rows."""

    @property
    def source(self) -> Image:
        """The photo."""

    @property
    def norm(self) -> Norm:
        """What placement and light are relative to."""

    def rows(self, first: int, last: int) -> tuple[Floats, Floats, Floats, Floats]:
        """Return uv, shading, detail and coverage of the rows from `first` up to `last`."""


def lay_over(parts: Layered, texture: Floats, placement: Placement, *, alpha: float, strength: float) -> Image:
    """Return the photo with `texture` (h, w, 3 or 4), encoded, 0 to 1, in its folds: grey where both are."""
    norm = parts.norm
    photo = parts.source if is_grey(texture) else colour(parts.source)
    out, source = np.empty_like(photo.pixels), fit_samples(premultiply(texture), placement, norm.scale)

    def lay_rows(first: int, top: int, bottom: int, last: int) -> None:
        own = slice(top - first, bottom - first)
        uv, shading, detail, coverage = parts.rows(first, last)
        new, opacity = compose_prepared(source, (uv, shading, detail), norm, placement, alpha=alpha, strength=strength)
        band = photo.with_pixels(photo.pixels[top:bottom])
        share = (opacity * coverage)[own, :, None]
        colours = share * new[own] + (1 - share) * encode(band)
        out[top:bottom] = in_place_of(band, colours, share > 0).pixels

    in_bands(lay_rows, out.shape, margin=1)
    return photo.with_pixels(out)


def is_grey(texture: Floats) -> bool:
    """Return whether the three colours of a texture (h, w, 3 or 4) are the same everywhere."""
    return bool((texture[..., :3] == texture[..., :1]).all())


def colour(image: Image) -> Image:
    """Return a picture with three channels of colour; a grey one loses its profile, which is of grey alone."""
    if image.channels > 2:
        return image
    channels = [0, 0, 0] + [1] * image.has_alpha
    return replace(image, pixels=np.ascontiguousarray(image.pixels[..., channels]), icc=None)


def in_place_of(source: Image, colours: Floats, changed: Bools) -> Image:
    """Return `source` with other colours (H, W, 3), on the encoded 0 to 1 scale, where `changed` (H, W, 1)."""
    old = source.pixels[..., : color.color_channels(source.channels)]
    values = colours[..., : old.shape[-1]].astype(np.float32)
    new = color.quantise(color.decode(values) if source.linear else values, source.pixels.dtype)
    pixels = np.where(changed, new, old)
    if source.has_alpha:
        pixels = np.concatenate([pixels, source.pixels[..., -1:]], -1)
    return source.with_pixels(np.ascontiguousarray(pixels))


def encode(image: Image) -> Singles:
    """Return a picture's colours (H, W, 3) on the 0 to 1 scale of an encoded picture, alpha left out."""
    colours = color.unit(image.pixels)[..., : color.color_channels(image.channels)]
    if image.linear:
        colours = color.encode(colours)
    return np.ascontiguousarray(np.broadcast_to(colours, (*colours.shape[:2], 3)))


def texture_colours(image: Image) -> Floats:
    """Return a picture as a texture: (H, W, 3), or (H, W, 4) with alpha, encoded, 0 to 1."""
    return single_colours(image).astype(np.float64)


def single_colours(image: Image) -> Singles:
    """Return what `texture_colours` does, in single precision."""
    colours = encode(image)
    return np.concatenate([colours, color.unit(image.pixels[..., -1:])], -1) if image.has_alpha else colours


def searchable(image: Image, region: Bools | Singles | None) -> Bools | Singles | None:
    """Return the `region` (H, W), opacities from 0 to 1, without what is transparent; None for the whole picture."""
    if not image.has_alpha:
        return region
    opaque = np.asarray(image.pixels[..., -1] > 0.5 * (1 if image.linear else np.iinfo(image.pixels.dtype).max))
    if region is None:
        return None if opaque.all() else opaque
    return np.asarray(region * opaque.astype(np.float32), np.float32)
