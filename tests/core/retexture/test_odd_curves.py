"""Curves that meet, and what is shown while one is dragged into a shape that makes no sense."""

import tracemalloc

import numpy as np
import pytest

from core.arrays import Bytes, CurveError, Points
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve
from core.grid import Grid
from core.progress import run
from core.retexture.deformation.preview import LiveDeformation
from core.retexture.job import retexture

WIDTH, HEIGHT = 180, 130


def line(*points: tuple[float, float]) -> Curve:
    first, last = np.array(points, float)
    return Curve(np.linspace(first, last, 4))


def moved(curve: Curve, x: float, y: float) -> FeatureCurve:
    return FeatureCurve(curve, Curve(curve.points + [x, y]))


def rows() -> Bytes:
    """Return a picture whose pixels say how far down they come from."""
    grain = np.random.default_rng(4).integers(0, 20, (HEIGHT, WIDTH))
    return np.repeat((np.arange(HEIGHT)[:, None] + grain)[..., None], 3, axis=2).astype(np.uint8)


GRAZING = np.array([(20, 40), (70, 67), (110, 67), (160, 40)], float)
TOUCHING = [
    pytest.param(line((20, 40), (160, 40)), line((90, 40), (90, 110)), id="an end on a curve"),
    pytest.param(line((20, 40), (90, 60)), line((90, 60), (160, 40)), id="an end on an end"),
    pytest.param(
        line((20, 60), (160, 60)),
        Curve(np.array([(20, 40), (70, 67), (110, 67), (160, 40)], float)),
        id="a curve grazed",
    ),
    pytest.param(line((20, 60), (160, 60)), line((20, 60), (160, 60)), id="the same curve twice"),
]


@pytest.mark.parametrize(("first", "second"), TOUCHING)
def test_curves_that_touch_are_moved_together(first: Curve, second: Curve) -> None:
    found = run(retexture(rows(), [moved(first, 0, 9), moved(second, 0, 9)]))
    assert np.isfinite(found.place).all()
    for curve in (first, second):
        at = np.rint(curve.at(np.linspace(0.15, 0.85, 30)) + [0, 9]).astype(int)
        off = curve.nearest(found.place[at[:, 1], at[:, 0]].astype(float))[1]
        assert np.median(off) < 1.5
        assert off.max() < 9


def test_of_two_targets_on_one_place_every_pixel_comes_from_between_their_sources() -> None:
    target = line((20, 65), (160, 65))
    curves = [FeatureCurve(line((20, 45), (160, 45)), target), FeatureCurve(line((20, 85), (160, 85)), target)]
    found = run(retexture(rows(), curves))
    down = found.place[65, 30:150, 1]
    assert 35 < down.min() <= down.max() < 95
    assert np.abs(found.place[5, :, 1] - 5).max() < 12


ODD = {
    "a target that crosses itself": [[20, 40], [190, 120], [-10, 120], [160, 40]],
    "a target folded tightly": [[20, 60], [240, 60], [240, 61], [20, 61]],
    "a target run backwards": [[160, 60], [110, 60], [70, 60], [20, 60]],
    "a target shrunk to a point": [[90, 60], [90, 60], [90, 60], [90, 60.001]],
    "a target partly outside": [[90, 60], [150, 90], [250, 90], [400, 60]],
    "a target wholly outside": [[-90, 60], [-90, 90], [-80, 90], [-80, 60]],
    "a target with coincident points": [[20, 50], [20, 50], [160, 90], [160, 90]],
}


@pytest.mark.parametrize("target", list(ODD.values()), ids=list(ODD))
@pytest.mark.parametrize("reach_px", [None, 25.0])
def test_the_live_deformation_of_an_odd_target_stays_near_the_picture(target: Points, reach_px: float | None) -> None:
    nodes = Grid(WIDTH, HEIGHT, cell_px=6.0).nodes
    live = LiveDeformation((HEIGHT, WIDTH), nodes, reach_px=reach_px)
    source = line((20, 40), (160, 40))
    places = live.solve(
        [FeatureCurve(source, Curve(np.array(target))), FeatureCurve(source, line((20, 90), (160, 90)))]
    )
    assert np.isfinite(places).all()
    # The field is a mean of what the curves say: it asks for nothing beyond them.
    reach = max(float(np.abs(source.points - target).max()), 50.0)
    assert np.abs(places - nodes).max() < 1.5 * reach
    assert np.abs(places[0] - nodes[0]).max() < 1


BACKWARD = [
    pytest.param([(8, 24), (0, 24), (50, 24), (44, 24)], id="beyond both ends and back"),
    pytest.param([(8, 24), (44, 24), (44, 24), (8.5, 24)], id="there and back"),
    pytest.param([(8, 24), (40, 24), (10, 24), (44, 24)], id="handles crossed"),
    pytest.param([(8, 24), (60, 24), (-10, 24), (44, 24)], id="handles crossed beyond the ends"),
    pytest.param([(8, 24), (80, 60), (-30, 60), (44, 24)], id="a loop"),
    pytest.param([(8, 24), (8, 24), (44, 24), (44, 24)], id="handles on their knots"),
    pytest.param([(26, 4), (26, 34), (26, 34), (26, 4.5)], id="down and up"),
    pytest.param([(8, 24), (20, 24), (30, 24), *[(44, 24)] * 4], id="a segment that is a point"),
    pytest.param([*[(8, 24)] * 4, (20, 24), (30, 24), (44, 24)], id="a segment that is a point at the beginning"),
]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("points", BACKWARD)
@pytest.mark.parametrize("turned", [False, True])
def test_a_curve_that_runs_back_on_itself_is_followed(points: list[tuple[float, float]], turned: bool) -> None:
    plain, odd = line((8, 20), (44, 20)), Curve(np.array(points, float))
    curve = FeatureCurve(odd, plain) if turned else FeatureCurve(plain, odd)
    found = run(retexture(rows()[:40, :56], [curve]))
    assert np.isfinite(found.place).all()
    assert np.isfinite(odd.tangent(odd.parameters())).all()
    assert np.allclose(np.linalg.norm(odd.tangent(odd.parameters(step=0.1)), axis=1), 1)


@pytest.mark.parametrize("turned", [False, True])
def test_a_control_point_out_of_all_bounds_is_refused_at_once(turned: bool) -> None:
    plain, far = line((8, 20), (44, 20)), Curve(np.array([(8, 24), (-1e5, 24), (32, -1e5), (44, 24)], float))
    curve = FeatureCurve(far, plain) if turned else FeatureCurve(plain, far)
    tracemalloc.start()
    with pytest.raises(CurveError, match=r"curve 1: its (source|target) has a point that lies over 32 pictures away"):
        run(retexture(rows()[:40, :56], [curve]))
    assert tracemalloc.get_traced_memory()[1] < 10e6
    tracemalloc.stop()


@pytest.mark.parametrize("turned", [False, True])
def test_a_control_point_far_outside_costs_no_memory_for_what_no_picture_has(turned: bool) -> None:
    plain, far = line((8, 20), (44, 20)), Curve(np.array([(8, 24), (-1500, 24), (32, -1500), (44, 24)], float))
    curve = FeatureCurve(far, plain) if turned else FeatureCurve(plain, far)
    tracemalloc.start()
    found = run(retexture(rows()[:40, :56], [curve]))
    assert np.isfinite(found.place).all()
    assert tracemalloc.get_traced_memory()[1] < 100e6
    tracemalloc.stop()


ARCH = FeatureCurve(line((10, 80), (170, 80)), Curve(np.array([(10, 80), (60, 40), (120, 40), (170, 80)], float)))


def test_a_picture_of_one_colour_stays_that() -> None:
    pixels = np.full((HEIGHT, WIDTH, 3), (90, 140, 30), np.uint8)
    assert np.array_equal(run(retexture(pixels, [ARCH])).apply(pixels), pixels)


def test_a_picture_of_noise_stays_noise() -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (HEIGHT, WIDTH, 3), np.uint8)
    found = run(retexture(pixels, [ARCH]))
    shown, grown = found.apply(pixels), found.label > 0
    assert grown.mean() > 0.05
    assert abs(float(shown[grown].mean()) - 127.5) < 12  # mixed in linear light, which is a little brighter
    assert shown[grown].std() > 0.85 * pixels.std()


def test_a_curve_that_crosses_what_is_kept_leaves_it_whole() -> None:
    pixels = np.full((HEIGHT, WIDTH, 3), 60, np.uint8) + np.random.default_rng(2).integers(
        0, 40, (HEIGHT, WIDTH, 1), np.uint8
    )
    pixels[10:122, 84:96] = 250
    shown = run(retexture(pixels, [ARCH])).apply(pixels)
    widths = (shown[..., 0] > 180).sum(axis=1)[14:108]
    assert widths.min() > 7
    assert widths.max() < 17
