"""Pixels of a picture as texels: linear light, premultiplied, in parts that are small enough to work on."""

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from core.arrays import Bytes, Pixels, Singles
from core.imaging import color
from core.imaging.images import Image
from core.rasters.raster import Box


def texels_of(image: Image, box: Box) -> Singles:
    """Return the premultiplied linear light of `box`, the picture's border repeated outwards: (h, w, 4)."""
    return light_of(image, _pixels_of(image, box))


def bytes_of(image: Image, box: Box) -> Bytes:
    """Return `box` of an 8-bit picture as RGBA, encoded and straight, the border repeated outwards: (h, w, 4)."""
    pixels = _pixels_of(image, box)
    if pixels.shape[2] in (1, 3):
        return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_GRAY2RGBA if pixels.shape[2] == 1 else cv2.COLOR_RGB2RGBA))
    return np.ascontiguousarray(pixels if pixels.shape[2] == 4 else pixels[..., [0, 0, 0, 1]])


def _pixels_of(image: Image, box: Box) -> Pixels:
    left, top, right, bottom = box
    rows = slice(min(top, image.height_px - 1), min(bottom, image.height_px))
    columns = slice(min(left, image.width_px - 1), min(right, image.width_px))
    pixels = image.pixels[rows, columns]
    below, beside = bottom - top - pixels.shape[0], right - left - pixels.shape[1]
    if below or beside:
        wider = cv2.copyMakeBorder(pixels, 0, below, 0, beside, cv2.BORDER_REPLICATE)
        pixels = wider.reshape(bottom - top, right - left, pixels.shape[2])
    return pixels


def light_of(image: Image, pixels: Pixels) -> Singles:
    """Return `pixels` of `image` as premultiplied linear light, (h, w, 4)."""
    if pixels.dtype == np.uint8 and pixels.shape[2] == 3 and not image.linear:
        # What most pictures are, several times as fast.
        return np.asarray(cv2.LUT(cv2.cvtColor(pixels, cv2.COLOR_RGB2RGBA), _light_of_bytes()), np.float32)
    light = color.premultiply(color.linear_light(pixels, linear=image.linear))
    colors = color.color_channels(light.shape[2])
    texels = np.empty((*light.shape[:2], 4), np.float32)
    texels[..., :3] = light[..., :colors]
    texels[..., 3] = light[..., -1] if light.shape[2] > colors else 1
    return texels


@cache
def _light_of_bytes() -> Singles:
    """Return the light of every value of red, green and blue, and the opacity of alpha: (1, 256, 4)."""
    light = np.asarray(color.decode_table(256), np.float32)
    return np.stack([light, light, light, np.linspace(0, 1, 256, dtype=np.float32)], axis=-1)[None]


def halves(texels: Singles) -> NDArray[np.float16]:
    """Return `texels`, (h, w, 4), in half precision: OpenCV converts six times as fast as NumPy."""
    return np.asarray(cv2.subtract(texels, np.zeros(4), dtype=cv2.CV_16F), np.float16)


def reduce(texels: Singles, block: int) -> Singles:
    """Return the means of blocks of `block` x `block` texels."""
    if block == 1:
        return texels
    size = (texels.shape[1] // block, texels.shape[0] // block)
    return np.asarray(cv2.resize(texels, size, interpolation=cv2.INTER_AREA), np.float32)
