import json

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from core.arrays import InputError
from core.grid import Grid, find_features
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.options import MappingOptions
from core.mapping.warper import Warper
from core.mapping.warping import warp_grid
from core.progress import run
from core.warps.presets import make_warp

WIDTH, HEIGHT = 160, 120
GRID = Grid(WIDTH, HEIGHT, cell_px=4)
MASK = np.zeros((HEIGHT, WIDTH), np.uint8)
MASK[30:70, 20:60] = MASK[60:110, 90:140] = 255
MASK[2, 2] = 255
FEATURES = find_features(GRID, MASK)
PLAIN = make_warp("arc", WIDTH, HEIGHT, bend=30)(GRID.nodes)


def test_the_report_is_json_with_every_figure() -> None:
    report = json.loads(json.dumps(warp_grid(GRID, FEATURES, PLAIN).report()))
    assert report["grid"] == list(GRID.shape)
    assert {"setup", "factor", "rhs", "solve", "unfold"} <= set(report["seconds"])
    assert report["folds"] == {"plain": 0, "warped": 0}
    assert [feature["id"] for feature in report["features"]] == [2, 3]
    assert all(feature["residual"] < 1e-10 for feature in report["features"])
    assert all(feature["nodes"] == (FEATURES.labels == feature["id"]).sum() for feature in report["features"])


def test_scale_and_angle_are_those_of_the_feature() -> None:
    turned = (GRID.nodes @ np.array([[0.0, 2.0], [-2.0, 0.0]])) + 7
    for feature in warp_grid(GRID, FEATURES, turned).features:
        assert feature.scale == pytest.approx(2)
        assert feature.angle_deg == pytest.approx(90)


def test_keep_none_gives_the_plain_warp() -> None:
    warped = warp_grid(GRID, FEATURES, PLAIN, options=MappingOptions(keep="none"))
    assert np.array_equal(warped.warped, PLAIN)


def test_a_live_warp_gives_what_one_call_gives() -> None:
    live = Warper(GRID)
    live.use(find_features(GRID, None), MappingOptions(keep="rigid"))
    live.frame(PLAIN)
    live.use(FEATURES, MappingOptions())
    assert np.array_equal(run(live.settle(PLAIN)).warped, warp_grid(GRID, FEATURES, PLAIN).warped)


def test_the_same_mask_is_not_factorised_again() -> None:
    live = Warper(GRID)
    live.use(FEATURES, MappingOptions())
    live.frame(PLAIN)
    live.use(FEATURES, MappingOptions())
    seconds = live.frame(PLAIN + 1).seconds
    assert seconds["factor"] == seconds["setup"] == 0
    assert seconds["solve"] > 0


def test_a_warp_that_is_not_finite_is_refused() -> None:
    broken = PLAIN.copy()
    broken[3, 3] = np.nan
    with pytest.raises(InputError, match="finite"):
        warp_grid(GRID, FEATURES, broken)


@pytest.mark.parametrize(("option", "value"), [("weight", 0.0), ("weight", float("nan")), ("falloff", -1.0)])
def test_impossible_options_are_refused(option: str, value: float) -> None:
    with pytest.raises(InputError, match=option):
        warp_grid(GRID, FEATURES, PLAIN, options=MappingOptions(**{option: value}))  # type: ignore[arg-type]


def test_features_of_another_grid_are_refused() -> None:
    with pytest.raises(InputError, match="another grid"):
        FeatureMapping(Grid(WIDTH, HEIGHT, cell_px=5), FEATURES)


@pytest.mark.parametrize("count", [1, 40])
def test_any_number_of_features_keep_their_shape(count: int) -> None:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    for i in range(count):
        row, column = divmod(i, 8)
        mask[4 + 22 * row : 18 + 22 * row, 4 + 19 * column : 16 + 19 * column] = 255
    features = find_features(GRID, mask)
    assert len(features) == count
    assert max(f.residual for f in warp_grid(GRID, features, PLAIN, allow_folds=True).features) < 1e-10


def test_a_map_has_the_same_bits_whatever_number_of_threads_blas_may_have() -> None:
    grid = Grid(WIDTH, HEIGHT, cell_px=1)
    features, plain = find_features(grid, MASK), make_warp("swirl", WIDTH, HEIGHT, bend=100)(grid.nodes)
    found = []
    for threads in (1, 2):
        with threadpool_limits(threads, "blas"):
            found.append(warp_grid(grid, features, plain, options=MappingOptions(keep="rigid")).warped)
    assert np.array_equal(found[0], found[1])
