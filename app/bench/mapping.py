"""Time the feature-aware mapping beside bare solvers on the same grid, and beside FAT table 1."""

import statistics
from collections.abc import Callable, Sequence
from typing import Any

import cv2
import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from app.bench.timing import median_s
from app.bench.whole_factor import WholeFactor
from core.arrays import Bytes, Floats, Points
from core.grid import Features, Grid, find_features
from core.linalg.factor import Cholmod, Factor, lower_triangle
from core.linalg.laplacian import edge_weights, find_stored, node_values, pattern
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.folds import find_folded_quads
from core.mapping.handles.handles import Handles
from core.mapping.jacobians import as_complex, as_positions
from core.mapping.options import DEFAULT_OPTIONS, MappingOptions
from core.mapping.warper import Warper
from core.mapping.warping import warp_grid
from core.warps.presets import make_warp

SIZES = ((50, 100), (100, 100), (100, 200), (200, 200), (500, 500), (1000, 1000))
PAPER = {
    (50, 100): (0.156, 0.110, 0.015, 0.0),
    (100, 100): (0.375, 0.250, 0.031, 0.015),
    (100, 200): (1.141, 0.562, 0.047, 0.031),
    (200, 200): (2.171, 1.407, 0.109, 0.063),
}
"""Seconds for setup, factor, right-hand side and solve  [FAT table 1, on a Pentium 4 at 3.2 GHz]."""

CELL_PX = 4
_RIGID = MappingOptions(keep="rigid")
_LARGE = 300_000
"""Nodes of a grid on which half as many repeats do."""
_UNFOLD_AT_MOST = 50_000
"""Nodes of the largest default grid."""
_ARAP_AT_MOST = 300_000
_DISCS = ((0.25, 0.25, 0.1), (0.7, 0.3, 0.12), (0.35, 0.75, 0.08), (0.75, 0.75, 0.14))
"""Features: centre and radius as shares of the picture's sides and of its shorter one."""


def measure(sizes: Sequence[tuple[int, int]] = SIZES, *, repeats: int = 5) -> list[dict[str, Any]]:
    """Return one record per grid size (R, C): medians in milliseconds; None for what was not run."""
    return [_record(rows, columns, repeats) for rows, columns in sizes]


def _record(rows: int, columns: int, repeats: int) -> dict[str, Any]:
    repeats = max(2, repeats if rows * columns <= _LARGE else repeats // 2)
    grid = Grid((columns - 1) * CELL_PX, (rows - 1) * CELL_PX, cell_px=CELL_PX)
    mask = make_mask(grid)
    features = find_features(grid, mask)
    plain = _swirled(grid)
    return {
        "grid": [rows, columns],
        **_stages(grid, features, plain, repeats),
        **_interaction(grid, mask, repeats),
        "unfold_ms": _unfold_ms(grid, features) if grid.size <= _UNFOLD_AT_MOST else None,
        "bare": {
            **_bare(grid, features, repeats),
            "cholmod_stroke_ms": _whole_stroke_ms(grid, mask, repeats),
            "libigl_arap_ms": _arap_ms(grid, plain, repeats),
        },
        "paper": _paper(rows, columns),
    }


def _paper(rows: int, columns: int) -> dict[str, float | None]:
    seconds = PAPER.get((rows, columns), (None,) * 4)
    return dict(zip(("setup_s", "factor_s", "rhs_s", "solve_s"), seconds, strict=True))


def make_mask(grid: Grid) -> Bytes:
    """Return a mask with four discs."""
    mask = np.zeros((grid.height_px, grid.width_px), np.uint8)
    for disc in _DISCS:
        x, y, radius = (round(value * side) for value, side in zip(disc, _sides(grid), strict=True))
        cv2.circle(mask, (x, y), radius, 255, -1)
    return mask


def _sides(grid: Grid) -> tuple[int, int, int]:
    """Return what the numbers of a disc are shares of."""
    return grid.width_px, grid.height_px, min(grid.width_px, grid.height_px)


def _median_ms(work: Callable[[], object], repeats: int) -> float:
    return 1e3 * median_s(work, repeats)


def _stages(grid: Grid, features: Features, plain: Points, repeats: int) -> dict[str, float]:
    """Time what FAT table 1 times."""
    runs = []
    for _ in range(repeats):
        mapping = FeatureMapping(grid, features)
        mapping.solve(plain)
        runs.append(mapping.clock.take())
    return {
        f"{stage}_ms": 1e3 * statistics.median(r[stage] for r in runs) for stage in ("setup", "factor", "rhs", "solve")
    }


def _interaction(grid: Grid, mask: Bytes, repeats: int) -> dict[str, float]:
    """Time what an artist waits for: from an input to positions that can be uploaded."""
    live = Warper(grid)
    live.use(find_features(grid, mask), DEFAULT_OPTIONS)
    pins = np.array([[0.2, 0.5], [0.5, 0.5], [0.8, 0.6], [0.7, 0.3]]) * [grid.width_px, grid.height_px]
    moved = iter(np.linspace(1.0, 5.0, repeats + 1))
    # What the first frame of a drag prepares is not timed; with handles, it is the picture without them.
    _shown(live, _swirled(grid))
    drag_preset_ms = _median_ms(lambda: _shown(live, _swirled(grid)), repeats)
    _dragged(live, Handles(pins, pins + next(moved)))
    return {
        "drag_preset_ms": drag_preset_ms,
        "drag_handles_ms": _median_ms(lambda: _dragged(live, Handles(pins, pins + next(moved))), repeats),
        "stroke_ms": _stroke_ms(live, mask.copy(), repeats),
    }


def _stroke_ms(live: Warper, mask: Bytes, repeats: int) -> float:
    """Time a stroke along the edge of the first feature, which grows by a dab in every frame."""
    grid, plain = live.grid, _swirled(live.grid)
    x, y, radius = (value * side for value, side in zip(_DISCS[0], _sides(grid), strict=True))
    angles = iter(np.arange(2 * repeats) * np.pi / repeats)

    def stroke() -> Points:
        angle = next(angles)
        centre = round(x + radius * np.cos(angle)), round(y + radius * np.sin(angle))
        cv2.circle(mask, centre, max(2 * CELL_PX, round(radius / 5)), 255, -1)
        live.use(find_features(grid, mask), DEFAULT_OPTIONS)
        return _shown(live, plain)

    _shown(live, plain)
    return _median_ms(stroke, repeats)


def _whole_stroke_ms(grid: Grid, mask: Bytes, repeats: int) -> float:
    """Time the same stroke with all of the system factorised anew by CHOLMOD, in place of what changes."""
    live = Warper(grid, analyse=WholeFactor)
    live.use(find_features(grid, mask), DEFAULT_OPTIONS)
    return _stroke_ms(live, mask.copy(), repeats)


def _swirled(grid: Grid) -> Points:
    return make_warp("swirl", grid.width_px, grid.height_px, bend=30)(grid.nodes)


def _shown(live: Warper, plain: Points) -> Points:
    return live.frame(plain).warped.astype(np.float32)


def _dragged(live: Warper, handles: Handles) -> Points:
    """Drag pins, one of them in a feature."""
    found = live.frame(live.grid.nodes, handles)
    live.look_ahead()
    return found.warped.astype(np.float32)


def _unfold_ms(grid: Grid, features: Features) -> float | None:
    """Time unfolding rigid features under a wave that folds them; None when it does not."""
    mapping = FeatureMapping(grid, features, keep="rigid")
    for bend in (40, 60, 80, 100):
        w = as_complex(make_warp("arc", grid.width_px, grid.height_px, bend=bend)(grid.nodes))
        if find_folded_quads(mapping.place(w).z).any() and not find_folded_quads(w).any():
            return _median_ms(lambda w=w: warp_grid(grid, features, as_positions(w), options=_RIGID), 1)  # type: ignore[misc]
    return None


def _bare(grid: Grid, features: Features, repeats: int) -> dict[str, float]:
    """Time CHOLMOD and SuperLU on the mapping's matrix, with nothing around them."""
    mapping = FeatureMapping(grid, features)
    weights = edge_weights(mapping.follow_w + mapping.follow_feature)
    lower = pattern(grid.shape)
    lower.data = node_values(weights, mapping.free)[find_stored(grid.shape)]
    whole = sparse.csc_array(lower + sparse.tril(lower, -1).T)
    b = np.random.default_rng(0).random((grid.size, 2))
    factor = Factor(lower)
    held = Cholmod(lower_triangle(lower))
    superlu = splu(whole)
    return {
        "cholmod_factor_ms": _median_ms(held.factorise, repeats),
        "cholmod_solve_ms": _median_ms(lambda: factor.solve(b), repeats),
        "superlu_factor_ms": _median_ms(lambda: splu(whole), max(1, repeats // 2)),
        "superlu_solve_ms": _median_ms(lambda: superlu.solve(b), repeats),
    }


def _arap_ms(grid: Grid, plain: Points, repeats: int) -> float | None:
    """Time one solve of libigl's as-rigid-as-possible deformation with the outline held; None where it is missing."""
    if grid.size > _ARAP_AT_MOST:
        return None
    try:
        import igl
    except ImportError:
        return None
    outline = np.flatnonzero(grid.outline).astype(np.int32)
    rest, there = (np.ascontiguousarray(p.reshape(-1, 2)) for p in (grid.nodes, plain))
    data = igl.ARAPData()
    data.max_iter = 1
    igl.arap_precomputation(rest, grid.triangles, 2, outline, data)
    held: Floats = there[outline]
    return _median_ms(lambda: igl.arap_solve(held, data, there), repeats)
