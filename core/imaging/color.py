"""Encoded and linear light, straight and premultiplied alpha.

Whatever filters or mixes pixels does so in linear light with premultiplied alpha. The transfer function is that of
sRGB (IEC 61966-2-1), both pieces exactly:

    linear = s / 12.92 for s <= 0.04045, ((s + 0.055) / 1.055) ** 2.4 above.
"""

from collections.abc import Sequence
from functools import cache

import cv2
import numpy as np
from numpy.typing import DTypeLike

from core.arrays import Pixels, Singles, readonly


def decode(encoded: Singles) -> Singles:
    """Return the linear light of sRGB values on the 0 to 1 scale; below 0 the curve is mirrored."""
    size = np.abs(encoded)
    linear = np.where(size <= np.float32(0.04045), size / np.float32(12.92), _power(size))
    return np.copysign(linear, encoded).astype(np.float32, copy=False)


def encode(linear: Singles) -> Singles:
    """Return the sRGB values, on the 0 to 1 scale, of linear light; the inverse of `decode`."""
    size = np.abs(linear)
    root = np.float32(1.055) * size ** np.float32(1 / 2.4) - np.float32(0.055)
    encoded = np.where(size <= np.float32(0.0031308), size * np.float32(12.92), root)
    return np.copysign(encoded, linear).astype(np.float32, copy=False)


def _power(size: Singles) -> Singles:
    power: Singles = ((size + np.float32(0.055)) / np.float32(1.055)) ** np.float32(2.4)
    return power


@cache
def decode_table(levels: int) -> Singles:
    """Return the linear light of `levels` (256 or 65 536) evenly spaced sRGB values."""
    return readonly(decode(np.linspace(0, 1, levels).astype(np.float32)))


def unit(pixels: Pixels) -> Singles:
    """Return `pixels` of any depth as float32 on the 0 to 1 scale."""
    if pixels.dtype.kind == "f":
        return pixels.astype(np.float32, copy=False)
    scaled: Singles = pixels * np.float32(1 / np.iinfo(pixels.dtype).max)
    return scaled


def quantise(values: Singles, depth: DTypeLike) -> Pixels:
    """Return values on the 0 to 1 scale as pixels of `depth`, rounded and clipped; float stays as it is."""
    if np.dtype(depth).kind == "f":
        return values.astype(depth, copy=False)
    top = np.float32(np.iinfo(depth).max)
    return (np.clip(values, 0, 1) * top + np.float32(0.5)).astype(depth)


def linear_light(pixels: Pixels, *, linear: bool) -> Singles:
    """Return float32 linear light of (..., C) pixels; alpha, the last of 2 or 4 channels, is only rescaled.

    `linear` says that the colours are linear already, as those of a float image are.
    """
    if linear:
        return unit(pixels)
    colors = pixels[..., : color_channels(pixels.shape[-1])]
    light = decode(colors) if pixels.dtype.kind == "f" else decode_table(np.iinfo(pixels.dtype).max + 1)[colors]
    if light.shape[-1] == pixels.shape[-1]:
        return light
    return np.concatenate([light, unit(pixels[..., -1:])], axis=-1)


def store(light: Singles, *, depth: DTypeLike, linear: bool) -> Pixels:
    """Return (..., C) linear light as pixels of `depth`, encoded unless `linear`; the inverse of `linear_light`."""
    if linear:
        return quantise(light, depth)
    split = color_channels(light.shape[-1])
    colors = quantise(encode(light[..., :split]), depth)
    if split == light.shape[-1]:
        return colors
    return np.concatenate([colors, quantise(light[..., split:], depth)], axis=-1)


def color_channels(channels: int) -> int:
    """Return how many of `channels` carry colour: 1 of 1 or 2, 3 of 3 or 4."""
    return 1 if channels <= 2 else 3


def take_channels(pixels: Pixels, numbers: Sequence[int]) -> Pixels:
    """Return some channels of (h, w, C) pixels, a copy, many times as fast as an index."""
    if pixels.shape[2] == 4 and list(numbers) == [0, 1, 2]:
        return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGBA2RGB))
    taken = cv2.merge([cv2.extractChannel(pixels, number) for number in numbers])
    return np.asarray(taken).reshape(*pixels.shape[:2], len(numbers))


def premultiply(straight: Singles) -> Singles:
    """Return (..., C) with the colours multiplied by alpha; without an alpha channel nothing changes."""
    split = color_channels(straight.shape[-1])
    if split == straight.shape[-1]:
        return straight
    alpha = straight[..., split:]
    return np.concatenate([straight[..., :split] * alpha, alpha], axis=-1)


def unpremultiply(premultiplied: Singles) -> Singles:
    """Return (..., C) with the colours divided by alpha, 0 where alpha is not positive."""
    split = color_channels(premultiplied.shape[-1])
    if split == premultiplied.shape[-1]:
        return premultiplied
    alpha = premultiplied[..., split:]
    colors = np.divide(
        premultiplied[..., :split], alpha, out=np.zeros_like(premultiplied[..., :split]), where=alpha > 0
    )
    return np.concatenate([colors, alpha], axis=-1)


def over(straight: Singles, backdrop: float) -> Singles:
    """Return the colours of (..., C) linear light before an even `backdrop`; the alpha channel goes."""
    split = color_channels(straight.shape[-1])
    if split == straight.shape[-1]:
        return straight
    alpha = straight[..., split:]
    mixed: Singles = straight[..., :split] * alpha + np.float32(backdrop) * (1 - alpha)
    return mixed
