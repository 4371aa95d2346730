"""Charts keep angles, and lengths as far as that leaves them free."""

import numpy as np
import pytest

from core.arrays import Floats, Points
from core.surfaces.chart import flatten
from core.surfaces.shapes import SHAPES, make_shape

SHARES = np.random.default_rng(0).uniform(0.1, 0.9, (200, 2))


def slopes(name: str) -> tuple[Points, Points]:
    """Return how a chart changes per unit of length on its surface, along the texture's lines and square to them."""
    surface = make_shape(name)
    m = surface.stretch_at(SHARES)
    jacobian = np.stack([surface.chart.at(SHARES, across=1), surface.chart.at(SHARES, down=1)], axis=-1)
    found = jacobian @ np.linalg.inv(m)
    return found[..., 0], found[..., 1]


@pytest.mark.parametrize("name", list(SHAPES))
def test_charts_keep_angles(name: str) -> None:
    one, other = slopes(name)
    lengths = np.linalg.norm(one, axis=1), np.linalg.norm(other, axis=1)
    cosine = (one * other).sum(axis=1) / (lengths[0] * lengths[1])
    assert np.quantile(np.abs(np.log(lengths[0] / lengths[1])), 0.9) < 0.08
    assert np.quantile(np.abs(cosine), 0.9) < 0.08


@pytest.mark.parametrize("name", ["plane", "cylinder", "cone", "cube"])
def test_charts_of_what_can_be_unrolled_keep_lengths_too(name: str) -> None:
    one, other = slopes(name)
    lengths = np.linalg.norm(np.concatenate([one, other]), axis=1)
    assert np.quantile(lengths, 0.95) < 1.2 * np.quantile(lengths, 0.05)


def test_a_cylinder_is_as_wide_as_it_is_around() -> None:
    width, height = make_shape("cylinder").chart.size_px((1000, 1000))
    assert width / height == pytest.approx(np.pi, rel=0.01)
    assert width * height == pytest.approx(1e6, rel=0.01)


@pytest.mark.parametrize("name", list(SHAPES))
def test_places_of_a_chart_lead_back_to_the_texture(name: str) -> None:
    chart = make_shape(name).chart
    np.testing.assert_allclose(chart.texture_at(chart.at(SHARES)), SHARES, atol=1e-6)


def test_a_raster_is_where_its_places_are() -> None:
    chart = make_shape("torus").chart
    even = np.linspace(0, 1, 33)
    np.testing.assert_allclose(chart.on_raster(33), chart.at(np.stack(np.meshgrid(even, even), axis=-1)), atol=1e-12)


def test_the_warp_takes_the_picture_into_the_box_around_the_chart() -> None:
    chart = make_shape("sphere").chart
    width, height = chart.size_px((300, 200))
    x, y = np.meshgrid(np.linspace(-0.5, 299.5, 40), np.linspace(-0.5, 199.5, 40))
    found = chart.warp((300, 200))(np.stack([x, y], axis=-1))
    np.testing.assert_allclose(found.min(axis=(0, 1)), [-0.5, -0.5], atol=0.5)
    np.testing.assert_allclose(found.max(axis=(0, 1)), [width - 0.5, height - 0.5], atol=0.5)


def test_a_crumpled_texture_is_laid_flat_by_its_mean() -> None:
    chance = np.random.default_rng(1)

    def crumpled(share: Points) -> Floats:
        """Return lengths that differ a hundredfold between neighbours and directions, three times as long across."""
        turn = chance.uniform(0, np.pi, len(share))
        way = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        return np.asarray((np.eye(2) + 100 * way[:, :, None] * way[:, None, :]) * [[3.0], [1.0]])

    places = flatten(crumpled, 24).places
    edges = np.diff(places, axis=1)[:-1], np.diff(places, axis=0)[:, :-1]
    assert (edges[0][..., 0] * edges[1][..., 1] - edges[0][..., 1] * edges[1][..., 0] > 0).all()
    width, height = flatten(crumpled, 24).size_px((100, 100))
    assert width / height == pytest.approx(3, rel=0.2)
