"""Every preset is the identity at rest, never folds, and is a shape of its own."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.arrays import InputError, Points
from core.warps.presets import PRESETS, make_warp
from core.warps.warp import in_parts

SHAPES = [name for name in PRESETS if name != "none"]
NAMES = st.sampled_from(SHAPES)
PERCENT = st.floats(-100, 100)


def nodes(width_px: int, height_px: int, number: int = 15000) -> Points:
    cell = np.sqrt(width_px * height_px / number)
    x, y = (np.linspace(-0.5, size - 0.5, round(size / cell) + 2) for size in (width_px, height_px))
    return np.stack(np.meshgrid(x, y), axis=-1)


def count_folds(positions: Points) -> int:
    corners = np.stack([positions[:-1, :-1], positions[:-1, 1:], positions[1:, 1:], positions[1:, :-1]], axis=2)
    ahead, behind = np.roll(corners, -1, axis=2) - corners, np.roll(corners, 1, axis=2) - corners
    return int((ahead[..., 0] * behind[..., 1] - ahead[..., 1] * behind[..., 0] <= 0).any(axis=-1).sum())


def distance_from_similarity(rest: Points, moved: Points) -> float:
    p, q = (a.reshape(-1, 2) @ np.array([1, 1j]) for a in (rest, moved))
    p, q = p - p.mean(), q - q.mean()
    fitted = np.vdot(p, q) / np.vdot(p, p) * p
    return float(np.sqrt((abs(q - fitted) ** 2).mean() / (abs(fitted) ** 2).mean()))


@pytest.mark.parametrize("name", PRESETS)
def test_no_bend_is_the_identity(name: str) -> None:
    rest = nodes(300, 200)
    np.testing.assert_array_equal(make_warp(name, 300, 200)(rest), rest)


@pytest.mark.parametrize("name", SHAPES)
def test_a_little_bend_moves_little(name: str) -> None:
    rest = nodes(300, 200)
    for bend in (-1e-3, 1e-3):
        assert np.abs(make_warp(name, 300, 200, bend=bend)(rest) - rest).max() < 0.02


@settings(max_examples=150)
@given(NAMES, PERCENT, PERCENT, PERCENT, st.booleans(), st.sampled_from([(300, 200), (200, 300), (640, 90), (1, 1)]))
def test_nothing_folds(
    name: str, bend: float, across: float, down: float, upright: bool, size: tuple[int, int]
) -> None:
    warp = make_warp(name, *size, bend=bend, horizontal=across, vertical=down, vertical_axis=upright)
    moved = warp(nodes(*size))
    assert np.isfinite(moved).all()
    assert count_folds(moved) == 0


@pytest.mark.parametrize("bend", [-100, 100])
@pytest.mark.parametrize("name", SHAPES)
def test_nothing_folds_at_the_ends(name: str, bend: float) -> None:
    assert count_folds(make_warp(name, 300, 200, bend=bend)(nodes(300, 200))) == 0


@pytest.mark.parametrize("bend", [-50, 50, 40])
def test_each_preset_is_a_shape_of_its_own(bend: float) -> None:
    rest = nodes(480, 320, 1600)
    moved = {name: make_warp(name, 480, 320, bend=bend)(rest) for name in SHAPES}
    for name, positions in moved.items():
        assert distance_from_similarity(rest, positions) > 0.01, name
    for (one, a), (other, b) in itertools.combinations(moved.items(), 2):
        difference = (a - a.mean((0, 1))) - (b - b.mean((0, 1)))
        assert np.sqrt((difference**2).sum(-1).mean()) > 1, (one, other)


@pytest.mark.parametrize("size", [(1, 1), (1, 5000), (5000, 1)])
@pytest.mark.parametrize("name", SHAPES)
def test_thin_pictures_have_a_place_for_every_point(name: str, size: tuple[int, int]) -> None:
    for bend in (-100, 100):
        assert np.isfinite(make_warp(name, *size, bend=bend, horizontal=50, vertical_axis=True)(nodes(*size))).all()


def test_vertical_axis_turns_the_shape() -> None:
    up = make_warp("arc-upper", 100, 100, bend=50)(np.array([[49.5, -0.5]]))
    right = make_warp("arc-upper", 100, 100, bend=50, vertical_axis=True)(np.array([[99.5, 49.5]]))
    np.testing.assert_allclose(up, [[49.5, -25.5]])
    np.testing.assert_allclose(right, [[124.5, 49.5]])


def test_horizontal_distortion_enlarges_the_right_side() -> None:
    corners = np.array([[-0.5, -0.5], [99.5, -0.5], [99.5, 99.5], [-0.5, 99.5]])
    moved = make_warp("none", 100, 100, horizontal=100)(corners)
    np.testing.assert_allclose(moved, [[-0.5, 24.5], [99.5, -25.5], [99.5, 124.5], [-0.5, 74.5]])


def test_perspective_takes_the_corners_where_they_are_told() -> None:
    given_settings = {"top-left-x": 10.0, "top-left-y": 20.0, "bottom-right-x": -5.0}
    warp = make_warp("perspective", 200, 100, settings=given_settings)
    corners = np.array([[-0.5, -0.5], [199.5, -0.5], [199.5, 99.5], [-0.5, 99.5]])
    moved = corners + [[20, 20], [0, 0], [-10, 0], [0, 0]]
    np.testing.assert_allclose(warp(corners), moved, atol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"name": "qqqq"}, "'qqqq': unknown; one of none, arc,"),
        ({"name": "arc", "bend": 101}, "bend 101: not from -100 to 100"),
        ({"name": "arc", "vertical": float("nan")}, "vertical nan"),
        ({"name": "arc", "settings": {"waves": 2.0}}, "no setting 'waves'"),
        ({"name": "flag", "settings": {"waves": 99.0}}, "waves 99"),
        ({"name": "perspective", "settings": {"top-left-x": 100.0, "top-left-y": 100.0}}, "convex"),
    ],
)
def test_what_cannot_be_is_named(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make_warp(width_px=100, height_px=100, **arguments)  # type: ignore[arg-type]


def test_a_misspelt_name_has_neighbours() -> None:
    with pytest.raises(InputError, match="unknown; did you mean arc-lower"):
        make_warp("arc-louer", 10, 10)


def test_parts_are_warped_as_all_at_once() -> None:
    points = np.random.default_rng(0).uniform(0, 300, (260, 130, 2))
    warp = make_warp("swirl", 300, 300, bend=40)
    assert np.array_equal(in_parts(warp, points), warp(points))
