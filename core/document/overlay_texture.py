"""From a document to its photo with a new texture in the folds of the layers that were found (`overlay`)."""

from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from core.document.document import Document
from core.document.overlay import find_layers
from core.document.overlay_layers import OverlayLayers
from core.document.overlay_settings import Cloth, Laying
from core.imaging import color
from core.imaging.image import Image
from core.overlay.composition import Placement
from core.overlay.laying.compositing import Parts, lay_over, texture_colours
from core.overlay.laying.enlarging import EnlargedParts
from core.progress import Job, part
from core.rasters.raster import Raster

LAYING = 0.95
"""Share of an export's work that finding the pattern takes."""
_PROTECTED: "WeakKeyDictionary[OverlayLayers, tuple[Raster, OverlayLayers]]" = WeakKeyDictionary()
"""Layers without what was protected last."""


def size_of(layers: OverlayLayers, laying: Laying) -> float:
    """Return the width of a copy in texels."""
    return layers.usual_size if laying.size is None else laying.size


def placement_of(layers: OverlayLayers, texture: Image | None, laying: Laying) -> Placement:
    """Return how the texture lies, for the engine; the pattern that was found lies where it was."""
    if texture is None:
        return Placement()
    across, down = np.linalg.norm(layers.basis, axis=0)
    shape = texture.width_px / texture.height_px
    size = size_of(layers, laying)
    repeat = 1 / size, float(shape * down / (laying.stretch * size * across))
    return Placement(
        repeat, laying.rotate_deg, laying.offset, mirror=laying.mirror, tile=laying.tile, upright=laying.upright
    )


def is_changed(cloth: Cloth) -> bool:
    """Return whether what is laid on the cloth, and how, makes the photo look different."""
    return cloth.texture is not None or (cloth.laying.detail, cloth.laying.shading) != (1.0, 1.0)


def pattern_of(cloth: Cloth, layers: OverlayLayers) -> Image:
    """Return what is laid on the cloth: the new texture, or the pattern that was found."""
    return layers.pattern if cloth.texture is None else cloth.texture


def layers_under(cloth: Cloth, layers: OverlayLayers) -> OverlayLayers:
    """Return the layers that go with what is laid on the cloth, without what is protected."""
    worn = layers if cloth.texture is None else layers.bare
    if cloth.protected is None or cloth.protected.is_empty:
        return worn
    if worn not in _PROTECTED or _PROTECTED[worn][0] is not cloth.protected:
        share = (1 - color.unit(cloth.protected.array)).astype(np.float32)
        _PROTECTED[worn] = cloth.protected, replace(worn, coverage=worn.coverage * share)
    return _PROTECTED[worn][1]


def picture(document: Document, image: Image) -> Job[Image]:
    """Return `image`, the document's at any depth, with the texture in its folds; itself where none is chosen.

    Raises `InputError` where a texture is chosen, and no pattern is there to lay it in place of.
    """
    if not is_changed(document.cloth):
        return image
    layers = yield from part(find_layers(document), 0.0, LAYING)
    return lay_on(image, layers, document.cloth)


def lay_on(image: Image, layers: OverlayLayers, cloth: Cloth) -> Image:
    """Return `image`, the photo at its own size or at a larger one, with the texture in its folds."""
    if not is_changed(cloth):
        return image
    worn, laying = layers_under(cloth, layers), cloth.laying
    parts = Parts(image, worn.uv, worn.shading, worn.detail, worn.coverage, worn.basis, worn.texel, worn.middle)
    is_larger = image.size_px != worn.uv.shape[1::-1]
    return lay_over(
        EnlargedParts(parts, image) if is_larger else parts,
        texture_colours(pattern_of(cloth, layers)),
        placement_of(layers, cloth.texture, laying),
        alpha=laying.detail,
        strength=laying.shading,
    )
