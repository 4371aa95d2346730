"""What is hard, unusual or no pattern at all: a sensible result or a refusal, never a hang."""

import numpy as np
import pytest

from core.arrays import Bools, Floats, InputError
from core.overlay.decomposition import Decomposition, decompose
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.corrections import lattices_of, texel_between
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError, flat_canvas
from core.overlay.registration.cloth import make_cloth, starting_state
from core.overlay.registration.fitting import fit, true_period
from core.progress import run
from tests.core.overlay.overlay_scenes import Scene, make_scene, marked_checks, motif

RNG = np.random.default_rng(0)


def found_in(photo: Floats, region: Bools | None = None) -> Decomposition:
    return run(decompose(photo, region=region))


def assert_true_lattice(found: Decomposition, scene: Scene, *, least: float = 0.9, rms_px: float = 0.3) -> None:
    """Compare coordinates with the true ones, up to a change to another basis of the lattice."""
    inside = found.covered
    assert inside.mean() > least
    p, q = found.uv[inside].astype(float), scene.uv[inside]
    B = np.rint(np.linalg.lstsq(np.c_[p, np.ones(len(p))], q, rcond=None)[0][:2])
    assert abs(np.linalg.det(B)) == pytest.approx(1)
    rest = q - p @ B
    away = np.linalg.norm((rest - np.median(rest, axis=0)) @ scene.basis.T, axis=1)
    assert np.sqrt(np.mean(away**2)) < rms_px


def test_stripes_are_refused() -> None:
    x = np.indices((150, 170))[1]
    stripes = np.where(((x // 9) % 2)[..., None] > 0, [0.8, 0.8, 0.7], [0.2, 0.3, 0.5])
    with pytest.raises(NoPatternError):
        found_in(np.clip(stripes + RNG.normal(0, 0.01, stripes.shape), 0, 1))


def test_slanted_stripes_are_refused() -> None:
    y, x = np.indices((150, 170))
    wave = 0.5 + 0.3 * np.sin(0.4 * x + 0.17 * y)[..., None] * [1, 0.8, 0.6]
    with pytest.raises(NoPatternError):
        found_in(np.clip(wave + RNG.normal(0, 0.01, wave.shape), 0, 1))


def test_a_single_texel_is_refused() -> None:
    photo = np.full((120, 140, 3), 0.6)
    photo[40:80, 50:90] = motif(40).pixels
    with pytest.raises(NoPatternError):
        found_in(photo + RNG.normal(0, 0.005, photo.shape))


@pytest.mark.parametrize("size", [(1, 1), (3, 200), (12, 15), (40, 40)])
def test_tiny_pictures_are_refused(size: tuple[int, int]) -> None:
    with pytest.raises(NoPatternError):
        found_in(RNG.random((*size, 3)))


def test_of_two_patterns_one_is_found_and_the_other_left_alone() -> None:
    left = make_scene(motif())
    right = make_scene(marked_checks(), basis=np.array([[30.0, 0.0], [0.0, 31.0]]))
    photo = left.photo.copy()
    photo[:, 120:] = right.photo[:, 120:]
    found = found_in(photo)
    inside = found.covered
    shares = inside[:, :115].mean(), inside[:, 125:].mean()
    assert max(shares) > 0.85
    assert min(shares) < 0.25


def test_a_period_of_four_pixels_is_refused_or_found_whole() -> None:
    y, x = np.indices((96, 110))
    photo = np.where((((x // 2) % 2) ^ ((y // 2) % 2))[..., None] > 0, 0.8, 0.2) * np.ones(3)
    try:
        found = found_in(photo)
    except NoPatternError:
        return
    rounded = found.basis / 2
    assert np.allclose(rounded, np.rint(rounded), atol=0.1)


def test_a_lattice_turned_by_45_degrees() -> None:
    turn = np.array([[0.7071, -0.7071], [0.7071, 0.7071]])
    scene = make_scene(motif(), basis=turn @ np.diag([25.0, 23.0]))
    assert_true_lattice(found_in(scene.photo), scene)


def test_a_hexagonal_lattice() -> None:
    scene = make_scene(motif(), basis=np.array([[24.0, 12.0], [0.0, 20.8]]))
    assert_true_lattice(found_in(scene.photo), scene)


def test_dark_cloth() -> None:
    scene = make_scene(motif())
    photo = np.rint(255 * 0.12 * scene.photo) / 255
    assert_true_lattice(found_in(photo), scene)


def test_overexposed_cloth() -> None:
    scene = make_scene(motif(), noise=0.0)
    assert_true_lattice(found_in(np.clip(1.7 * scene.photo, 0, 1)), scene)


def test_a_button_keeps_its_pixels_and_does_not_bend_the_mesh() -> None:
    scene = make_scene(motif())
    y, x = np.indices(scene.photo.shape[:2])
    button = np.hypot(x - 95, y - 84) < 16
    photo = np.where(button[..., None], [0.95, 0.9, 0.1], scene.photo)
    found = found_in(photo)
    assert not found.covered[np.hypot(x - 95, y - 84) < 8].any()
    assert_true_lattice(found, scene, least=0.85)


def test_a_photo_larger_than_the_working_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("core.overlay.filters.shrinking.WORKING_PX", 120)
    scene = make_scene(motif(), size=(231, 239), basis=np.array([[34.0, 3.0], [-2.0, 33.0]]))
    found = found_in(scene.photo)
    assert_true_lattice(found, scene, rms_px=0.6)
    assert np.abs(found.reconstruction + found.detail - scene.photo)[found.covered].max() < 1e-6


def test_a_marked_texel_is_where_the_search_begins() -> None:
    scene = make_scene(motif(), bend=0.5, basis=np.diag([25.0, 23.0]))
    found = run(decompose(scene.photo, start=texel_between(np.array([60.0, 60.0]), np.array([86.0, 82.0]))))
    assert_true_lattice(found, scene)


@pytest.mark.parametrize("basis", [[[24.0, 12.0], [0.0, 20.8]], [[24.0, -8.0], [3.0, 22.0]]])
def test_a_box_marked_around_a_slanting_texel_snaps_to_it(basis: list[list[float]]) -> None:
    scene = make_scene(motif(), bend=0.5, basis=np.array(basis))
    box = np.abs(scene.basis).sum(1)
    found = run(decompose(scene.photo, start=texel_between(np.array([60.0, 60.0]), np.array([60.0, 60.0]) + box)))
    assert_true_lattice(found, scene)


def test_a_corrected_lattice_is_gone_on_from() -> None:
    scene = make_scene(motif())
    first = found_in(scene.photo)
    keys, points = first.lattice.keys, first.lattice.frames.points.copy()
    kept = np.arange(len(keys)) != len(keys) // 2
    points[3] += 2.0
    again = run(decompose(scene.photo, lattice=lattices_of(keys[kept], points[kept])))
    assert_true_lattice(again, scene)


def test_vertices_that_lie_badly_in_every_second_column_do_not_double_the_texel() -> None:
    scene = make_scene(motif(), size=(230, 240))
    keys = np.stack(np.meshgrid(np.arange(1, 8), np.arange(1, 9)), -1).reshape(-1, 2)
    points = keys @ scene.basis.T
    points[keys[:, 0] % 2 == 0, 1] += 4.0
    canvas = flat_canvas(scene.photo, np.ones(scene.photo.shape[:2], bool))
    frames = PatchFrames(points, np.tile(scene.basis, (len(keys), 1, 1)), np.full(len(keys), 0.9))
    cloth = make_cloth(scene.photo, canvas, Lattice(keys, frames), np.eye(2))
    assert abs(np.linalg.det(true_period(cloth, starting_state(cloth, cloth.lattice), 0))) == pytest.approx(2)
    cloth, _ = run(fit(scene.photo, canvas, [cloth.lattice], 0, trusted=False))
    assert abs(np.linalg.det(cloth.M)) == pytest.approx(1)


def test_a_doubled_vertex_and_a_row_of_vertices_are_refused() -> None:
    keys = np.array([[0, 0], [1, 0], [2, 0], [2, 0]])
    points = keys * 20.0
    with pytest.raises(InputError, match="twice"):
        lattices_of(keys, points)
    with pytest.raises(InputError, match="both directions"):
        lattices_of(keys[:3], points[:3])


def test_a_blurred_texel_is_kept() -> None:
    texel, basis = motif(), np.diag([20.0, 20.0])
    assert texel.blurred(1.0, basis) is texel.blurred(1.0, basis.copy())
    assert texel.blurred(1.0, basis) is not texel.blurred(1.0, 2 * basis)
    assert texel.blurred(1.0, basis) is not texel.blurred(2.0, basis)


def test_cloth_that_is_black_in_more_than_half_begins_with_even_light() -> None:
    photo = np.zeros((120, 120, 3))
    photo[5::20, 5::20] = 0.9
    keys = np.stack(np.meshgrid(np.arange(1, 5), np.arange(1, 5)), -1).reshape(-1, 2)
    frames = PatchFrames(
        keys @ (20.0 * np.eye(2)), np.tile(20.0 * np.eye(2), (len(keys), 1, 1)), np.full(len(keys), 0.9)
    )
    cloth = make_cloth(photo, flat_canvas(photo, np.ones((120, 120), bool)), Lattice(keys, frames), np.eye(2))
    assert (starting_state(cloth, cloth.lattice).rho == 1).all()
