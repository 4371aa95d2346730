"""The whole decomposition on small scenes with a known answer."""

import cv2
import numpy as np
import pytest

from core.arrays import Bools, Floats
from core.imaging.image import Image
from core.overlay import decomposition
from core.overlay.decomposition import Decomposition, decompose, decompose_whole_cloth
from core.overlay.detection.basis import reduce
from core.overlay.detection.seeding import NoPatternError
from core.overlay.filters.shrinking import shrunk
from core.overlay.laying.compositing import encode
from core.overlay.pixels import layers, stages
from core.progress import Job, Progress, run
from tests.core.overlay.overlay_scenes import Scene, make_scene, marked_checks, motif
from tests.core.overlay.prints import bent_print, print_on_a_table, usual_vectors


@pytest.fixture(scope="module")
def scene() -> Scene:
    return make_scene(motif())


@pytest.fixture(scope="module")
def found(scene: Scene) -> Decomposition:
    return run(decompose(scene.photo))


def errors_px(found: Decomposition, scene: Scene) -> Floats:
    """Return the distances (n,) of covered pixels from their true place, up to a change of basis and an offset."""
    inside = found.covered
    p, q = found.uv[inside].astype(float), scene.uv[inside]
    fitted = np.linalg.lstsq(np.c_[p, np.ones(len(p))], q, rcond=None)[0]
    B = np.rint(fitted[:2])
    rest = q - p @ B
    return np.asarray(np.linalg.norm((rest - np.median(rest, axis=0)) @ scene.basis.T, axis=1))


def test_lattice_is_the_true_one_and_close_to_the_pixel(found: Decomposition, scene: Scene) -> None:
    inside = found.covered
    assert inside.mean() > 0.97
    B = np.linalg.lstsq(np.c_[found.uv[inside], np.ones(inside.sum())], scene.uv[inside], rcond=None)[0][:2]
    assert abs(abs(np.linalg.det(np.rint(B))) - 1) < 1e-9
    assert np.sqrt(np.mean(errors_px(found, scene) ** 2)) < 0.15


def test_shading_is_the_true_one_up_to_a_factor(found: Decomposition, scene: Scene) -> None:
    ratio = found.shading[found.covered] / scene.shading[found.covered]
    assert ratio.std() / ratio.mean() < 0.02


def test_parts_recombine_to_the_photo(found: Decomposition, scene: Scene) -> None:
    inside = found.covered
    assert np.abs(found.reconstruction + found.detail - scene.photo)[inside].max() < 1e-6
    assert np.isnan(found.detail[~inside]).all()
    assert np.isnan(found.shading[~inside]).all()


def test_no_triangle_folds(found: Decomposition) -> None:
    du, dv = np.diff(found.uv, axis=1)[:-1], np.diff(found.uv, axis=0)[:, :-1]
    turn = du[..., 0] * dv[..., 1] - du[..., 1] * dv[..., 0]
    turn = turn[np.isfinite(turn)]
    assert turn.min() > 0 or turn.max() < 0


def test_the_same_seed_gives_the_same_bytes(scene: Scene, found: Decomposition) -> None:
    again = run(decompose(scene.photo))
    assert again.uv.tobytes() == found.uv.tobytes()
    assert again.detail.tobytes() == found.detail.tobytes()


def test_steps_never_run_backwards_and_show_the_lattice_and_the_mesh(scene: Scene) -> None:
    steps: list[Progress] = []
    run(decompose(scene.photo), steps.append)
    fractions = [step.fraction for step in steps]
    assert fractions == sorted(fractions)
    shown = [step.preview for step in steps if step.preview is not None]
    assert any(stage.lattice is not None and len(stage.lattice) > 9 for stage in shown)
    assert any(stage.uv is not None and np.isfinite(stage.uv).any() for stage in shown)


def test_the_usual_texel_is_the_mean_one_of_all_of_the_cloth(found: Decomposition, scene: Scene) -> None:
    np.testing.assert_allclose(found.basis, usual_vectors(scene), atol=0.5)


@pytest.mark.parametrize(("mark", "area"), [(True, 32.0**2), (False, 32.0**2 / 2)])
def test_a_mark_in_every_second_check_doubles_the_texel(mark: bool, area: float) -> None:
    basis = np.array([[32.0, 2.0], [-1.0, 32.0]])
    found = run(decompose(make_scene(marked_checks(mark=mark), size=(220, 230), basis=basis).photo))
    assert abs(np.linalg.det(found.basis)) == pytest.approx(area, rel=0.1)
    assert found.covered.mean() > 0.9


def test_region_limits_the_cloth(scene: Scene) -> None:
    region = np.zeros(scene.photo.shape[:2], bool)
    region[:, :120] = True
    found = run(decompose(scene.photo, region=region))
    assert not found.covered[:, 120:].any()
    assert found.covered[:, :115].mean() > 0.9


def follow_over(monkeypatch: pytest.MonkeyPatch, region: Bools) -> None:
    """Let *Whole cloth* follow a find over a region, as the object around it, and keep that."""

    def cut_out(*_: object) -> Job[Bools]:
        yield Progress(0.0)
        return region

    monkeypatch.setattr(decomposition, "whole_object", cut_out)
    monkeypatch.setattr(decomposition, "choose", lambda finds: finds[-1])


@pytest.mark.parametrize("is_told", [True, False])
def test_ground_is_cut_off_where_nobody_said_that_there_is_cloth(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, is_told: bool
) -> None:
    y, x = np.indices(scene.photo.shape[:2])
    sliver = (y == 60) & (x > 40) & (x < 52)
    ground = (x > 120) | sliver
    monkeypatch.setattr(stages, "find_surroundings", lambda _photo, covered, *_: covered & ground)
    region = np.ones(ground.shape, bool)
    if is_told:
        found = run(decompose(scene.photo, region=region))
    else:
        photo = Image(scene.photo.astype(np.float32))
        follow_over(monkeypatch, region)
        found = run(decompose_whole_cloth(photo))
    assert found.covered[:, :110].mean() > 0.9
    assert found.covered[:, 125:].mean() == pytest.approx(float(is_told), abs=0.1)
    assert found.coverage[sliver].mean() > 0.9, "what is so thin is left to the outline"


def test_light_that_changes_colour_has_a_shading_per_channel(scene: Scene, found: Decomposition) -> None:
    assert found.shading.ndim == 2
    x = np.linspace(-1, 1, scene.photo.shape[1])
    colour = np.stack([1 + 0.2 * x, np.ones_like(x), 1 - 0.2 * x], -1)
    lit = run(decompose(np.clip(scene.photo * colour, 0, 1)))
    assert lit.shading.shape == scene.photo.shape
    inside = lit.covered
    red_over_blue = (lit.shading[..., 0] / lit.shading[..., 2])[inside]
    true = np.broadcast_to(colour[:, 0] / colour[:, 2], inside.shape)[inside]
    ratio = red_over_blue / true
    assert ratio.std() / ratio.mean() < 0.06  # it is 0.23 where the colour of the light is ignored


def test_noise_and_an_even_picture_are_refused() -> None:
    noise = np.random.default_rng(0).random((120, 150, 3))
    for picture in (noise, np.full((120, 150, 3), 0.5)):
        with pytest.raises(NoPatternError, match="no repeating texture found"):
            run(decompose(picture))


def test_reduced_basis_spans_the_same_lattice() -> None:
    basis = np.array([[30.0, 94.0], [4.0, 31.0]])
    short = reduce(basis)
    change = np.linalg.solve(basis, short)
    assert np.allclose(change, np.rint(change))
    assert np.linalg.det(short) == pytest.approx(abs(np.linalg.det(basis)))
    assert np.linalg.norm(short, axis=0).max() <= np.linalg.norm(basis, axis=0).max()


def test_ground_in_more_light_than_there_can_be_is_not_cloth(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(layers, "GLARE", 0.7)
    result = run(decompose(scene.photo))
    light = 0.75 * scene.shading
    assert result.covered[light < 0.65].mean() > 0.9
    assert result.covered[light > 0.82].mean() < 0.02


def test_the_texel_is_told_from_where_single_pixels_lie(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = make_scene(motif())
    y, x = (np.asarray(places, np.float32) for places in np.indices(scene.photo.shape[:2]))
    photo = scene.photo.astype(np.float32)
    moved = cv2.remap(photo, x + np.sin(y), y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    wobbling = np.asarray(moved, np.float32)
    found = run(decompose(wobbling))
    monkeypatch.setattr(stages, "refine", lambda _photo, uv, *_, **__: uv)
    blurred = run(decompose(wobbling))
    contrasts = [float(one.texel.pixels.var(axis=(0, 1)).sum()) for one in (found, blurred)]
    assert contrasts[0] > 1.01 * contrasts[1]


@pytest.mark.parametrize(("side", "is_explained"), [(40, False), (60, True)])
def test_a_corner_whose_pattern_jumps_is_covered_and_explained_if_it_shows_a_few_texels(
    side: int, *, is_explained: bool
) -> None:
    scene = make_scene(motif())
    photo, corner = scene.photo.copy(), (slice(-side, None), slice(-side, None))
    photo[corner] = np.roll(scene.photo, (11, 12), (0, 1))[corner]
    region = np.ones(photo.shape[:2], bool)
    region[:3] = False
    found = run(decompose(photo, region=region))
    inside = (slice(4 - side, None), slice(4 - side, None))
    assert found.covered[inside].all()
    if is_explained:
        assert np.sqrt((found.detail[inside] ** 2).mean()) < 0.02


def test_whole_cloth_ends_where_it_does_and_not_where_its_object_was_cut_out(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    y, x = np.indices(scene.shading.shape)
    away = np.hypot(y - 85, x - 95)
    photo = np.where((away < 70)[..., None], scene.photo, [0.1, 0.3, 0.1]).astype(np.float32)
    follow_over(monkeypatch, away < 64)
    coverage = run(decompose_whole_cloth(Image(photo))).coverage
    assert coverage[away < 69].mean() > 0.98
    assert coverage[away > 71].mean() < 0.01


@pytest.mark.parametrize("scale", [1, 2, 5])
def test_a_large_photo_is_shrunk_to_the_means_of_squares(scale: int) -> None:
    photo = np.random.default_rng(0).random((23, 41, 3)).astype(np.float32)
    found = shrunk(photo, scale)
    assert found.shape == (-(-23 // scale), -(-41 // scale), 3)
    np.testing.assert_allclose(found[1, 2], photo[scale : 2 * scale, 2 * scale : 3 * scale].mean((0, 1)), rtol=1e-6)
    edge = np.pad(photo, ((0, -23 % scale), (0, -41 % scale), (0, 0)), mode="edge")
    np.testing.assert_allclose(found[-1, -1], edge[-scale:, -scale:].mean((0, 1)), rtol=1e-6)
    np.testing.assert_array_equal(shrunk(photo > 0.5, scale) > 0.5, shrunk((photo > 0.5).astype(float), scale) > 0.5)


def test_who_asks_for_the_whole_cloth_says_that_what_stands_out_is_cloth() -> None:
    photo, inside = print_on_a_table()
    with pytest.raises(NoPatternError):
        run(decompose(encode(photo)))
    assert_print_alone_is_found(photo, inside)


def test_what_stands_out_is_searched_where_it_is_the_ground_that_was_found() -> None:
    photo, inside = print_on_a_table()
    ground = make_scene(motif(), size=inside.shape).photo * [0.15, 0.2, 0.25] + 0.2
    photo = Image(np.where(inside[..., None], photo.pixels, np.rint(255 * ground)).astype(np.uint8))
    found = run(decompose(encode(photo)))
    assert found.covered[~inside].mean() > 0.95
    assert found.covered[inside].mean() < 0.05
    assert_print_alone_is_found(photo, inside)


def assert_print_alone_is_found(photo: Image, inside: Bools) -> None:
    found = run(decompose_whole_cloth(photo))
    assert found.covered[inside].mean() > 0.95
    assert found.covered[~inside].mean() < 0.02
    np.testing.assert_allclose(found.basis, usual_vectors(bent_print()), atol=2.0)
