import cv2
import numpy as np
import pytest

from core.arrays import Bytes, Ints
from core.grid import Grid, find_features
from core.mapping import scenes
from core.mapping.feature_mapping import FeatureMapping
from core.mapping.frames import as_complex
from core.mapping.junctions import can_fit, fit_between
from core.mapping.warping import warp_grid
from core.warps.presets import make_warp

WIDTH, HEIGHT = 240, 180
GRID = Grid(WIDTH, HEIGHT, cell_px=3)


def low_strip() -> Bytes:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    mask[147:168] = 255
    return mask


def standing() -> Bytes:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    mask[60:150, 70:150] = 255
    for left in (70, 100, 135):
        mask[150:, left : left + 15] = 255
    return mask


@pytest.mark.parametrize(("bend", "fits"), [(10, True), (50, False), (-50, True)])
def test_a_strip_cannot_fit_where_the_outline_between_its_ends_rises_through_it(bend: float, fits: bool) -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, low_strip()))
    w = as_complex(make_warp("arch", WIDTH, HEIGHT, bend=bend)(GRID.nodes))
    assert can_fit(mapping, w, mapping.place(w)) is fits


def test_only_what_lies_along_a_straight_side_between_two_cuts_is_kept_off_it() -> None:
    gate = np.zeros((HEIGHT, WIDTH), np.uint8)
    gate[60:80, 60:180] = gate[60:, 60:80] = gate[60:, 160:180] = 255
    corner = np.zeros((HEIGHT, WIDTH), np.uint8)
    cv2.line(corner, (-20, 60), (120, 200), 255, 20)
    for mask, count in ((gate, 0), (corner, 2)):
        mapping = FeatureMapping(GRID, find_features(GRID, mask))
        (scene,) = [scene for _, scene in scenes.scenes(mapping, 1)]
        assert len(scene.passed) == count
    for sides in scene.passed:
        along = GRID.nodes.reshape(-1, 2)[sides.nodes].sum(axis=1)
        assert along.min() > 60
        assert along.max() < 300


def test_a_strip_is_moved_to_where_the_outline_does_not_rise_through_it() -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, low_strip()), keep="similarity")
    plain = make_warp("arch", WIDTH, HEIGHT, bend=34)(GRID.nodes)
    w = as_complex(plain)
    linear, strip = mapping.place(w), mapping.index >= 0
    fitted = fit_between(mapping, w, linear)
    assert fitted is not None
    assert linear.z[strip].imag.max() > w[-1].imag.min() > fitted.z[strip].imag.max()
    result = warp_grid(GRID, mapping.features, plain)
    assert not result.folded.any()
    assert result.outline_moved_px == 0
    assert 0.4 < result.features[0].scale < 1


def test_the_outline_stays_at_w_where_a_third_of_a_strip_s_size_fits() -> None:
    plain = make_warp("arch", WIDTH, HEIGHT, bend=42)(GRID.nodes)
    result = warp_grid(GRID, find_features(GRID, low_strip()), plain)
    assert not result.folded.any()
    assert result.outline_moved_px == 0
    assert 0.1 < result.features[0].scale < 0.31


def test_what_the_edge_cuts_is_measured_once_per_mask(monkeypatch: pytest.MonkeyPatch) -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, standing()), keep="rigid")
    measured: list[FeatureMapping] = []
    corners = scenes._corners

    def counted(of: FeatureMapping) -> Ints:
        measured.append(of)
        return corners(of)

    monkeypatch.setattr(scenes, "_corners", counted)
    fitted = []
    for bend in (30, 45):
        w = as_complex(make_warp("arc", WIDTH, HEIGHT, bend=bend)(GRID.nodes))
        fitted.append(fit_between(mapping, w, mapping.place(w)))
        fresh = FeatureMapping(GRID, mapping.features, keep="rigid")
        again = fit_between(fresh, w, fresh.place(w))
        assert fitted[-1] is not None
        assert again is not None
        assert np.array_equal(fitted[-1].z, again.z)
    assert sum(m is mapping for m in measured) == 1
