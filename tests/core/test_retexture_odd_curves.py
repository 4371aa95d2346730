"""Curves that meet, and what is shown while one is dragged into a shape that makes no sense."""

import numpy as np
import pytest

from core.arrays import Bytes, Points
from core.curves import Curve
from core.feature_curves import FeatureCurve
from core.grid import Grid
from core.progress import run
from core.retexture.job import retexture
from core.retexture.preview import LiveDeformation

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
