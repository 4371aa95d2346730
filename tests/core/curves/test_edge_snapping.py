"""Curves drawn beside an edge are brought onto it; those on an edge, or far from any, stay."""

import cv2
import numpy as np
import pytest

from core.curves.bezier import Curve
from core.curves.edge_snapping import snap_to_edge
from core.curves.feature_curves import FeatureCurve
from core.imaging.image import Image

HEIGHT, WIDTH = 160, 240


def line(y: float) -> Curve:
    """Return a nearly straight curve through the picture."""
    return Curve(np.array([[20.0, y], [90.0, y - 10], [150.0, y + 10], [220.0, y]]))


def two_halves(curve: Curve, noise: float = 4.0) -> Image:
    """Return a picture that is dark below a curve and light above it."""
    pixels = np.full((HEIGHT, WIDTH, 3), 190, np.float32)
    along = np.rint(curve.at(curve.parameters(step=1.0))).astype(np.int32)
    below = np.concatenate([[[0, along[0, 1]]], along, [[WIDTH, along[-1, 1]], [WIDTH, HEIGHT], [0, HEIGHT]]])
    cv2.fillPoly(pixels, [below.astype(np.int32)], (60, 70, 90))
    pixels += np.random.default_rng(1).normal(0, noise, pixels.shape)
    return Image(np.clip(np.rint(pixels), 0, 255).astype(np.uint8))


def gap(curve: Curve, other: Curve) -> float:
    """Return how far a curve is from another, in the mean, px."""
    t = np.linspace(0.1, 0.9, 50) * curve.segments
    return float(np.abs(other.nearest(curve.at(t))[1]).mean())


@pytest.mark.parametrize("off", [-9.0, -5.0, 4.0, 9.0])
def test_beside_an_edge_it_comes_onto_it(off: float) -> None:
    edge = line(80.0)
    drawn = Curve(edge.points + [0.0, off])
    found = snap_to_edge(two_halves(edge), FeatureCurve(drawn, drawn))
    assert np.abs(found.source.at(np.linspace(0.1, 0.9)) - edge.at(np.linspace(0.1, 0.9))).max() < 1.5


def test_the_motion_stays_what_it_was() -> None:
    edge = line(80.0)
    drawn, to = Curve(edge.points + [0.0, 6.0]), Curve(edge.points + [0.0, 46.0])
    found = snap_to_edge(two_halves(edge), FeatureCurve(drawn, to))
    assert found.target is not None
    moved = found.target.points - found.source.points
    assert np.abs(moved - [0.0, 40.0]).max() < 1e-6


@pytest.mark.parametrize("off", [0.0, 1.0])
def test_on_its_edge_it_stays(off: float) -> None:
    edge = line(80.0)
    curve = FeatureCurve(Curve(edge.points + [0.0, off]), line(110.0))
    assert snap_to_edge(two_halves(edge), curve) is curve


def test_where_there_is_no_edge_it_stays() -> None:
    noise = np.random.default_rng(2).integers(0, 255, (HEIGHT, WIDTH, 3), np.uint8)
    flat = np.full((HEIGHT, WIDTH, 3), 128, np.uint8)
    for pixels in (noise, flat):
        curve = FeatureCurve(line(80.0), line(100.0))
        assert snap_to_edge(Image(pixels), curve) is curve


def test_an_edge_beyond_its_reach_is_not_its_own() -> None:
    edge = line(60.0)
    curve = FeatureCurve(Curve(edge.points + [0.0, 25.0]), line(120.0))
    assert snap_to_edge(two_halves(edge), curve) is curve


def test_the_nearer_edge_of_a_thin_thing_is_followed_all_along() -> None:
    pixels = np.full((HEIGHT, WIDTH, 3), 200, np.uint8)
    cv2.rectangle(pixels, (0, 70), (WIDTH, 82), (60, 60, 60), -1)
    # Half of the far edge is stronger than the near one.
    pixels[83:, WIDTH // 2 :] = 255
    straight = Curve(np.array([[20.0, 74.0], [90.0, 74.0], [150.0, 74.0], [220.0, 74.0]]))
    found = snap_to_edge(Image(pixels), FeatureCurve(straight, straight)).source
    heights = found.at(np.linspace(0.1, 0.9))[:, 1]
    assert np.ptp(heights) < 2


def test_a_closed_curve_stays_closed() -> None:
    k = 0.5523
    circle = np.array(
        [
            [1, 0],
            [1, k],
            [k, 1],
            [0, 1],
            [-k, 1],
            [-1, k],
            [-1, 0],
            [-1, -k],
            [-k, -1],
            [0, -1],
            [k, -1],
            [1, -k],
            [1, 0],
        ]
    )
    pixels = np.full((HEIGHT, WIDTH, 3), 200, np.uint8)
    cv2.circle(pixels, (120, 80), 50, (40, 40, 40), -1)
    drawn = Curve(44.0 * circle + [120.0, 80.0], closed=True)
    found = snap_to_edge(Image(pixels), FeatureCurve(drawn, drawn)).source
    assert found.closed
    assert np.abs(np.linalg.norm(found.at(found.parameters(step=2.0)) - [120, 80], axis=1) - 50).max() < 1.5


def test_at_the_picture_edge_nothing_breaks() -> None:
    for y in (-3.0, 0.0, HEIGHT + 2.0):
        curve = FeatureCurve(line(y), line(60.0))
        snap_to_edge(two_halves(line(80.0)), curve)
