"""Small photos of patterned cloth with known geometry and shading, for the tests of core.overlay."""

from dataclasses import dataclass

import numpy as np

from core.arrays import Floats
from core.imaging.image import Image
from core.overlay.texel import Texel

COLOURS = np.array([[0.75, 0.72, 0.6], [0.15, 0.25, 0.5], [0.7, 0.2, 0.2]])


@dataclass(frozen=True)
class Scene:
    """A photo and what it was made from."""

    photo: Floats
    uv: Floats
    shading: Floats
    basis: Floats


def stored(values: object) -> Image:
    """Return values on the 0 to 1 scale as an 8-bit picture."""
    return Image(np.rint(255 * np.clip(np.asarray(values), 0, 1)).astype(np.uint8))


def motif(n: int = 60) -> Texel:
    """Return a texel of a large and a small blot."""
    t = (np.arange(n) + 0.5) / n
    u, v = np.meshgrid(t, t)
    pixels = np.tile(COLOURS[0], (n, n, 1))
    pixels[np.hypot(u - 0.4, v - 0.45) < 0.26 + 0.06 * np.cos(3 * np.arctan2(v - 0.45, u - 0.4))] = COLOURS[1]
    pixels[np.hypot(u - 0.8, v - 0.85) < 0.12] = COLOURS[2]
    return Texel(pixels)


def marked_checks(n: int = 64, *, mark: bool = True) -> Texel:
    """Return a texel of two by two checks, one of them with a small mark."""
    t = (np.arange(n) + 0.5) / n
    u, v = np.meshgrid(t, t)
    pixels = np.where((((u < 0.5) ^ (v < 0.5))[..., None]), COLOURS[0], COLOURS[1])
    if mark:
        pixels[(np.abs(u - 0.25) < 0.07) & (np.abs(v - 0.22) < 0.16)] = COLOURS[2]
    return Texel(pixels)


def plaid(n: int = 60) -> Texel:
    """Return a texel of two stripes along the warp and two along the weft."""
    t = (np.arange(n) + 0.5) / n
    warp, weft = np.zeros((n, 3)), np.zeros((n, 3))
    warp[(t > 0.1) & (t < 0.35)], warp[(t > 0.6) & (t < 0.66)] = (0.4, 0.1, 0.1), (0.4, 0.4, 0.3)
    weft[(t > 0.2) & (t < 0.5)], weft[(t > 0.8) & (t < 0.85)] = (0.1, 0.1, 0.35), (0.4, 0.35, 0.4)
    return Texel(0.15 + warp[None] + weft[:, None])


def make_scene(
    texel: Texel,
    *,
    size: tuple[int, int] = (170, 190),
    basis: Floats | None = None,
    bend: float = 2.5,
    noise: float = 0.01,
    seed: int = 0,
) -> Scene:
    """Return a photo of cloth whose texels have the vectors `basis` (2, 2), bent by waves of `bend` pixels."""
    S = np.array([[24.0, 3.0], [-2.0, 22.0]]) if basis is None else basis
    uv = coordinates(size, S, bend, 0.0, 0.0)
    shading = 0.9 + 0.25 * np.sin(uv @ np.array([0.5, 0.6]))
    albedo = np.zeros((*size, 3))
    offsets = (np.arange(3) - 1) / 3
    for dy in offsets:
        for dx in offsets:
            albedo += texel(coordinates(size, S, bend, dx, dy)) / 9
    photo = shading[..., None] * albedo + np.random.default_rng(seed).normal(0, noise, (*size, 3))
    return Scene(np.clip(photo, 0, 1), uv, shading, S)


def coordinates(size: tuple[int, int], S: Floats, bend: float, dx: float, dy: float) -> Floats:
    """Return the texture coordinates (H, W, 2) of pixels moved by (dx, dy)."""
    y, x = np.indices(size).astype(float)
    x, y = x + dx, y + dy
    wave = np.stack([np.sin(y / 23 + 0.3) + 0.4 * np.sin(x / 31), np.cos(x / 26) + 0.5 * np.sin((x + y) / 37)], -1)
    return (np.stack([x, y], -1) + bend * wave) @ np.linalg.inv(S).T


def grid(size: tuple[int, int] = (40, 50), pixels_per_copy: float = 20.0) -> Floats:
    """Return coordinates (H, W, 2) of cloth that lies flat, so many pixels to a copy of the texture."""
    y, x = np.indices(size).astype(float)
    return np.asarray(np.stack([x, y], -1) / pixels_per_copy, np.float64)
