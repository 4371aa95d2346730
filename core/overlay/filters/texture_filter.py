"""A repeating texture at places that lie closer together than its samples: anisotropic filtering.

The filter is that of a graphics card, so that a shader shows the same: a pyramid of halved textures, and several
samples along the direction that is shrunk most. It begins where the cloth holds more than `DENSITY` samples a pixel.
"""

from typing import TypeVar

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Singles
from core.overlay.filters.bands import in_bands
from core.overlay.filters.sampling import look_up

F = TypeVar("F", Floats, Singles)

DENSITY = 1.5
"""Texture samples to a pixel of undeformed cloth."""
TAPS = 8
"""Most samples along the direction that is shrunk most."""


def filter_texture(texture: Floats, at: Floats) -> Floats:
    """Return a repeating texture (h, w, C) at places (H, W, 2), in copies; NaN places give 0."""
    covered = np.isfinite(at[..., 0]) & np.isfinite(at[..., 1])
    along, length, width = footprints(at, covered, texture.shape[:2])
    level = np.log2(np.maximum(np.maximum(width, length / TAPS), 1))
    taps = np.clip(np.ceil(length), 1, TAPS)
    levels = pyramid(texture, int(np.ceil(level.max(initial=0))) + 1)
    along *= (length - np.maximum(width, 1))[:, None]
    total, place = np.zeros((len(level), texture.shape[-1])), at.reshape(-1, 2).compress(covered.ravel(), 0)
    for k in range(int(taps.max(initial=1))):
        # Most pixels need few samples only.
        some = np.flatnonzero(k < taps)
        share = 1 / taps.take(some)
        away = ((k + 0.5) * share - 0.5)[:, None] * along.take(some, 0)
        seen = trilinear(levels, place.take(some, 0) + away, level.take(some), share)
        if len(some) == len(total):
            total += seen
        else:
            total[some] += seen
    if covered.all():
        return total.reshape(*covered.shape, -1)
    out = np.zeros((*covered.shape, texture.shape[-1]))
    out[covered] = total
    return out


def filter_large(texture: Floats, at: Singles) -> Singles:
    """Return what `filter_texture` does for a large picture (H, W, 2), some rows at a time."""
    out = np.empty((*at.shape[:2], texture.shape[-1]), np.float32)

    def look_up(first: int, top: int, bottom: int, last: int) -> None:
        out[top:bottom] = filter_texture(texture, at[first:last].astype(np.float64))[top - first : bottom - first]

    in_bands(look_up, at.shape, margin=1)
    return out


def footprints(at: Floats, covered: Bools, shape: tuple[int, int]) -> tuple[Floats, Floats, Floats]:
    """Return the footprint of n `covered` pixels (H, W) in the texture: its long axis (n, 2), its length and width.

    The axis is in copies a sample, 0 where the length is 1 at most; length and width (n,) are over `DENSITY` samples.
    """
    samples = np.array(shape[::-1], float)
    places = at * samples / DENSITY
    slopes = [steepness(places, axis).reshape(-1, 2).compress(covered.ravel(), 0).T for axis in (1, 0)]
    # Singular values and the first left vector of a 2 x 2 matrix, from the double of the angle that diagonalises J Jᵀ.
    a, b, c = (sum(slope[i] * slope[j] for slope in slopes) for i, j in ((0, 0), (0, 1), (1, 1)))
    half, off = (a + c) / 2, (a - c) / 2
    gap = np.sqrt(off * off + b * b)
    length, along = np.sqrt(half + gap), np.zeros((len(a), 2))
    long = np.flatnonzero(length > 1)
    cosine = np.clip(off.take(long) / np.maximum(gap.take(long), 1e-300), -1, 1)
    along[long, 0] = np.sqrt((1 + cosine) / 2) * (DENSITY / samples[0])
    along[long, 1] = np.copysign(np.sqrt((1 - cosine) / 2), b.take(long)) * (DENSITY / samples[1])
    return along, length, np.sqrt(np.maximum(half - gap, 0))


def steepness(at: Floats, axis: int) -> Floats:
    """Return the smaller of the differences to both neighbours along an axis: it does not see a jump between pieces."""
    steps = np.diff(np.moveaxis(at, axis, 0), axis=0)
    sizes = np.nan_to_num(steps[..., 0] ** 2 + steps[..., 1] ** 2, nan=np.inf)
    beyond = np.full((1, *sizes.shape[1:]), np.inf)
    is_before = np.concatenate([beyond, sizes]) <= np.concatenate([sizes, beyond])
    steps = np.nan_to_num(steps, copy=False)
    out = np.zeros((len(steps) + 1, *steps.shape[1:]))
    out[:-1] = steps
    np.copyto(out[1:], steps, where=is_before[1:, ..., None])
    return np.asarray(np.moveaxis(out, 0, axis), np.float64)


def steepness_at(at: Floats | Singles, rows: Ints, columns: Ints, axis: int) -> Floats:
    """Return what `steepness` of places (H, W, 2) has in those `rows` and `columns` (n,): (n, 2)."""
    around = np.full((3, len(rows), 2), np.nan)
    for place, step in enumerate((-1, 0, 1)):
        there = (rows + step, columns) if axis == 0 else (rows, columns + step)
        inside = (there[axis] >= 0) & (there[axis] < at.shape[axis])
        around[place, inside] = at[there[0][inside], there[1][inside]]
    return np.asarray(steepness(around, 0)[1], np.float64)


def trilinear(levels: list[Singles], at: Floats, level: Floats, share: Floats) -> Floats:
    """Return the texture at places (n, 2) between the two levels of its pyramid next to `level` (n,), times a `share`.

    The share (n,) is that of each place in what is seen of several.
    """
    total = np.zeros((len(at), levels[0].shape[-1]))
    for k, texture in enumerate(levels):
        weight = share * np.maximum(1 - np.abs(level - k), 0)
        near = np.flatnonzero(weight)
        if len(near) == len(at):
            total += weight[:, None] * wrap(texture, at)
        elif len(near):
            total[near] += weight.take(near)[:, None] * wrap(texture, at.take(near, 0))
    return total


def pyramid(texture: Floats, count: int) -> list[Singles]:
    """Return the first levels of a repeating texture's pyramid (h, w, C), each with a border of one sample around."""
    levels = [texture]
    while len(levels) < count:
        levels.append(halve(levels[-1]))
    return [np.pad(level, ((1, 1), (1, 1), (0, 0)), mode="wrap").astype(np.float32) for level in levels]


def halve(texture: F) -> F:
    """Return the next level of a pyramid."""
    h, w = texture.shape[:2]
    size = max(1, w // 2), max(1, h // 2)
    half = cv2.resize(texture, size, interpolation=cv2.INTER_AREA)
    return np.asarray(half, texture.dtype).reshape(size[1], size[0], -1)


def wrap(texture: Singles, at: Floats) -> Singles:
    """Return a repeating texture with a border of one sample at places (n, 2), in copies, bilinear: (n, C)."""
    inside = at - np.floor(at)
    return look_up(texture, inside * (np.array(texture.shape[1::-1]) - 2) + 0.5)
