"""What the live answer owes to the one at rest: the same features, and nodes in the same cells."""

import cv2
import numpy as np
import pytest

from core.arrays import Bytes, Floats, Points
from core.grid import Grid, find_features
from core.linalg.multifrontal import GridFactor
from core.mapping.features.feature_mapping import FeatureMapping, Keep
from core.mapping.handles.curved_frame import cuts_of, fit_cuts
from core.mapping.jacobians import Complexes, as_complex
from core.mapping.options import MappingOptions
from core.mapping.warper import Warper
from core.mapping.warping import warp_grid
from core.progress import run
from core.warps.presets import make_warp

WIDTH, HEIGHT, CELL = 320, 240, 4
GRID = Grid(WIDTH, HEIGHT, cell_px=CELL)
KEEPS: list[Keep] = ["similarity", "rigid"]


def three_discs() -> Bytes:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    for x, y, radius in ((80, 70, 30), (230, 80, 35), (160, 180, 40)):
        cv2.circle(mask, (x, y), radius, 255, -1)
    return mask


def cut_by_the_edge() -> Bytes:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    cv2.circle(mask, (160, HEIGHT), 70, 255, -1)
    cv2.circle(mask, (30, 0), 30, 255, -1)
    return mask


def bent(preset: str, bend: float) -> Points:
    return make_warp(preset, WIDTH, HEIGHT, bend=bend)(GRID.nodes)


def cells_apart(a: Points, b: Points) -> Floats:
    return np.asarray(np.hypot(*np.moveaxis(a - b, -1, 0)) / CELL)


@pytest.mark.parametrize("keep", KEEPS)
@pytest.mark.parametrize(("preset", "bend"), [("swirl", 20), ("arc", 30), ("flag", 30), ("bulge", 40), ("squeeze", 30)])
def test_live_and_at_rest_are_the_same_where_nothing_folds(preset: str, bend: float, keep: Keep) -> None:
    live, plain = Warper(GRID), bent(preset, bend)
    live.use(find_features(GRID, three_discs()), MappingOptions(keep=keep))
    shown = live.frame(plain)
    assert not shown.folded.any()
    assert np.array_equal(shown.warped, run(live.settle(plain)).warped)


@pytest.mark.parametrize(("preset", "bend"), [("arc", 60), ("arc", 80), ("inflate", 60), ("inflate", 80)])
def test_features_at_the_edge_do_not_jump_when_all_rests(preset: str, bend: float) -> None:
    features, plain = find_features(GRID, cut_by_the_edge()), bent(preset, bend)
    live = Warper(GRID)
    live.use(features, MappingOptions())
    rest = warp_grid(GRID, features, plain).warped
    assert cells_apart(live.frame(plain).warped, rest).max() < 0.1


@pytest.mark.parametrize(("preset", "bend"), [("arc", 5), ("arc", 60), ("swirl", 30)])
def test_a_frame_costs_one_substitution_back(preset: str, bend: float, monkeypatch: pytest.MonkeyPatch) -> None:
    live = Warper(GRID)
    live.use(find_features(GRID, cut_by_the_edge()), MappingOptions())
    live.frame(bent(preset, bend / 2))
    backward, calls = GridFactor.backward, []

    def counted(factor: GridFactor, y: Floats) -> Floats:
        calls.append(y)
        return backward(factor, y)

    monkeypatch.setattr(GridFactor, "backward", counted)
    assert live.frame(bent(preset, bend)).seconds["solve"] > 0
    assert len(calls) == 1


@pytest.mark.parametrize("keep", KEEPS)
def test_a_stroke_beside_other_features_shows_what_stays_when_all_rests(keep: Keep) -> None:
    mask, plain = three_discs(), bent("swirl", 25)
    live, options = Warper(GRID), MappingOptions(keep=keep)
    live.use(find_features(GRID, mask), options)
    live.frame(plain)
    for angle in np.linspace(-1, 2, 12):
        cv2.circle(mask, (round(80 + 28 * np.cos(angle)), round(70 + 28 * np.sin(angle))), 12, 255, -1)
        live.use(find_features(GRID, mask), options)
        shown = live.frame(plain)
        whole = FeatureMapping(GRID, find_features(GRID, mask), keep=keep).solve(plain)
        assert cells_apart(shown.warped, whole).max() < 0.5
        assert max(feature.residual for feature in shown.features) < 1e-10


def test_a_stroke_that_makes_joins_and_removes_features_shows_all_of_them() -> None:
    mask, plain = three_discs(), bent("arc", 25)
    live = Warper(GRID)
    dabs = [((160, 40), 10, 255), ((140, 60), 20, 255), ((110, 65), 20, 255), ((230, 80), 60, 0), ((40, 200), 15, 255)]
    for place, radius, value in dabs:
        live.use(find_features(GRID, mask), MappingOptions())
        live.frame(plain)
        cv2.circle(mask, place, radius, value, -1)
        features = find_features(GRID, mask)
        live.use(features, MappingOptions())
        shown = live.frame(plain)
        assert [feature.id for feature in shown.features] == list(features.ids)
        assert max(feature.residual for feature in shown.features) < 1e-10
        assert cells_apart(shown.warped, FeatureMapping(GRID, features).solve(plain)).max() < 1


def test_features_that_a_stroke_leaves_alone_find_their_place_in_turn() -> None:
    before, after = three_discs(), three_discs()
    cv2.circle(after, (95, 80), 40, 255, -1)
    plain, live = bent("swirl", 40), Warper(GRID)
    live.use(find_features(GRID, before), MappingOptions())
    live.frame(plain)
    apart = []
    for frame in range(13):
        mask = after.copy()
        mask[40, 80] = 0 if frame % 2 else 255
        mask[110:116, 60:70] = 255 if frame % 2 else 0
        features = find_features(GRID, mask)
        live.use(features, MappingOptions())
        apart.append(cells_apart(live.frame(plain).warped, FeatureMapping(GRID, features).solve(plain)).max())
    assert apart[0] > 0.5
    assert apart[-1] < 0.1 * apart[0]


def test_all_features_are_placed_when_one_goes_or_two_come() -> None:
    grid = Grid(WIDTH, HEIGHT, cell_px=2)
    live, plain = Warper(grid), make_warp("swirl", WIDTH, HEIGHT, bend=40)(grid.nodes)
    fewer = np.where(np.arange(HEIGHT)[:, None] > 130, 0, three_discs()).astype(np.uint8)
    for mask in (three_discs(), fewer, np.zeros_like(fewer), fewer):
        features = find_features(grid, mask)
        live.use(features, MappingOptions())
        assert np.array_equal(live.frame(plain).warped, FeatureMapping(grid, features).solve(plain))


def test_another_w_places_all_features_at_once() -> None:
    live = Warper(GRID)
    mask = three_discs()
    for bend in (10, 40):
        plain = bent("swirl", bend)
        live.use(find_features(GRID, mask), MappingOptions())
        shown = live.frame(plain)
        assert np.array_equal(shown.warped, FeatureMapping(GRID, find_features(GRID, mask)).solve(plain))
        cv2.circle(mask, (80, 70), 36, 255, -1)


def test_features_held_where_the_best_mapping_has_them_leave_it_as_it_is() -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, three_discs()))
    w = as_complex(bent("swirl", 30))
    best = mapping.place(w)
    for moving in ([True, False, False], [False, True, True], [False, False, False]):
        found = mapping.follow(mapping.pose(w, best.alpha, best.t, moving=np.array(moving)))
        assert np.abs(found.z - best.z).max() < 1e-8


@pytest.mark.parametrize(
    ("preset", "bend", "keep"), [("arc", 60, "similarity"), ("inflate", 80, "similarity"), ("inflate", 80, "rigid")]
)
def test_features_that_a_curved_frame_cuts_have_room_between_its_nodes(preset: str, bend: float, keep: Keep) -> None:
    mapping, w = FeatureMapping(GRID, find_features(GRID, cut_by_the_edge()), keep=keep), as_complex(bent(preset, bend))
    cuts, before = cuts_of(mapping), mapping.place(w)
    alpha, t = fit_cuts(cuts, w, before.alpha, before.t)

    def least_room(alpha: Complexes, t: Complexes) -> float:
        """Return the least share of its room that a corner between a cut feature and the frame has."""
        seen = [(w.ravel()[cut.outside] - t[cut.number]) / alpha[cut.number] - cut.a for cut in cuts]
        areas = [(np.conj(cut.b - cut.a) * q).imag / cut.room for cut, q in zip(cuts, seen, strict=True)]
        return float(np.concatenate(areas).min())

    assert len(cuts) == 2
    assert least_room(before.alpha, before.t) < 0
    assert least_room(alpha, t) > 0.999
