"""Pictures and grids that the tests of this folder draw."""

import numpy as np

from core.arrays import Pixels, Points
from core.imaging.images import Image


def grid(width: int, height: int, *, cells: int = 12) -> Points:
    """Return rest nodes (R, C, 2) over the whole area of a picture."""
    x = np.linspace(-0.5, width - 0.5, cells + 1)
    y = np.linspace(-0.5, height - 0.5, max(2, cells * height // width) + 1)
    return np.stack(np.meshgrid(x, y), axis=-1)


def wavy(rest: Points, *, amount: float = 6.0) -> Points:
    """Deform smoothly, without folds, leaving the frame in places."""
    x, y = np.moveaxis(rest / rest.max(axis=(0, 1)), -1, 0)
    return rest + amount * np.stack([np.sin(5 * y + 1), np.cos(6 * x + 2 * y)], axis=-1)


def picture(width: int, height: int, channels: int = 3, depth: str = "u1", *, seed: int = 0) -> Image:
    """Make smooth waves with some noise, every channel different."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:height, :width] / 11.0
    waves = [np.sin(x * (1 + c) + y + c) * np.cos(y - 0.3 * c * x) for c in range(channels)]
    values = np.clip(0.5 + 0.4 * np.stack(waves, axis=-1) + rng.normal(0, 0.03, (height, width, channels)), 0, 1)
    return Image(in_depth(values, depth), linear=depth == "f4")


def in_depth(values: Pixels, depth: str) -> Pixels:
    """Return values on the 0 to 1 scale as pixels of `depth`."""
    if depth == "f4":
        return values.astype(np.float32)
    integers: Pixels = np.rint(values * np.iinfo(depth).max).astype(depth)
    return integers
