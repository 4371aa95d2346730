"""How long rendering to pixels takes, beside what others take: the `export` list of `weft bench`."""

import multiprocessing
import resource
import shutil
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from app.bench.timing import median_s
from app.render.export import render_mesh
from core.arrays import Bytes, Points
from core.grid import Grid
from core.imaging.images import Image

SIZES = ((1600, 1200), (4000, 3000), (6000, 4000), (12_000, 8400))
RUNS = 3
MOST_DISTORTED = 12_000_000
"""ImageMagick is asked for pictures of so many pixels at most: it takes seconds for each million."""
RSS_UNIT = 1 if sys.platform == "darwin" else 1024


def measure(sizes: tuple[tuple[int, int], ...] = SIZES, *, runs: int = RUNS) -> list[dict[str, float | None]]:
    """Return one record per size, (W, H): megapixels, the median of the seconds that an 8-bit picture takes, and peaks.

    Every run sends the picture to the GPU, draws it under a gentle wave and reads the result, in a process of its own
    for each size. `busy_s` is what all its threads have used of the processor, those that draw in software included;
    `peak_mb` is its most memory, `idle_mb` what it had without any picture. Beside it stand OpenCV's `remap` under the
    same wave, its maps worked out from the same nodes, and ImageMagick's `-distort` under a perspective, None where it
    is not installed: both by cubic convolution too, but on the encoded values where Weft filters light.
    """
    return [_apart(size, runs) for size in sizes]


def _apart(size: tuple[int, int], runs: int) -> dict[str, float | None]:
    """Measure one size in a new process."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        return pool.submit(_record, size, runs).result()


def _record(size: tuple[int, int], runs: int) -> dict[str, float | None]:
    width, height = size
    small = Grid(64, 64)
    render_mesh(_noise(64, 64), small.nodes, small.nodes, size=(64, 64))
    idle_mb = _peak_mb()
    image, rest = _noise(width, height), Grid(width, height).nodes
    warped = _waved(rest)
    busy = time.process_time()
    seconds = median_s(lambda: render_mesh(image, rest, warped, size=size), runs)
    busy_s = (time.process_time() - busy) / runs
    peak_mb = _peak_mb()
    return {
        "megapixels": width * height / 1e6,
        "seconds": seconds,
        "busy_s": busy_s,
        "peak_mb": peak_mb,
        "idle_mb": idle_mb,
        "remap_s": median_s(lambda: _remapped(image.pixels, rest, warped), runs),
        "imagemagick_s": _distorted_s(image.pixels) if width * height <= MOST_DISTORTED else None,
    }


def _peak_mb() -> float:
    """Return the most memory that this process has had, in MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * RSS_UNIT / 1e6


def _remapped(pixels: Bytes, rest: Points, warped: Points) -> Bytes:
    """Return what `remap` makes of it: a gentle wave is undone by its negative, to within what it bends."""
    size = pixels.shape[1], pixels.shape[0]
    maps = cv2.resize((2 * rest - warped).astype(np.float32), size, interpolation=cv2.INTER_LINEAR)
    return np.asarray(cv2.remap(pixels, maps, np.empty(0), cv2.INTER_CUBIC), np.uint8)


def _distorted_s(pixels: Bytes) -> float | None:
    """Return the seconds that ImageMagick takes, reading and writing a plain file included."""
    program = shutil.which("magick") or shutil.which("convert")
    if program is None:
        return None
    height, width = pixels.shape[:2]
    moved = {(0, 0): (0.02, 0), (1, 0): (1, 0.02), (1, 1): (0.98, 1), (0, 1): (0, 1)}
    bent = " ".join(f"{width * x},{height * y} {width * u},{height * v}" for (x, y), (u, v) in moved.items())
    with TemporaryDirectory() as folder:
        source, result = Path(folder) / "source.ppm", Path(folder) / "result.ppm"
        cv2.imwrite(str(source), pixels[..., ::-1])
        command = [program, str(source), "-filter", "Catrom", "-distort", "Perspective", bent, str(result)]
        started = time.perf_counter()
        done = subprocess.run(command, capture_output=True, check=False)
        return time.perf_counter() - started if done.returncode == 0 else None


def _noise(width: int, height: int) -> Image:
    return Image(np.random.default_rng(0).integers(0, 256, (height, width, 3), dtype=np.uint8))


def _waved(rest: Points) -> Points:
    x, y = np.moveaxis(rest / rest.max(), -1, 0)
    waved: Points = rest + 0.02 * rest.max() * np.stack([np.sin(5 * y), np.cos(4 * x)], axis=-1)
    return waved
