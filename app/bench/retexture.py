"""How long retexturing takes beside DPD table 1: the `retexture` list of `weft bench`."""

import statistics
import time
from typing import Any, NamedTuple

import cv2
import numpy as np

from app.bench.timing import median_s
from core.arrays import Bytes
from core.curves.feature_curves import FeatureCurve
from core.curves.fitting import fit
from core.grid import Grid
from core.progress import Progress, run
from core.retexture.deformation.preview import LiveDeformation
from core.retexture.job import Settings, retexture
from core.retexture.synthesis.patches import PatchShape

RUNS = 3


class Case(NamedTuple):
    """A row of the table: a picture's width and height, a patch's sides, the paper's seconds, and the arch's rise."""

    name: str
    size: tuple[int, int]
    patch: tuple[int, int]
    seconds: float
    rise: float = 0.36
    """Height of the arch that the curve becomes, as a share of the width."""


PAPER = (
    Case("Long bunny ear", (500, 692), (36, 17), 88),
    Case("Beach, short shadow", (345, 398), (40, 41), 257),
    Case("Beach, long shadow", (345, 398), (40, 41), 241),
    Case("Wave", (498, 356), (40, 41), 108),
    Case("Postdoc #1", (695, 473), (30, 15), 218),
    Case("Postdoc #2", (591, 431), (30, 15), 230),
    Case("Painting (arch)", (660, 495), (40, 41), 118),
    Case("Painting (hat)", (571, 536), (40, 41), 84),
    Case("Strawberry", (554, 614), (40, 41), 91),
    Case("Pizza", (800, 566), (40, 41), 245),
)
"""DPD table 1, on a Pentium 4 at 3.4 GHz."""
HIGHER = Case("Long bunny ear, higher arch", (500, 692), (36, 17), 88, rise=0.52)
"""The first row with a curve that grows by half, which leaves a larger area to regrow."""


def measure(cases: tuple[Case, ...] = (*PAPER, HIGHER), *, runs: int = RUNS) -> list[dict[str, Any]]:
    """Return one record per case: medians of the seconds to the coarse and to the final picture, and the paper's.

    The picture is fur over its whole, with one curve from side to side that becomes an arch, a quarter longer, or
    half in the case that says so.
    `drag_ms` is the median time of one solve while that curve is dragged.
    """
    return [_measure(case, runs) for case in cases]


def _measure(case: Case, runs: int) -> dict[str, Any]:
    width, height = case.size
    picture, curves = fur(width, height), [arch(width, height, case.rise)]
    shape = PatchShape(case.patch[0] // 2, case.patch[1] // 2)
    times = [_time_stages(picture, curves, Settings(patch=shape)) for _ in range(runs)]
    first, total = (statistics.median(column) for column in zip(*times, strict=True))
    return {
        "name": case.name,
        "size": [height, width],
        "patch": list(case.patch),
        "first_s": first,
        "total_s": total,
        "drag_ms": _drag_ms((height, width), curves, runs),
        "paper_s": case.seconds,
    }


def _time_stages(picture: Bytes, curves: list[FeatureCurve], settings: Settings) -> tuple[float, float]:
    """Return the seconds until the coarse and until the final picture is there."""
    started = time.perf_counter()
    coarse: list[float] = []

    def show(step: Progress) -> None:
        if step.preview is not None:
            step.preview.apply(picture, blend=False)
            coarse.append(time.perf_counter() - started)

    run(retexture(picture, curves, settings), show).apply(picture)
    return coarse[1], time.perf_counter() - started


def _drag_ms(shape: tuple[int, int], curves: list[FeatureCurve], runs: int) -> float:
    preview = LiveDeformation(shape, Grid(shape[1], shape[0]).nodes)
    return 1e3 * median_s(lambda: preview.solve(curves), max(3 * runs, 3))


def fur(width: int, height: int) -> Bytes:
    """Return a picture (H, W, 3) of slanted hair: noise smeared along one direction."""
    rng = np.random.default_rng(0)
    hair = np.eye(15, dtype=np.float32)[::-1] / 15
    smeared = cv2.filter2D(rng.normal(0, 1, (height, width, 3)).astype(np.float32), -1, hair)
    return np.clip(140 + 130 * smeared, 0, 255).astype(np.uint8)


def arch(width: int, height: int, rise: float = 0.36) -> FeatureCurve:
    """Return a curve across the picture that is straight at first and an arch in the end, `rise` widths high."""
    x = np.linspace(0, width - 1, width)
    bump = rise * width * (1 - np.cos(2 * np.pi * x / (width - 1))) / 2
    middle = np.full(width, height / 2)
    line, bow = (fit(np.column_stack([x, y]), tolerance=0.5) for y in (middle, middle + 0.5 * rise * width - bump))
    return FeatureCurve(line, bow)
