"""Small pictures of every depth and number of channels."""

from typing import Any

import numpy as np

from core.imaging.images import Image


def picture(depth: Any = np.uint8, channels: int = 3, height: int = 5, width: int = 7) -> Image:
    values = np.random.default_rng(0).uniform(0.1, 1, (height, width, channels))
    if depth is np.float32:
        return Image(values.astype(np.float32), linear=True)
    return Image((values * np.iinfo(depth).max).astype(depth))
