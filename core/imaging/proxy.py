"""The picture as tools that look at it see it: encoded 8-bit colour, made smaller where it is large."""

import cv2
import numpy as np

from core.arrays import Bytes
from core.imaging import color
from core.imaging.image import Image


def proxy(image: Image, scale: float) -> Bytes:
    """Return encoded colours (h, w, 3) of the picture at `scale`, 1 at most; what is transparent before grey."""
    pixels = image.pixels
    if scale < 1:
        size = max(1, round(image.width_px * scale)), max(1, round(image.height_px * scale))
        pixels = np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)).reshape(size[1], size[0], -1)
    if pixels.dtype == np.uint8 and pixels.shape[2] == 3 and not image.linear:
        return np.ascontiguousarray(pixels)
    light = color.unit(pixels)
    split = color.color_channels(light.shape[2])
    colours = color.encode(light[..., :split]) if image.linear else light[..., :split]
    if split < light.shape[2]:
        colours = colours * light[..., split:] + np.float32(0.5) * (1 - light[..., split:])
    values = np.ascontiguousarray(np.broadcast_to(colours, (*light.shape[:2], 3)), np.float32)
    return np.asarray(color.quantise(np.clip(values, 0, 1), np.uint8), np.uint8)


def scale_for(image: Image, pixels: int) -> float:
    """Return the scale, 1 at most, at which a picture has about so many pixels."""
    return min(1.0, float(np.sqrt(pixels / (image.width_px * image.height_px))))
