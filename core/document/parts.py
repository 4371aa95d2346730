"""The parts of a decomposed photo as pictures, to look at and to export."""

from typing import Literal, TypeAlias

import cv2
import numpy as np

from core.arrays import Floats
from core.document.overlay_layers import OverlayLayers
from core.imaging import color
from core.imaging.image import Image
from core.overlay.filters.texture_filter import filter_texture
from core.overlay.laying.compositing import encode
from core.overlay.storage.pictures import coordinate_lines

Part: TypeAlias = Literal["pattern", "mesh", "shading", "detail", "reconstruction", "residual"]
Bits: TypeAlias = Literal[8, 16, 32]
RESIDUAL_GAIN = 4.0
"""The residual is shown so many times as strong."""


def values_of(layers: OverlayLayers, photo: Image, part: Part) -> Floats:
    """Return a part (H, W, 3) on the encoded 0 to 1 scale of the photo; 0 where there is no cloth.

    The detail has both signs, the shading is a factor about 1: see `picture_of` for what is shown of them.
    """
    size = layers.uv.shape[:2]
    if part == "pattern":
        y, x = np.indices(size).astype(float)
        return filter_texture(layers.texel, np.stack([x, y], -1) @ np.linalg.inv(layers.basis).T)
    if part == "mesh":
        lines = coordinate_lines(encode(photo).astype(np.float64), layers.uv.astype(np.float64))
        return np.asarray(cv2.resize(lines, size[::-1], interpolation=cv2.INTER_AREA) / 255, np.float64)
    detail = np.nan_to_num(layers.detail.astype(np.float64))
    if part == "shading":
        light = np.nan_to_num(layers.shading.astype(np.float64))
        return np.ascontiguousarray(np.broadcast_to(light if light.ndim == 3 else light[..., None], (*size, 3)))
    if part == "detail":
        return detail
    if part == "residual":
        return np.abs(detail)
    return np.where(layers.covered[..., None], encode(photo) - detail, 0.0)


def picture_of(layers: OverlayLayers, photo: Image, part: Part, *, bits: Bits = 8) -> Image:
    """Return a part as a picture of so many bits a sample; with 32 its values as they are.

    With fewer bits the median shading and no detail are middle grey, and the residual is amplified.
    """
    values = values_of(layers, photo, part)
    if bits == 32:
        return Image(values.astype(np.float32), linear=True)
    if part == "shading":
        values = values * (0.5 / max(layers.usual_light, 1e-6))
    elif part == "detail":
        values = values + 0.5
    elif part == "residual":
        values = values * RESIDUAL_GAIN
    return Image(color.quantise(values.astype(np.float32), np.uint8 if bits == 8 else np.uint16))
