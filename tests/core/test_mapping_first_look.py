"""The first mapping without folds that is shown, in a time that does not depend on how hard the mapping is."""

import cv2
import numpy as np
import pytest

from core.arrays import Bytes
from core.grid import Grid, find_features
from core.mapping import first_look
from core.mapping.approach import is_clear
from core.mapping.coarser import Coarser
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.first_look import first_look as look
from core.mapping.first_look import shown_in_time
from core.mapping.folds import folded_quads
from core.mapping.frames import Complexes, as_complex
from core.mapping.release import outer_nodes
from core.mapping.similarity import fit_residual
from core.mapping.stiffen import START, Stiffening, tightened
from core.mapping.unfold import unfold
from core.mapping.warping import Keep
from core.progress import Job, Progress, run
from core.warps.presets import make_warp

WIDTH, HEIGHT = 240, 180
GRID, FINE = Grid(WIDTH, HEIGHT, cell_px=3), Grid(WIDTH, HEIGHT, cell_px=1.5)


def blank() -> Bytes:
    return np.zeros((HEIGHT, WIDTH), np.uint8)


def specks() -> Bytes:
    mask, rng = blank(), np.random.default_rng(3)
    for _ in range(60):
        centre = int(rng.integers(WIDTH)), int(rng.integers(HEIGHT))
        cv2.circle(mask, centre, int(rng.integers(2, 7)), 255, -1)
    return mask


def cross() -> Bytes:
    mask = blank()
    mask[80:110] = mask[:, 100:130] = 255
    return mask


def diagonal() -> Bytes:
    mask = blank()
    cv2.line(mask, (0, 0), (WIDTH, HEIGHT), 255, 22)
    return mask


def large() -> Bytes:
    mask = blank()
    cv2.circle(mask, (120, 90), 70, 255, -1)
    return mask


MASKS = {mask.__name__: mask() for mask in (specks, cross, diagonal, large)}
WARPS = [("arc", 100), ("swirl", 100), ("fish", -100), ("squeeze", 90), ("arch", -100)]


def folding(
    name: str, preset: str, bend: float, *, grid: Grid = FINE, keep: Keep = "rigid"
) -> tuple[FeatureMapping, Complexes, Solution]:
    """Return a mapping, a W without folds and the linear answer, which folds."""
    assert keep != "none"
    mapping = FeatureMapping(grid, find_features(grid, MASKS[name]), keep=keep)
    w = as_complex(make_warp(preset, WIDTH, HEIGHT, bend=bend)(grid.nodes))
    linear = mapping.place(w)
    assert not folded_quads(w).any()
    return mapping, w, linear


def misfits(mapping: FeatureMapping, z: Complexes) -> tuple[list[int], list[float]]:
    """Return how many nodes each feature has, and how far its shape is from its own."""
    rest = as_complex(mapping.grid.nodes).ravel()
    found = [fit_residual(rest[body.nodes], z.ravel()[body.nodes], rigid=False) for body in mapping.bodies]
    return [len(body.nodes) for body in mapping.bodies], found


@pytest.mark.parametrize("grid", [GRID, FINE], ids=["small", "large"])
@pytest.mark.parametrize(("preset", "bend"), WARPS)
@pytest.mark.parametrize("name", MASKS)
def test_a_look_folds_nothing_and_nearly_keeps_shapes_in_few_steps(
    name: str, preset: str, bend: float, grid: Grid
) -> None:
    mapping, w, linear = folding(name, preset, bend, grid=grid)
    steps = list[Progress]()
    z = run(look(mapping, w, linear), steps.append)
    assert is_clear(mapping, w, z)
    outside = outer_nodes(mapping)
    assert np.array_equal(z[outside], w[outside])
    sizes, after = misfits(mapping, z)
    _, before = misfits(mapping, w)
    # What the edge cuts is bent there, where W takes the outline.
    limit = 0.35 if name in ("specks", "large") else 0.85
    assert np.average(after, weights=sizes) < limit * np.average(before, weights=sizes)
    assert sum(step.work for step in steps) < 300_000
    assert all(step.preview is None for step in steps)


def test_features_are_exact_where_that_folds_nothing() -> None:
    mapping, w, linear = folding("specks", "swirl", 100)
    _, found = misfits(mapping, run(look(mapping, w, linear)))
    exact = np.array(found) < 1e-9
    assert 0.5 < exact.mean() < 1
    assert max(found) > 1e-3


@pytest.mark.parametrize("name", ["cross", "diagonal"])
def test_no_step_of_stiffening_the_whole_folds_anything(name: str) -> None:
    mapping, w, linear = folding(name, "arc", 100, grid=GRID)
    folds = []
    for whole in (True, False):
        stiffening = Stiffening(mapping, w, np.abs(linear.alpha), whole=whole)
        seen = [folded_quads(stiffening.z.reshape(w.shape)).sum() for _ in tightened(stiffening, START, 16)]
        folds.append(max(seen))
    assert folds[0] == 0 < folds[1]


def test_where_only_little_of_the_way_can_be_lifted_that_is_the_look(monkeypatch: pytest.MonkeyPatch) -> None:
    mapping, w, linear = folding("large", "squeeze", 90)
    between, farthest = Coarser.between, 0.3 * float(np.abs(linear.z - w).max())
    seen = list[float]()

    def folded(self: Coarser, fine_w: Complexes, coarse_w: Complexes, z: Complexes) -> Complexes:
        seen.append(float(np.abs(z - coarse_w).max()))
        lifted = between(self, fine_w, coarse_w, z)
        return lifted if seen[-1] < farthest else np.conj(lifted)

    monkeypatch.setattr(Coarser, "between", folded)
    z = run(look(mapping, w, linear))
    assert not folded_quads(z).any()
    assert seen[0] > farthest > min(seen)
    assert 0 < np.abs(z - w)[mapping.free].max() < 1.2 * farthest
    assert len(seen) < 10


def test_where_nothing_can_be_lifted_the_look_is_w(monkeypatch: pytest.MonkeyPatch) -> None:
    mapping, w, linear = folding("large", "swirl", 100)
    monkeypatch.setattr(Coarser, "between", lambda *_: -np.conj(w))
    monkeypatch.setattr(first_look, "_ROUNDS", 0)
    assert np.array_equal(run(look(mapping, w, linear)), w)


@pytest.mark.parametrize("height", [1e-6, 1e-9, 1e-15])
def test_a_corner_that_w_all_but_folds_on_the_coarse_grid_is_no_fault(
    height: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    mapping, w, linear = folding("large", "squeeze", 90)
    at_nodes = Coarser.at_nodes

    def flat(self: Coarser, z: Complexes) -> Complexes:
        found = at_nodes(self, z)
        side = found[20, 21] - found[20, 20]
        found[21, 20] = found[20, 20] + (0.5 + 1j * height) * side
        return found

    monkeypatch.setattr(Coarser, "at_nodes", flat)
    assert not folded_quads(run(look(mapping, w, linear))).any()


def test_features_too_small_for_a_shape_on_the_coarse_grid_leave_w() -> None:
    mask = blank()
    mask[0, 100:105] = 255
    mapping = FeatureMapping(FINE, find_features(FINE, mask))
    w = as_complex(make_warp("arc", WIDTH, HEIGHT, bend=40)(FINE.nodes))
    z = run(look(mapping, w, mapping.place(w)))
    assert not folded_quads(z).any()


def test_per_quad_mappings_have_a_look_too() -> None:
    mapping = FeatureMapping(FINE, find_features(FINE, MASKS["large"]), keep="rigid", method="per-quad")
    w = as_complex(make_warp("squeeze", WIDTH, HEIGHT, bend=90)(FINE.nodes))
    z = run(look(mapping, w, mapping.place(w)))
    assert not folded_quads(z).any()
    assert misfits(mapping, z)[1][0] < 0.2 * misfits(mapping, w)[1][0]


def test_on_the_coarse_grid_fine_outline_nodes_lie_between_coarse_ones_outside_features_as_they_do() -> None:
    mapping, w, _ = folding("specks", "arc", 100)
    outside = outer_nodes(mapping)
    for same in (True, False):
        coarser = Coarser(mapping, covered=True, same_outline=same)
        coarse_w = coarser.at_nodes(w)
        moved = coarser.between(w, coarse_w, coarse_w + 10 * (coarser.mapping.index >= 0))
        assert (moved == w)[outside].all() == same
        assert (moved != w)[mapping.index >= 0].mean() > 0.9


def shown(work: list[int], *, first: int | None = None) -> tuple[list[int], int]:
    """Return the steps before looks are shown, and how many looks were asked for, of a job that works so much."""
    asked = list[int]()

    def job() -> Job[str]:
        for number, done in enumerate(work):
            yield Progress(number / len(work), preview="own" if number == first else None, work=done)
        return "done"

    def looking() -> Job[Complexes]:
        asked.append(1)
        yield Progress(0.5, work=50)
        return np.zeros((2, 2), np.complex128)

    steps = list[Progress]()
    assert run(shown_in_time(job(), looking), steps.append) == "done"
    assert [step.fraction for step in steps] == sorted(step.fraction for step in steps)
    return [n for n, step in enumerate(steps) if isinstance(step.preview, np.ndarray)], len(asked)


def test_a_look_is_shown_once_when_a_job_has_worked_for_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(first_look, "_PATIENCE", 100)
    assert shown([40, 40, 10]) == ([], 0)
    assert shown([40, 40, 40, 200, 200]) == ([4], 1)
    assert shown([40, 40, 40, 200], first=1) == ([], 0)
    assert shown([40, 40, 40, 200], first=3) == ([4], 1)


def test_what_is_found_in_the_end_does_not_depend_on_the_look(monkeypatch: pytest.MonkeyPatch) -> None:
    found, looks = [], []
    for patience in (0, 10**9):
        monkeypatch.setattr(first_look, "_PATIENCE", patience)
        mapping, w, _ = folding("specks", "fish", -100)
        previews = [step.preview for step in unfold(mapping, w) if step.preview is not None]
        looks.append(len(previews))
        found.append(run(unfold(mapping, w)).z)
    assert looks[0] == looks[1] + 1
    assert np.array_equal(found[0], found[1])
