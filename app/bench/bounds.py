"""How long large pictures take on the command line, and how much memory, beside what they may: the `bounds` list.

Each is one whole command in a process of its own, reading and writing included.
"""

import json
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.bench.export import RSS_UNIT
from app.bench.overlay import cloth
from app.bench.retexture import arch, fur
from core.arrays import Bytes, WeftError
from core.imaging.images import Image, save

Making = Callable[[Path, tuple[int, int]], list[str]]
"""Writes what a command reads into a folder, for a picture of that width and height, and returns the command."""


@dataclass(frozen=True)
class Bound:
    """What a command may take on two cores."""

    name: str
    size: tuple[int, int]
    seconds: float
    gigabytes: float
    make: Making


def make_cloth(folder: Path, size: tuple[int, int]) -> list[str]:
    """Take a photo of patterned cloth apart; its texels grow with it, as a larger photo's do."""
    photo = folder / "cloth.jpg"
    save(Image(np.rint(cloth((size[1], size[0])) * 255).astype(np.uint8)), photo)
    return ["decompose", str(photo), "-o", str(folder / "parts")]


def make_fur(folder: Path, size: tuple[int, int]) -> list[str]:
    """Regrow fur along a curve a third as long as the picture is wide, that becomes an arch."""
    picture, curves, third = folder / "fur.jpg", folder / "curves.json", size[0] // 3
    curve = arch(third, size[1], 0.1)
    assert curve.target is not None
    save(Image(fur(*size)), picture)
    sides = {"source": curve.source.points, "target": curve.target.points}
    sides = {name: (points + [third, 0]).tolist() for name, points in sides.items()}
    curves.write_text(json.dumps({"curves": [sides]}), encoding="utf-8")
    return ["retexture", str(picture), "--curves", str(curves), "-o", str(folder / "out.jpg")]


def make_arc(folder: Path, size: tuple[int, int]) -> list[str]:
    """Bend a large picture into an arc."""
    return _warp(folder, size, "arc")


def make_twist(folder: Path, size: tuple[int, int]) -> list[str]:
    """Twist a long strip."""
    return _warp(folder, size, "twist")


def _warp(folder: Path, size: tuple[int, int], preset: str) -> list[str]:
    picture = folder / "picture.jpg"
    save(Image(waves(*size)), picture)
    return ["warp", str(picture), "--preset", preset, "--bend", "60", "-o", str(folder / "out.jpg")]


def waves(width: int, height: int) -> Bytes:
    """Return a picture (H, W, 3) with detail everywhere."""
    x, y = np.arange(width), np.arange(height)
    across = (128 + 60 * np.sin(x / 7) + 60 * np.sin(x / 301)).astype(np.uint8)
    down = (128 + 60 * np.sin(y / 9) + 60 * np.sin(y / 211)).astype(np.uint8)
    return np.stack([np.broadcast_to(across, (height, width)), across ^ down[:, None], down[:, None] | across], -1)


BOUNDS = (
    Bound("decompose", (4000, 3000), 30.0, 1.4, make_cloth),
    Bound("retexture", (4000, 3000), 15.0, 0.75, make_fur),
    Bound("warp, arc", (16_384, 16_384), 60.0, 0.85, make_arc),
    Bound("warp, twist", (30_000, 200), 29.0, 0.5, make_twist),
)
QUICK = tuple(Bound(bound.name, (600, 400), bound.seconds, bound.gigabytes, bound.make) for bound in BOUNDS[:3])


def measure(bounds: tuple[Bound, ...] = BOUNDS) -> list[dict[str, Any]]:
    """Return one record per command: its seconds by the clock and of the processor, its most memory, and its bounds."""
    return [_record(bound) for bound in bounds]


def _record(bound: Bound) -> dict[str, Any]:
    # From a process of its own, twice: a command is said to have taken what the process that starts it held.
    with tempfile.TemporaryDirectory() as folder:
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as apart:
            words = apart.submit(bound.make, Path(folder), bound.size).result()
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as apart:
            seconds, busy_s, gigabytes, fault = apart.submit(_run, words).result()
    if fault is not None:
        raise WeftError(f"weft {bound.name}: {fault}")
    return {
        "name": bound.name,
        "size": list(bound.size),
        "seconds": seconds,
        "busy_s": busy_s,
        "peak_gb": gigabytes,
        "bound_s": bound.seconds,
        "bound_gb": bound.gigabytes,
        "holds": seconds <= bound.seconds and gigabytes <= bound.gigabytes,
    }


def _run(words: list[str]) -> tuple[float, float, float, str | None]:
    """Return what a command took (seconds, those of the processor, gigabytes), and what it said if it failed."""
    started = time.perf_counter()
    command = [sys.executable, "-m", "app", *words]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    assert process.stderr is not None
    with process.stderr as stream:
        said = stream.read().decode(errors="replace")
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - started
    process.returncode = os.waitstatus_to_exitcode(status)
    fault = said.strip() if process.returncode else None
    return seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * RSS_UNIT / 1e9, fault
