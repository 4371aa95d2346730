"""Laying textures into cloth."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.arrays import InputError
from core.overlay.composition import Norm, Placement, compose, compose_layers, middle_of, rows_deg
from core.overlay.filters.texture_filter import DENSITY, filter_texture
from core.overlay.texel import Texel, estimate_texel
from tests.core.overlay.overlay_scenes import grid

RNG = np.random.default_rng(0)
SCALE = np.array([[20.0, 2.0], [0.0, 18.0]])


@pytest.mark.parametrize(
    "basis", [[[20.9, -14.4], [27.6, 28.3]], [[25.4, 0.0], [0.0, 28.3]], [[30.0, 14.0], [2.0, 20.0]]]
)
def test_mean_texel_on_its_own_cloth_is_laid_as_it_is(basis: list[list[float]]) -> None:
    scale = np.array(basis)
    # The sides are whole numbers in the small picture of a photo four times as large.
    width, height = 4 * np.rint(DENSITY / 4 * np.linalg.norm(scale, axis=0)).astype(int)
    y, x = np.indices((40, 50)).astype(float)
    uv = np.stack([x, y], -1) @ np.linalg.inv(scale).T + 0.3
    texture = RNG.random((height, width, 3))
    flat, none = np.ones((40, 50)), np.zeros((40, 50, 3))
    assert np.allclose(compose(texture, uv, flat, none, scale)[0], filter_texture(texture, uv), atol=1e-5)


def test_without_minification_the_filter_is_bilinear() -> None:
    texture = RNG.random((24, 24, 3))
    uv = grid()
    assert np.allclose(filter_texture(texture, uv), Texel(texture)(uv), atol=1e-5)


def test_strong_minification_gives_the_mean() -> None:
    texture = RNG.random((64, 64, 3))
    shown = filter_texture(texture, grid(pixels_per_copy=0.9))
    assert np.abs(shown - texture.mean((0, 1))).max() < 0.06


def test_minification_in_one_direction_keeps_the_other_sharp() -> None:
    rows = np.zeros((32, 32, 3))
    rows[:, ::2] = 1.0
    columns = grid() * [4.0, 0.2]
    across = filter_texture(rows, columns)
    along = filter_texture(rows.swapaxes(0, 1), columns)
    assert across.std() < 0.1
    assert along.std() > 0.2


def test_nan_places_are_empty() -> None:
    uv = grid()
    uv[:10] = np.nan
    assert (filter_texture(np.ones((8, 8, 3)), uv)[:10] == 0).all()


def test_a_jump_between_pieces_does_not_blur() -> None:
    texture = RNG.random((24, 24, 3))
    uv = grid()
    moved = uv.copy()
    moved[:, 25:] += 37.0
    assert np.allclose(filter_texture(texture, uv), filter_texture(texture, moved), atol=1e-4)


@settings(max_examples=20)
@given(u=st.integers(-3, 3), v=st.integers(-3, 3))
def test_whole_copies_of_offset_change_nothing(u: int, v: int) -> None:
    uv, flat = grid(), np.ones((40, 50))
    texture, detail = RNG.random((20, 20, 3)), np.zeros((40, 50, 3))
    plain, _ = compose(texture, uv, flat, detail, SCALE)
    moved, _ = compose(texture, uv, flat, detail, SCALE, placement=Placement(offset=(u, v)))
    assert np.allclose(plain, moved, atol=1e-4)


def test_alpha_and_strength_weigh_detail_and_shading() -> None:
    uv = grid()
    shading = 0.5 + uv[..., 0] / 5
    detail = RNG.normal(0, 0.05, (40, 50, 3))
    white = np.ones((4, 4, 3))
    full, _ = compose(white, uv, shading, detail, SCALE)
    assert np.allclose(full, shading[..., None] + detail, atol=1e-6)
    flat, _ = compose(white, uv, shading, detail, SCALE, alpha=0.0, strength=0.0)
    assert np.allclose(flat, np.median(shading), atol=1e-6)


def test_outside_and_transparent_texture_have_no_opacity() -> None:
    uv = grid()
    uv[:, :10] = np.nan
    clear = np.concatenate([RNG.random((8, 8, 3)), np.zeros((8, 8, 1))], -1)
    assert (compose(clear, uv, np.ones((40, 50)), np.zeros((40, 50, 3)), SCALE)[1] == 0).all()
    solid = compose(RNG.random((8, 8, 3)), uv, np.ones((40, 50)), np.zeros((40, 50, 3)), SCALE)[1]
    assert (solid[:, :10] == 0).all()
    assert (solid[:, 10:] == 1).all()


def test_mirror_joins_copies_without_an_edge() -> None:
    ramp = np.broadcast_to(np.linspace(0, 1, 20)[None, :, None], (20, 20, 3)).copy()
    uv, flat, none = grid(), np.ones((40, 50)), np.zeros((40, 50, 3))
    plain = compose(ramp, uv, flat, none, SCALE)[0]
    mirrored = compose(ramp, uv, flat, none, SCALE, placement=Placement(mirror=True))[0]
    assert np.abs(np.diff(plain[..., 0], axis=1)).max() > 0.4
    assert np.abs(np.diff(mirrored[..., 0], axis=1)).max() < 0.1


def test_a_single_copy_lies_on_the_middle() -> None:
    uv = grid((60, 60))
    placement = Placement(repeat=(0.5, 0.5), tile=False)
    opacity = compose(
        np.ones((8, 8, 3)), uv, np.ones((60, 60)), np.zeros((60, 60, 3)), np.eye(2) * 20, placement=placement
    )[1]
    rows, columns = np.nonzero(opacity)
    assert abs(rows.mean() - 29.5) < 1
    assert abs(columns.mean() - 29.5) < 1
    assert opacity.sum() == pytest.approx(40 * 40, rel=0.1)


def test_rotation_turns_the_texture_in_the_plane_of_the_cloth() -> None:
    turned = Placement(rotate_deg=90.0).matrix(np.diag([30.0, 10.0]))
    assert np.allclose(turned, np.array([[0.0, 1 / 3], [-3.0, 0.0]]), atol=1e-9)


LEANING = np.array([[20.0, 19.0], [-12.0, 13.0]])


def test_an_upright_copy_does_not_lean_where_texels_do() -> None:
    for rotate_deg in (0.0, 33.0):
        to_px = LEANING @ np.linalg.inv(Placement((0.2, 0.2), rotate_deg, upright=True).matrix(LEANING))
        across, down = to_px.T
        assert across @ down == pytest.approx(0, abs=1e-9)
        assert np.linalg.norm(across) == pytest.approx(5 * np.linalg.norm(LEANING[:, 0]))
        assert np.linalg.norm(down) == pytest.approx(5 * np.linalg.norm(LEANING[:, 1]))
        assert across[0] * down[1] > across[1] * down[0]
        rows = LEANING.sum(1)
        angle = np.degrees(np.arctan2(across[1], across[0]) - np.arctan2(rows[1], rows[0]))
        assert angle == pytest.approx(rotate_deg)


@pytest.mark.parametrize(
    ("sides", "turned", "rows"),
    [((20, 20), 0, 0), ((20, 30), 25, 25), ((20, 20), 45, 0), ((20, 30), 80, -10), ((20, 30), 170, -10)],
)
def test_rows_are_nearly_level(sides: tuple[float, float], turned: float, rows: float) -> None:
    angle = np.radians(turned)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    assert rows_deg(turn @ np.diag(sides)) == pytest.approx(rows)


def test_upright_is_as_the_texel_where_that_is_upright() -> None:
    scale, placed = np.diag([30.0, 10.0]), {"repeat": (0.5, 0.25), "rotate_deg": 20.0}
    assert np.allclose(Placement(**placed, upright=True).matrix(scale), Placement(**placed).matrix(scale))  # type: ignore[arg-type]  # the two above


def test_an_impossible_placement_is_refused() -> None:
    with pytest.raises(InputError, match="repeat"):
        Placement(repeat=(0.0, 1.0))


def test_texel_estimate_inverts_sampling() -> None:
    truth = Texel(RNG.random((9, 11, 3)))
    uv = RNG.random((120, 120, 2)) * 7
    light = 0.5 + RNG.random((120, 120))
    photo = light[..., None] * truth(uv)
    photo[:20] = 0.0
    weight = np.ones((120, 120))
    found = estimate_texel(photo, uv, light, weight, (9, 11), rounds=40)
    assert np.abs(found.pixels - truth.pixels).max() < 0.05


def test_blurring_a_texel_keeps_its_mean_and_takes_its_contrast() -> None:
    texel = Texel(RNG.random((16, 16, 3)))
    soft = texel.blurred(4.0, SCALE)
    assert np.allclose(soft.pixels.mean((0, 1)), texel.pixels.mean((0, 1)))
    assert soft.pixels.std(axis=(0, 1)).max() < 0.2 * texel.pixels.std(axis=(0, 1)).min()


def test_repeat_puts_that_many_copies_on_a_texel() -> None:
    uv, flat, none = grid(), np.ones((40, 50)), np.zeros((40, 50, 3))
    texture = RNG.random((10, 10, 3))
    pivot = np.rint(middle_of(uv))
    twice = compose(texture, uv, flat, none, SCALE, placement=Placement(repeat=(2.0, 2.0)))[0]
    norm = Norm(SCALE, pivot, 1.0)
    closer = compose_layers(texture, (2 * uv - pivot, flat, none), norm, Placement(), alpha=1.0, strength=1.0)[0]
    assert np.allclose(twice, closer, atol=1e-4)
    assert np.abs(twice - compose(texture, uv, flat, none, SCALE)[0]).mean() > 0.05


def test_offset_moves_the_texture_by_that_share_of_a_copy() -> None:
    uv, flat, none = grid(), np.ones((40, 50)), np.zeros((40, 50, 3))
    texture = RNG.random((10, 20, 3))
    moved = compose(texture, uv, flat, none, SCALE, placement=Placement(offset=(0.25, 0.1)))[0]
    rolled = compose(np.roll(texture, (1, 5), axis=(0, 1)), uv, flat, none, SCALE)[0]
    assert np.allclose(moved, rolled, atol=1e-4)


def test_no_jump_at_the_borders_of_texels() -> None:
    t = (np.arange(32) + 0.5) / 32 * 2 * np.pi
    texture = np.broadcast_to(0.5 + 0.4 * np.sin(t)[None, :, None] * np.cos(t)[:, None, None], (32, 32, 3)).copy()
    uv = grid((60, 70), 21.3)
    shown = compose(texture, uv, np.ones((60, 70)), np.zeros((60, 70, 3)), np.eye(2) * 21.3)[0]
    steepest = 0.4 * 2 * np.pi / 21.3
    assert max(np.abs(np.diff(shown, axis=axis)).max() for axis in (0, 1)) < 1.05 * steepest
