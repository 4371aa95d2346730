"""The detail without what it keeps of the old pattern."""

import numpy as np
import pytest

from core.arrays import Floats, Singles
from core.overlay.composition import Placement
from core.overlay.detail.bare_layers import find_bare_layers
from core.overlay.detail.residual_cleanup import find_recurring, without_old_pattern
from core.overlay.filters import bands
from core.overlay.laying.compositing import Parts, lay_over
from core.overlay.texel import estimate_texel
from tests.core.overlay.overlay_scenes import COLOURS, Scene, make_scene, motif, stored

GRAIN = 0.01
SCENE = make_scene(motif(), noise=GRAIN)
SIZE = SCENE.shading.shape
TEXEL = estimate_texel(SCENE.photo, SCENE.uv, SCENE.shading, np.ones(SIZE), (34, 36))


def missed(scene: Scene = SCENE, *, off_px: float = 0.4) -> tuple[Singles, Singles]:
    """Return the detail where a texel that is less sharp than the photo lies off by a smooth field, and its place."""
    y, x = np.indices(SIZE)
    off = off_px * np.stack([np.sin(x / 30 + y / 17), np.cos(y / 25)], -1)
    uv = scene.uv + off @ np.linalg.inv(scene.basis).T
    detail = scene.photo - scene.shading[..., None] * TEXEL.blurred(0.6, scene.basis)(uv)
    return detail.astype(np.float32), uv.astype(np.float32)


def alone(detail: Singles, uv: Singles) -> Singles:
    return without_old_pattern(detail, uv, SCENE.shading.astype(np.float32), TEXEL, SCENE.basis)


def bare(detail: Floats | Singles, uv: Singles) -> tuple[Singles, Singles]:
    """Return the light and the detail that go with a new texture."""
    layers = detail.astype(np.float32), uv, SCENE.shading.astype(np.float32)
    return find_bare_layers(*layers, TEXEL, SCENE.basis)


def near_edges() -> tuple[Floats, Floats]:
    """Return which pixels are near the edge of a motif, and which are far from any."""
    _, du, dv = TEXEL.with_gradient(SCENE.uv)
    steep = np.abs(du).max(-1) + np.abs(dv).max(-1)
    return np.asarray(steep > 3), np.asarray(steep < 0.3)


def test_edges_of_motifs_are_no_rougher_than_the_ground() -> None:
    detail, uv = missed()
    at, off = near_edges()
    before, after = (float(values[at].std() / values[off].std()) for values in (detail, alone(detail, uv)))
    assert before > 5
    assert after < 1.4


def test_grain_of_the_cloth_stays() -> None:
    grain = (SCENE.photo - make_scene(motif(), noise=0.0).photo)[near_edges()[1]]
    kept = alone(*missed())[near_edges()[1]]
    assert kept.std() == pytest.approx(grain.std(), rel=0.15)
    assert np.corrcoef(kept.ravel(), grain.ravel())[0, 1] > 0.9


def test_folds_and_stains_stay() -> None:
    detail, uv = missed(off_px=0.0)
    y, x = np.indices(SIZE)
    fold = (-0.2 * np.exp(-(((x + 0.4 * y - 130) / 3) ** 2)))[..., None]
    _, off = near_edges()
    rows = off & (fold[..., 0] < -0.1)
    kept = alone((detail + fold).astype(np.float32), uv)
    assert (kept - detail)[rows].mean() == pytest.approx(fold[rows].mean(), rel=0.15)


def test_a_detail_without_pattern_stays_as_it_is() -> None:
    grain = np.random.default_rng(2).normal(0, GRAIN, (*SIZE, 3)).astype(np.float32)
    kept = alone(grain, SCENE.uv.astype(np.float32))
    assert np.abs(kept - grain).mean() < 0.25 * GRAIN


def test_beyond_the_cloth_is_nothing_and_does_not_count() -> None:
    detail, uv = missed()
    whole = alone(detail, uv)
    detail[:, :60] = uv[:, :60] = np.nan
    kept = alone(detail, uv)
    np.testing.assert_array_equal(np.isnan(kept), np.isnan(detail))
    assert np.abs(kept - whole)[:, 90:].mean() < 0.1 * GRAIN


def test_no_cloth_at_all_is_no_fault() -> None:
    nothing = np.full((*SIZE, 3), np.nan, np.float32)
    assert np.isnan(bare(nothing, nothing[..., :2])[1]).all()


def test_light_of_its_own_in_each_channel_is_understood() -> None:
    detail, uv = missed()
    coloured = np.repeat(SCENE.shading[..., None], 3, -1).astype(np.float32)
    same = without_old_pattern(detail, uv, coloured, TEXEL, SCENE.basis)
    np.testing.assert_allclose(same, alone(detail, uv), atol=1e-6)


def test_bands_do_not_show(monkeypatch: pytest.MonkeyPatch) -> None:
    detail, uv = missed()
    whole = alone(detail, uv)
    monkeypatch.setattr(bands, "ROWS", 37)
    np.testing.assert_allclose(alone(detail, uv), whole, atol=2e-4)


def test_a_plain_texture_shows_no_outlines_and_the_old_one_gives_the_photo_back() -> None:
    detail, uv = missed()
    light, full = SCENE.shading.astype(np.float32), np.ones(SIZE, np.float32)
    soft = TEXEL.blurred(0.6, SCENE.basis).pixels
    parts = Parts(stored(SCENE.photo), uv, light, detail, full, SCENE.basis, soft)
    grey, plain = np.full((4, 4, 3), 0.5), Placement()
    old = lay_over(parts.under(soft, plain), soft, plain, alpha=1.0, strength=1.0).pixels
    assert np.abs(old / 255 - stored(SCENE.photo).pixels / 255).max() < 1.01 / 255
    new = lay_over(parts.under(grey, plain), grey, plain, alpha=1.0, strength=1.0).pixels / 255
    rough = new - 0.5 * light[..., None]
    at, off = near_edges()
    assert rough[at].std() < 1.4 * rough[off].std()
    moved = parts.under(soft, Placement(offset=(0.5, 0.0)))
    assert moved.detail is not parts.detail


def test_other_contrast_in_one_part_of_the_cloth_leaves_no_pattern() -> None:
    detail, uv = missed(off_px=0.0)
    at = TEXEL(SCENE.uv)
    faded = np.where((np.indices(SIZE)[1] > 95)[..., None], -0.3 * (at - TEXEL.pixels.mean((0, 1))), 0.0)
    detail = (detail + SCENE.shading[..., None] * faded).astype(np.float32)
    dark = at.mean(-1) < 0.45
    light = at.mean(-1) > 0.6
    part = np.indices(SIZE)[1] > 110
    before, after = (abs(float(d[dark & part].mean() - d[light & part].mean())) for d in (detail, bare(detail, uv)[1]))
    assert before > 0.06
    assert after < 0.05 * before


def left_of_spot(colour: Floats) -> float:
    """Return how much is left of a spot of a colour on plain ground, in detail and light."""
    detail, uv = missed(off_px=0.0)
    ground = np.argwhere((TEXEL(SCENE.uv) > [0.7, 0.67, 0.55]).all(-1))
    middle = ground[np.abs(ground - [85, 95]).sum(1).argmin()]
    spot = (slice(middle[0] - 2, middle[0] + 3), slice(middle[1] - 2, middle[1] + 3))
    model = (SCENE.photo - detail)[spot]
    detail[spot] = SCENE.shading[spot][..., None] * colour - model
    light, kept = bare(detail, uv)
    left = (kept + (light / SCENE.shading - 1)[..., None] * SCENE.photo)[spot]
    return float(np.abs(left[2, 2]).max() / np.abs(detail[spot][2, 2]).max())


def test_motif_where_the_model_has_none_goes() -> None:
    assert left_of_spot(COLOURS[1]) < 0.05
    assert left_of_spot(COLOURS[2]) < 0.05


def test_shadow_and_what_has_a_colour_of_its_own_stay() -> None:
    assert left_of_spot(0.5 * COLOURS[0]) > 0.9
    assert left_of_spot(np.array([0.2, 0.75, 0.15])) > 0.9


def test_what_recurs_is_taken_out_of_a_part_of_an_array_too() -> None:
    y, x = np.indices((96, 120))
    uv = (np.stack([x, y], -1) / 12).astype(np.float32)
    wide = np.zeros((96, 130, 1), np.float32)
    part, cloth = wide[:, :120], x < 100
    part[..., 0] = 0.1 * np.sin(np.pi * x / 6) * np.cos(np.pi * y / 6)
    find_recurring(part, uv, cloth, (12, 12), 0.1).take_out(part, uv, cloth)
    assert part[cloth].std() < 0.02
    assert part[~cloth].std() > 0.04
