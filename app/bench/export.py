"""How long rendering to pixels takes: the `export` list of `weft bench`."""

import statistics
import time

import numpy as np

from app.render.export import render_mesh
from core.arrays import Points
from core.grid import Grid
from core.imaging.images import Image

SIZES = ((1600, 1200), (4000, 3000))
RUNS = 3


def measure(sizes: tuple[tuple[int, int], ...] = SIZES, *, runs: int = RUNS) -> list[dict[str, float]]:
    """Return one record per size, (W, H): megapixels and the median of the seconds that an 8-bit picture takes.

    Every run sends the picture to the GPU, draws it under a gentle wave and reads the result.
    """
    records = []
    for width, height in sizes:
        image, rest = _noise(width, height), Grid(width, height).nodes
        warped = _waved(rest)
        render_mesh(image, rest, warped, size=(16, 16))
        seconds = []
        for _ in range(runs):
            started = time.perf_counter()
            render_mesh(image, rest, warped, size=(width, height))
            seconds.append(time.perf_counter() - started)
        records.append({"megapixels": width * height / 1e6, "seconds": statistics.median(seconds)})
    return records


def _noise(width: int, height: int) -> Image:
    return Image(np.random.default_rng(0).integers(0, 256, (height, width, 3), dtype=np.uint8))


def _waved(rest: Points) -> Points:
    x, y = np.moveaxis(rest / rest.max(), -1, 0)
    waved: Points = rest + 0.02 * rest.max() * np.stack([np.sin(5 * y), np.cos(4 * x)], axis=-1)
    return waved
