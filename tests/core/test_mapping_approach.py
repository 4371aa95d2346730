"""Steps until nothing is folded: what is tried first, and when they end."""

import cv2
import numpy as np
import pytest

from core.grid import Grid, find_features
from core.mapping import approach
from core.mapping.approach import folds_widened, relaxed, steps_to_clear
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.folds import folded_quads
from core.mapping.frames import Complexes, as_complex
from core.mapping.untangle import Untangler
from core.progress import run

SIDE = 240
GRID = Grid(SIDE, SIDE, cell_px=4)
KNOT = np.s_[12:15, 40:43]


def disc() -> FeatureMapping:
    mask = np.zeros((SIDE, SIDE), np.uint8)
    cv2.circle(mask, (90, 130), 50, 255, -1)
    return FeatureMapping(GRID, find_features(GRID, mask))


def knotted(mapping: FeatureMapping, *, knots: bool = True) -> tuple[Complexes, Solution]:
    """Return a W and a mapping close to it that is folded around one place, far from the feature."""
    w = as_complex(GRID.nodes) * np.exp(0.2j)
    solution = mapping.place(w)
    if knots:
        solution.z[KNOT] += 9.0
    return w, solution


def everywhere(mapping: FeatureMapping, w: Complexes, solution: Solution) -> Untangler:
    held = np.full(len(solution.alpha), np.inf)
    return Untangler(mapping, w, solution, window=np.ones(GRID.shape, bool), stiffness=held)


def test_folds_that_have_become_few_are_cleared_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    mapping = disc()
    w, solution = knotted(mapping)
    untangler = everywhere(mapping, w, solution)
    assert untangler.folds
    assert untangler.size > approach._LARGE
    monkeypatch.setattr(approach, "_FEWER", 1)
    monkeypatch.setattr(untangler, "step", lambda *_: pytest.fail("all unknowns have been moved"))
    assert run(steps_to_clear(untangler, "barrier", 4))
    found = untangler.solution
    near = folds_widened(solution, approach._CLOSE)
    assert not folded_quads(found.z).any()
    assert np.array_equal(found.z[~near], solution.z[~near])
    assert np.array_equal(found.alpha, solution.alpha)


def test_small_windows_are_not_made_smaller(monkeypatch: pytest.MonkeyPatch) -> None:
    mapping = disc()
    w, solution = knotted(mapping)
    monkeypatch.setattr(approach, "_cleared_alone", lambda _: pytest.fail("a window within a window"))
    untangler = Untangler(mapping, w, solution, window=folds_widened(solution, 6), stiffness=None)
    assert run(steps_to_clear(untangler, "barrier", 16))


def test_what_relaxing_folds_is_cleared_again(monkeypatch: pytest.MonkeyPatch) -> None:
    mapping = disc()
    w, clear = knotted(mapping, knots=False)
    untangler = everywhere(mapping, w, clear)
    step = untangler.step

    def knotting(*arguments: object) -> bool:
        moved = step(*arguments)  # type: ignore[arg-type]
        untangler.z.reshape(GRID.shape)[KNOT] += 9.0
        return moved

    monkeypatch.setattr(untangler, "step", knotting)
    found = run(relaxed(untangler))
    assert not folded_quads(found.z).any()
    assert not np.array_equal(found.z, clear.z)


@pytest.mark.parametrize(
    ("worst", "folds", "end"),
    [(-1.0, 100, True), (-0.9, 90, True), (-0.1, 100, False), (-0.9, 40, False), (-0.4, 100, False)],
)
def test_folds_that_stay_deep_and_many_end_an_attempt(worst: float, folds: int, end: bool) -> None:
    """Before the last four steps the worst fold was 1 deep, or a tenth where it is shallow now, and there were 100."""
    before = -1.0 if worst < -0.1 else -0.1
    assert approach._is_hopeless([(4 * before, 300)] * 4 + [(before, 100)] * 4, worst, folds, 8) is end
    assert not approach._is_hopeless([(before, 100)] * 4, worst, folds, 8)


def test_a_fold_between_the_outline_and_a_held_feature_is_known_to_be_stuck() -> None:
    mask = np.zeros((SIDE, SIDE), np.uint8)
    mask[:60, 80:150] = 255
    mapping = FeatureMapping(GRID, find_features(GRID, mask))
    w = as_complex(GRID.nodes)
    right = mapping.place(w)
    pushed = mapping.place_at(w, right.alpha, right.t + 9.0)
    window, held = np.ones(GRID.shape, bool), np.full(1, np.inf)
    assert Untangler(mapping, w, right, window=window, stiffness=None).stuck > 0.5
    assert Untangler(mapping, w, pushed, window=window, stiffness=None).stuck < -0.5
    assert Untangler(mapping, w, pushed, window=window, stiffness=held).stuck > 0
