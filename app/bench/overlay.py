"""How long decomposing a photo takes, by stage: the `overlay` list of `weft bench`."""

import statistics
import time
from typing import Any

import numpy as np

from app.bench.timing import median_s
from core.arrays import Floats
from core.overlay.composition import compose
from core.overlay.decomposition import Decomposition, decompose
from core.overlay.texel import Texel
from core.progress import run

SIZES = ((256, 256), (512, 512), (1024, 1024))
RUNS = 3
TEXELS = 150
"""Texels in a picture, whatever its size."""


def measure(sizes: tuple[tuple[int, int], ...] = SIZES, *, runs: int = RUNS) -> list[dict[str, Any]]:
    """Return one record per size (H, W): texels, medians of the whole and of each stage, and of laying a texture on.

    The picture is folded cloth with a pattern of blots, light and shade, and a little noise.
    """
    return [_record(cloth(size), runs) for size in sizes]


def _record(photo: Floats, runs: int) -> dict[str, Any]:
    totals: list[float] = []
    stages: list[dict[str, float]] = []
    for _ in range(runs):
        started = time.perf_counter()
        found = run(decompose(photo))
        totals.append(time.perf_counter() - started)
        stages.append(found.seconds)
    names = dict.fromkeys(name for seconds in stages for name in seconds)
    return {
        "size": list(photo.shape[:2]),
        "texels": round(float(found.covered.sum()) / abs(float(np.linalg.det(found.basis)))),
        "total_s": statistics.median(totals),
        "stages": {name: statistics.median(seconds.get(name, 0.0) for seconds in stages) for name in names},
        "compose_ms": 1e3 * _compose_s(found, runs),
    }


def _compose_s(found: Decomposition, runs: int) -> float:
    """Return the seconds that laying a texture on takes without a shader."""
    parts = (found.uv.astype(float), found.shading.astype(float), found.detail.astype(float))
    texture = np.random.default_rng(0).random((128, 128, 3))
    return median_s(lambda: compose(texture, *parts, found.basis), runs)


def cloth(size: tuple[int, int]) -> Floats:
    """Return a photo (H, W, 3) of about `TEXELS` texels in folds."""
    h, w = size
    side = float(np.sqrt(h * w / TEXELS))
    y, x = np.indices(size).astype(float)
    wave = np.stack([np.sin(y / (1.6 * side)) + 0.4 * np.sin(x / (2.2 * side)), np.cos(x / (1.8 * side))], -1)
    uv = (np.stack([x, y], -1) / side + 0.12 * wave) @ np.array([[0.98, 0.1], [-0.1, 0.98]])
    light = 0.85 + 0.25 * np.sin(uv @ np.array([0.6, 0.5]))
    photo = light[..., None] * blots()(uv) + np.random.default_rng(0).normal(0, 0.008, (*size, 3))
    return np.asarray(np.clip(photo, 0, 1), np.float64)


def blots(n: int = 96) -> Texel:
    """Return a texel with a large blot of three lobes and a small round one."""
    t = (np.arange(n) + 0.5) / n
    u, v = np.meshgrid(t, t)
    lobes = 0.25 + 0.06 * np.cos(3 * np.arctan2(v - 0.45, u - 0.4))
    pixels = np.tile([0.72, 0.68, 0.55], (n, n, 1))
    pixels[np.hypot(u - 0.4, v - 0.45) < lobes] = [0.18, 0.28, 0.5]
    pixels[np.hypot(u - 0.82, v - 0.86) < 0.12] = [0.65, 0.2, 0.22]
    return Texel(pixels)
