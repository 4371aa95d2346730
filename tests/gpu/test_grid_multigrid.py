"""The mapping solved by multigrid on the GPU agrees with the mapping solved by the factor on the processor."""

from collections.abc import Callable

import cv2
import moderngl
import numpy as np
import pytest

from app.render import gpu
from app.render.solver.grid_multigrid import GridMultigrid
from app.render.solver.multigrid import Multigrid
from core.arrays import Bytes, Floats, Points
from core.grid import Grid, find_features
from core.linalg.laplacian import edge_weights, node_values
from core.linalg.multifrontal import GridFactor
from core.mapping.features.limits import Limits
from core.mapping.features.straight_lines import Lines
from core.mapping.handles import dirichlet_plate
from core.mapping.handles.handles import Handles
from core.mapping.options import DEFAULT_OPTIONS, MappingOptions
from core.mapping.warper import Warper
from core.warps.outline import follow_outline
from core.warps.presets import make_warp
from core.warps.warp import compose, resize

pytestmark = pytest.mark.gpu
SIDE = 400
GRID = Grid(SIDE, SIDE, cell_px=4)
AGREE_PX = 0.01


@pytest.fixture
def context() -> moderngl.Context:
    context = gpu.standalone()
    if context.version_code < 430:
        pytest.skip("no OpenGL 4.3")
    return context


def discs(*places: tuple[float, float, float]) -> Bytes:
    """Return a mask of discs: centre and radius as shares of the picture's side."""
    mask = np.zeros((SIDE, SIDE), np.uint8)
    for x, y, radius in places:
        cv2.circle(mask, (round(x * SIDE), round(y * SIDE)), round(radius * SIDE), 255, -1)
    return mask


FOUR = ((0.25, 0.25, 0.1), (0.7, 0.3, 0.12), (0.35, 0.75, 0.08), (0.75, 0.75, 0.14))
MANY = tuple((0.05 + 0.05 * i, 0.08 + 0.092 * j, 0.018) for i in range(19) for j in range(10))


def swirl(bend: float) -> Points:
    return make_warp("swirl", SIDE, SIDE, bend=bend)(GRID.nodes)


def widened(bend: float) -> Points:
    return compose(make_warp("swirl", SIDE, SIDE, bend=bend), resize((SIDE, SIDE), (600, SIDE)))(GRID.nodes)


def bulged(amount: float) -> Points:
    """Return the nodes in an outline whose upper side is bent."""
    u = np.linspace(0, 1, 4)[:3]
    low, high = np.zeros(3), np.ones(3)
    ring = np.concatenate([np.stack(side, -1) for side in ((u, low), (high, u), (1 - u, high), (low, 1 - u))])
    ring[1:3, 1] -= amount / 100
    return follow_outline(GRID.nodes, ring * SIDE)


LINES = Lines(np.array([[[20.0, 190.0], [380.0, 210.0]], [[200.0, 0.0], [215.0, 399.0]]]))
SCENES: dict[str, tuple[Bytes, Callable[[float], Points], MappingOptions]] = {
    "four": (discs(*FOUR), swirl, MappingOptions()),
    "many": (discs(*MANY), swirl, MappingOptions()),
    "rigid": (discs(*FOUR), swirl, MappingOptions(keep="rigid")),
    "outline": (discs(*FOUR, (0.5, 0.0, 0.1)), bulged, MappingOptions()),
    "size": (discs(*FOUR, (0.5, 0.0, 0.1)), widened, MappingOptions()),
    "soft": (discs(*FOUR), swirl, MappingOptions(single=((2, Limits(weight=0.5)),))),
    "lines": (discs(*FOUR), widened, MappingOptions(lines=LINES)),
}


def pair(
    context: moderngl.Context, mask: Bytes, options: MappingOptions = DEFAULT_OPTIONS
) -> tuple[Warper, Warper, list[GridMultigrid]]:
    """Return what answers on the processor and on the GPU, and the solver of the latter."""
    made: list[GridMultigrid] = []

    def analyse(shape: tuple[int, int]) -> GridMultigrid:
        made.append(GridMultigrid(context, shape))
        return made[-1]

    warpers = Warper(GRID), Warper(GRID, analyse=analyse)
    for warper in warpers:
        warper.use(find_features(GRID, mask), options)
    return *warpers, made


def apart_px(a: Points, b: Points) -> float:
    return float(np.linalg.norm(a - b, axis=-1).max())


@pytest.mark.parametrize("name", SCENES)
def test_a_drag_agrees_with_the_factor(context: moderngl.Context, name: str) -> None:
    mask, plain, options = SCENES[name]
    factor, multigrid, made = pair(context, mask, options)
    taken = []
    for amount in (20.0, 21.0, 26.0):
        before, w = made[0].steps, plain(amount)
        assert apart_px(factor.frame(w).warped, multigrid.frame(w).warped) < AGREE_PX
        taken.append(made[0].steps - before)
    assert taken[1] < taken[0], "the second frame begins where the first one ended"


@pytest.mark.parametrize("features", [(), FOUR], ids=["none", "four"])
def test_dragged_pins_agree_with_the_factor(
    context: moderngl.Context, features: tuple[tuple[float, float, float], ...]
) -> None:
    factor, multigrid, made = pair(context, discs(*features))
    at = np.array([[0.2, 0.5], [0.5, 0.5], [0.8, 0.6], [0.7, 0.3]]) * SIDE
    plain = swirl(20)
    for step in (4.0, 5.0, 9.0):
        handles = Handles(at, at + [[step, 3], [-5, 3], [6, step], [5, 5]])
        found = multigrid.frame(plain, handles)
        assert apart_px(factor.frame(plain, handles).warped, found.warped) < AGREE_PX
        assert max(pin.error_px for pin in found.pin_reports) < AGREE_PX
    assert made[0].steps


@pytest.mark.parametrize("at_frame", [False, True])
def test_dragged_pins_agree_with_the_factor_under_a_coarser_plate(
    context: moderngl.Context, monkeypatch: pytest.MonkeyPatch, *, at_frame: bool
) -> None:
    monkeypatch.setattr(dirichlet_plate, "DEFAULT_NODES_AT_MOST", GRID.size // 5)
    factor, multigrid, _ = pair(context, discs(*MANY if at_frame else FOUR))
    at = np.array([[0.2, 0.5], [0.5, 0.5], [0.8, 0.6], [0.7, 0.3]]) * SIDE
    at[0, 0] = -0.5 if at_frame else at[0, 0]
    plain = swirl(0)
    for step in (4.0, 5.0, 9.0):
        handles = Handles(at, at + [[0, step], [-5, 3], [6, step], [5, 5]])
        wanted, found = (warper.frame(plain, handles) for warper in (factor, multigrid))
        assert apart_px(wanted.warped, found.warped) < AGREE_PX
        assert apart_px(wanted.plain, found.plain) < AGREE_PX
        assert np.array_equal(wanted.folded, found.folded)


def test_folds_are_found_where_there_are_some(context: moderngl.Context) -> None:
    factor, multigrid, _ = pair(context, discs(*FOUR))
    at = np.array([[0.45, 0.5], [0.55, 0.5]]) * SIDE
    for step in (5.0, 100.0):
        handles = Handles(at, at + [[step, 0], [-step, 0]])
        wanted, found = (warper.frame(swirl(0), handles) for warper in (factor, multigrid))
        assert found.folds is not None
        assert found.folds.any() == (step > 50)
        assert (found.folds != wanted.folded).sum() <= 2


def test_a_painted_mask_agrees_with_the_factor(context: moderngl.Context) -> None:
    factor, multigrid, _ = pair(context, discs(*FOUR))
    plain = swirl(20)
    for more in (0.02, 0.03):
        features = find_features(GRID, discs(*FOUR, (0.5, 0.5, more)))
        for warper in (factor, multigrid):
            warper.use(features, MappingOptions())
        assert apart_px(factor.frame(plain).warped, multigrid.frame(plain).warped) < AGREE_PX


def system(shape: tuple[int, int], seed: int = 0) -> tuple[Floats, Floats]:
    """Return the entries (R, C, 3) of a grid's matrix with weights of 1 to 100 and holes, and a load (N, 2)."""
    random = np.random.default_rng(seed)
    free = random.random(shape) > 0.1
    free[[0, -1]] = free[:, [0, -1]] = False
    weights = random.choice([1.0, 10.0, 100.0], (shape[0] - 1, shape[1] - 1))
    return node_values(edge_weights(weights), free), random.normal(size=(free.size, 2)) * free.reshape(-1, 1)


@pytest.mark.parametrize("shape", [(12, 9), (40, 33), (97, 130), (5, 400), (200, 201)])
def test_any_grid_is_solved_in_few_steps(context: moderngl.Context, shape: tuple[int, int]) -> None:
    values, load = system(shape)
    multigrid = Multigrid(context, shape)
    multigrid.hierarchy.take(values)
    v = multigrid.solution()
    multigrid.solve(load, v, within=1e-4, share=True)
    expected = GridFactor(shape).factorise(values).solve(load)
    found = np.frombuffer(v.read(), np.float32).reshape(-1, 2)
    assert np.abs(found - expected).max() < 1e-3 * np.abs(expected).max()
    assert multigrid.steps <= 25
    multigrid.release()


def test_a_solution_that_is_known_takes_no_step(context: moderngl.Context) -> None:
    values, load = system((60, 70))
    solver = GridMultigrid(context, (60, 70)).factorise(values)
    first, steps = solver.solve(load), solver.steps
    assert np.array_equal(solver.solve(load), first)
    assert solver.steps == steps
    assert not solver.solve(np.zeros_like(load)).any()
    solver.release()


def test_what_is_not_finite_is_said(context: moderngl.Context) -> None:
    values, load = system((60, 70))
    solver = GridMultigrid(context, (60, 70)).factorise(values)
    load[2000] = np.nan
    with pytest.raises(ArithmeticError):
        solver.solve(load)
    assert np.isfinite(solver.solve(system((60, 70))[1])).all(), "the next solve begins anew"
    solver.release()


@pytest.mark.parametrize(("count", "is_asked"), [(5, False), (40, False), (40, True)])
def test_products_of_loads_agree_with_the_factor_and_those_that_are_kept_take_no_step(
    context: moderngl.Context, count: int, *, is_asked: bool
) -> None:
    values, load = system((60, 70))
    live = np.flatnonzero(load.any(axis=1))
    nodes = np.random.default_rng(1).choice(live, 2 * count, replace=False)
    columns = np.zeros((load.shape[0], count))
    columns[nodes, np.arange(2 * count) % count] = 1
    load += 10 * columns[:, :2]
    live = np.flatnonzero(load.any(axis=1))
    solver, factor = GridMultigrid(context, (60, 70)).factorise(values), GridFactor((60, 70)).factorise(values)
    found = solver.forward(columns, nodes, live if is_asked else None)
    expected = factor.forward(columns, nodes)
    largest = np.abs(expected.T @ expected).max()
    assert np.abs(found.T @ found - expected.T @ expected).max() < 1e-6 * largest
    steps = solver.steps
    product, wanted = found.T @ solver.forward_again(load[live], live), expected.T @ factor.forward(load)
    assert np.abs(product - wanted).max() < 1e-4 * np.abs(wanted).max()
    assert (solver.steps == steps) == (count == 5 or is_asked)
    solver.release()
