"""Time a live answer by multigrid on the GPU beside the same answer by the factor: the `gpu` list of `weft bench`."""

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from app.bench.mapping import CELL_PX, make_mask
from app.bench.timing import median_s
from app.render import gpu
from app.render.solver.grid_multigrid import GridMultigrid
from core.arrays import InputError, Points
from core.grid import Grid, find_features
from core.mapping.handles.handles import Handles
from core.mapping.options import DEFAULT_OPTIONS
from core.mapping.result import Warped
from core.mapping.warper import Warper
from core.warps.presets import make_warp

SIZES = ((200, 200), (500, 500), (1000, 1000))
QUICK = ((60, 60),)
_REPEATS = 5
_BEND = 30.0
"""Of the swirl; it grows by a percent from frame to frame."""
_PINS = np.array([[0.2, 0.5], [0.5, 0.5], [0.8, 0.6], [0.7, 0.3]])


def measure(sizes: Sequence[tuple[int, int]] = SIZES) -> list[dict[str, Any]]:
    """Return a record per grid size (R, C) and deed: medians in milliseconds, steps and how far both are apart.

    W is there before: it costs the same both ways.

    Raises
    ------
    InputError
        Where there is no OpenGL 4.3.
    """
    context = gpu.standalone()
    if context.version_code < gpu.COMPUTE:
        raise InputError("--only gpu: needs OpenGL 4.3")
    return [
        {"driver": context.info["GL_RENDERER"], "grid": [rows, columns], **record}
        for rows, columns in sizes
        for record in _records(Grid((columns - 1) * CELL_PX, (rows - 1) * CELL_PX, cell_px=CELL_PX))
    ]


def _records(grid: Grid) -> list[dict[str, Any]]:
    """Drag a preset's slider and then pins."""
    solver = GridMultigrid(gpu.standalone(), grid.shape)
    features = find_features(grid, make_mask(grid))
    factor, multigrid = Warper(grid), Warper(grid, analyse=lambda _: solver)
    prepared = []
    for live in (factor, multigrid):
        started = time.perf_counter()
        live.use(features, DEFAULT_OPTIONS)
        live.frame(_swirled(grid, 0))
        prepared.append(1e3 * (time.perf_counter() - started))
    pins = _PINS * [grid.width_px, grid.height_px]
    plains = [_swirled(grid, number) for number in range(_REPEATS + 1)]
    deeds: dict[str, Callable[[Warper, int], Warped]] = {
        "preset": lambda live, number: live.frame(plains[number]),
        "pins": lambda live, number: _dragged(live, plains[0], Handles(pins, pins + 1.0 + number)),
    }
    found = []
    for deed, answer in deeds.items():
        by_factor, by_multigrid = (answer(live, 0) for live in (factor, multigrid))
        steps = solver.steps
        gpu_ms, factor_ms = (_median_ms(answer, live) for live in (multigrid, factor))
        steps = solver.steps - steps
        apart = float(np.linalg.norm(by_factor.warped - by_multigrid.warped, axis=-1).max())
        found.append(
            {
                "deed": deed,
                "gpu_ms": gpu_ms,
                "factor_ms": factor_ms,
                "ratio": factor_ms / gpu_ms,
                "steps": steps / _REPEATS,
                "apart_px": apart,
                "gpu_begins_ms": prepared[1],
                "factor_begins_ms": prepared[0],
            }
        )
    solver.release()
    return found


def _dragged(live: Warper, plain: Points, handles: Handles) -> Warped:
    found = live.frame(plain, handles)
    live.look_ahead()
    return found


def _median_ms(answer: Callable[[Warper, int], Warped], live: Warper) -> float:
    numbers = iter(range(1, _REPEATS + 1))
    return 1e3 * median_s(lambda: answer(live, next(numbers)), _REPEATS)


def _swirled(grid: Grid, number: int) -> Points:
    return make_warp("swirl", grid.width_px, grid.height_px, bend=_BEND * 1.01**number)(grid.nodes)
