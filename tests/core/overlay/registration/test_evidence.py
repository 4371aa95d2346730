"""Of several finds, the one whose repeated texel explains most of the photo beside a smooth one is kept."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from app.bench.overlay import cloth
from core.arrays import Bools, Floats
from core.imaging.image import Image
from core.overlay import decomposition
from core.overlay.decomposition import decompose, decompose_whole_cloth
from core.overlay.detection.alignment import FlatPicture, PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError, flat_canvas
from core.overlay.found_cloth import FoundCloth
from core.overlay.pixels.model import begin
from core.overlay.pixels.stages import enlarge, explain_pixels, paint_pieces, uncover_hidden
from core.overlay.registration import cloth as cloth_module
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.evidence import Evidence, count_repeated, may_be_plaid, piece_parts, weigh
from core.overlay.registration.fitting import begun
from core.overlay.search import finding
from core.overlay.search.finding import Find, find_cloth, register, register_each
from core.overlay.search.magnified import restrict
from core.overlay.texel import Texel, estimate_texel
from core.progress import Job, Progress, run
from tests.core.overlay.overlay_scenes import Scene, make_scene, motif, plaid


@pytest.fixture(scope="module")
def scene() -> Scene:
    return make_scene(motif(), basis=24.0 * np.eye(2), bend=0.0)


def weighed(photo: Floats, side: float, height: float | None = None) -> Evidence:
    """Return what speaks for an upright lattice of texels of that side, or of that width and height."""
    return weigh(*begun_with(photo, side, height))


def begun_with(photo: Floats, side: float, height: float | None = None) -> tuple[FittedCloth, Fit]:
    """Return the cloth registered with an upright lattice of texels of that side, or of that width and height."""
    sides = np.array([side, height or side])
    count = (np.array(photo.shape[1::-1]) - 10) // sides
    keys = np.stack(np.meshgrid(*(np.arange(n) for n in count)), -1).reshape(-1, 2).astype(np.int64)
    points = (sides * keys + 10).astype(np.float64)
    frames = PatchFrames(points, np.tile(np.diag(sides), (len(keys), 1, 1)), np.ones(len(keys)))
    canvas = flat_canvas(photo, np.ones(photo.shape[:2], bool))
    return run(begun(photo, canvas, Lattice(keys, frames), 0, trusted=True))


def test_the_true_lattice_explains_most(scene: Scene) -> None:
    true, wrong = weighed(scene.photo, 24.0), weighed(scene.photo, 17.0)
    assert true.is_clear
    assert not wrong.is_credible
    assert true.explained > 2 * wrong.explained


def test_stripes_and_a_border_are_no_evidence() -> None:
    y, x = np.indices((170, 190))
    stripes = np.where((x // 8) % 2, 0.8, 0.3)
    noise = np.random.default_rng(0).normal(0, 0.02, (170, 190, 3))
    for pattern in (stripes + 0.02 * np.sin(y / 4), np.where(y < 80, stripes, 0.3)):
        photo = np.clip(pattern[..., None] * np.ones(3) + noise, 0, 1)
        with pytest.raises(NoPatternError):
            run(find_cloth(photo, flat_canvas(photo, np.ones(photo.shape[:2], bool)), 0))


def test_texels_of_one_row_are_evidence_along_it_only(scene: Scene) -> None:
    _, found = begun_with(scene.photo, 24.0)
    state = found.pieces[0]
    whole = min(count_repeated(piece_parts(found), axis) for axis in (0, 1))
    assert whole > 0.7
    for axis in (0, 1):
        middle = np.floor(np.median(state.uv[..., axis]))
        row = state.cells & (np.floor(state.uv[:-1, :-1, axis]) == middle)
        parts = piece_parts(replace(found, pieces=(replace(state, cells=row),)))
        assert count_repeated(parts, axis) == 0
        assert count_repeated(parts, 1 - axis) > 0.7


def test_texel_that_columns_do_not_foretell_is_none() -> None:
    rng = np.random.default_rng(3)
    row = cv2.GaussianBlur(rng.normal(size=(17, 190, 3)), (0, 0), 2.0)
    photo = 0.5 + 0.15 * np.tile(row / row.std(), (10, 1, 1)) + rng.normal(0, 0.01, (170, 190, 3))
    assert not weighed(np.clip(photo, 0, 1), 42.0, 17.0).is_credible
    again = np.tile(photo[:, :42], (1, 5, 1)) + rng.normal(0, 0.01, (170, 210, 3))
    assert weighed(np.clip(again, 0, 1), 42.0, 17.0).is_clear


def with_folds(scene: Scene, seed: int) -> Floats:
    """Return a scene's photo with narrow dark folds, most of them upright."""
    rng, (y, x) = np.random.default_rng(seed), np.indices(scene.photo.shape[:2])
    light = np.ones(scene.photo.shape[:2])
    for _ in range(30):
        turn = rng.uniform(-0.5, 0.5)
        off = (x - rng.uniform(0, 190)) * np.cos(turn) + (y - 85) * np.sin(turn)
        light *= 1 - 0.6 * np.exp(-(off**2) / (2 * 2.5**2))
    return scene.photo * light[..., None]


def error_px(cloth: FittedCloth, found: Fit, scene: Scene) -> float:
    """Return how far a registered piece is off on average, but for a shift of all of it."""
    state, inside = found.pieces[0], np.zeros(scene.photo.shape[:2], bool)
    inside[25:-25, 25:-25] = True
    inside &= cloth.mesh.pixels_of(state.cells)
    off = ((cloth.mesh.to_pixels(state.uv, state.cells) - scene.uv) @ scene.basis.T)[inside]
    return float(np.sqrt(((off - np.median(off, 0)) ** 2).sum(1).mean()))


def across_threads(texel: Texel) -> Floats:
    """Return what is left of a texel (h, w, 3) without what changes along its rows, or along its columns, alone."""
    pixels = texel.pixels
    return np.asarray(pixels - pixels.mean(0) - pixels.mean(1)[:, None] + pixels.mean((0, 1)), np.float64)


@pytest.mark.parametrize("is_woven", [True, False])
def test_the_texel_of_a_large_photo_is_a_plaid_too(is_woven: bool) -> None:
    cloth, found = begun_with(with_folds(make_scene(plaid(), basis=30.0 * np.eye(2)), 1), 30.0)
    large = np.repeat(np.repeat(cloth.photo, 2, 0), 2, 1).astype(np.float32)
    known = replace(cloth, is_woven=is_woven)
    begun = begin(known, found, large, np.ones(large.shape[:2], bool), is_told=True)
    model = enlarge(uncover_hidden(paint_pieces(explain_pixels(begun))))
    assert model.texel.shape == tuple(2 * samples for samples in cloth.texel_samples)
    assert np.allclose(across_threads(model.texel), 0) == is_woven


def test_folds_are_no_part_of_a_plaid(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = make_scene(plaid(), basis=30.0 * np.eye(2))
    cloth, found = begun_with(with_folds(scene, 1), 30.0)
    assert cloth.is_woven
    assert np.allclose(across_threads(found.texel), 0)
    monkeypatch.setattr(Texel, "woven", lambda texel, _: texel)
    # Told as robustly as that of a plaid: what differs is what the texel may be.
    monkeypatch.setattr(cloth_module, "estimate_texel", lambda *given, **_: estimate_texel(*given))
    any_texel = begun_with(with_folds(scene, 1), 30.0)
    assert error_px(cloth, found, scene) < 0.9 * error_px(*any_texel, scene)


def test_a_print_with_folds_is_no_plaid() -> None:
    cloth, found = begun_with(with_folds(make_scene(motif(), basis=30.0 * np.eye(2)), 1), 30.0)
    assert not weigh(cloth, found).is_clear
    assert not cloth.is_woven


def test_what_changes_in_all_directions_may_be_no_plaid(scene: Scene) -> None:
    cloth, _ = begun_with(scene.photo, 24.0)
    anything = np.random.default_rng(0).random((60, 60, 3)) - 0.5
    assert not may_be_plaid(cloth, Texel(0.5 + anything))
    assert may_be_plaid(cloth, Texel(plaid().pixels + 0.5 * anything))


def test_a_plaid_stays_one_on_a_coarser_photo_and_on_another(scene: Scene) -> None:
    cloth, found = begun_with(scene.photo, 24.0)
    woven = replace(cloth, is_woven=True)
    assert woven.coarser.is_woven
    assert restrict(woven, found, scene.photo, cloth.canvas)[0].is_woven
    assert not restrict(cloth, found, scene.photo, cloth.canvas)[0].is_woven


def test_where_a_print_leaves_no_doubt_no_plaid_is_tried(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Texel, "woven", lambda *_: pytest.fail("tried"))
    assert not begun_with(scene.photo, 24.0)[0].is_woven


def test_light_in_folds_is_no_evidence() -> None:
    y, x = np.indices((170, 190))
    folds = 0.5 + 0.15 * (np.sin(x / 13.0) + np.sin((x + 2 * y) / 31.0))[..., None] * np.ones(3)
    noise = np.random.default_rng(0).normal(0, 0.01, folds.shape)
    assert weighed(folds + noise, 24.0).explained < 0.1 * ((folds - folds.mean()) ** 2).sum()


def test_of_a_texel_seen_once_nothing_is_evidence(scene: Scene) -> None:
    once, often = (weighed(scene.photo[:size, :size], 24.0).explained for size in (58, 106))
    assert often > 4 * once


def test_cells_beyond_the_region_say_nothing(scene: Scene) -> None:
    cloth, found = begun_with(scene.photo, 24.0)
    inside = np.ones(scene.photo.shape[:2])
    inside[:, :60] = 0
    half = replace(cloth, registration=cloth.registration.weighted(inside))
    assert 0 < weigh(half, found).explained < weigh(cloth, found).explained


def test_what_repeats_in_a_corner_of_a_photo_is_not_its_cloth(scene: Scene) -> None:
    cloth, found = begun_with(scene.photo, 24.0)
    small = Find(cloth, found, Evidence(100.0, 0.9))
    assert small.is_clear
    wide = replace(cloth, canvas=flat_canvas(np.tile(scene.photo, (5, 5, 1)), np.ones((850, 950), bool)))
    far = replace(wide, mesh=replace(cloth.mesh, shape=(850, 950)))
    cells = np.zeros(far.mesh.cells, bool)
    cells[: found.pieces[0].cells.shape[0], : found.pieces[0].cells.shape[1]] = found.pieces[0].cells
    corner = replace(found, pieces=(replace(found.pieces[0], cells=cells),))
    assert not Find(far, corner, Evidence(100.0, 0.9)).is_credible


def test_where_a_find_leaves_no_doubt_no_other_lattice_is_needed(scene: Scene) -> None:
    cloth, found = begun_with(scene.photo, 24.0)
    lattice, clear = cloth.lattice, Find(cloth, found, Evidence(100.0, 0.9))
    frames = lattice.frames
    large = replace(lattice, frames=replace(frames, points=2 * frames.points + 0.5, bases=2 * frames.bases))
    outside = replace(lattice, frames=replace(frames, points=frames.points + np.array([90.0, 0.0])))
    assert clear.has_explained(lattice, 1)
    assert clear.has_explained(large, 2)
    assert replace(clear, scale=2).has_explained(replace(large, frames=replace(frames, points=frames.points / 2)), 1)
    assert not clear.has_explained(outside, 1)
    assert not Find(cloth, found, Evidence(100.0, 0.4)).has_explained(lattice, 1)


def test_of_lattices_that_are_parts_of_one_another_one_is_registered(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    cloth, _ = begun_with(scene.photo, 24.0)

    def search() -> Job[list[Lattice]]:
        yield Progress(0.0, "")
        return [cloth.lattice, cloth.lattice[np.arange(12)]]

    monkeypatch.setattr(finding, "weigh", lambda *_: Evidence(1.0, 0.1))
    assert len(run(register_each(scene.photo, cloth.canvas, search(), [], 0))) == 1


def test_a_finer_lattice_that_has_been_registered_is_not_registered_again(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    cloth, found = begun_with(scene.photo, 24.0)
    fine, coarse = cloth.lattice, replace(cloth.lattice, keys=cloth.lattice.keys + 1)
    shares, registered = {id(fine): 0.4, id(coarse): 0.8}, list[Lattice]()

    def register(_photo: Floats, _canvas: FlatPicture, lattice: Lattice, _seed: int) -> Job[Find]:
        yield Progress(0.0, "")
        registered.append(lattice)
        return Find(cloth, found, Evidence(1.0, shares[id(lattice)]))

    def search() -> Job[list[Lattice]]:
        yield Progress(0.0, "")
        return [fine, coarse]

    monkeypatch.setattr(finding, "register", register)
    monkeypatch.setattr(finding, "inside", lambda lattice, _: lattice)
    monkeypatch.setattr(finding, "divides", lambda other, _: other is fine)
    monkeypatch.setattr(Find, "has_followed", lambda *_: False)
    finds = run(register_each(scene.photo, cloth.canvas, search(), [], 0))
    assert registered == [fine, coarse]
    assert finds[-1].weight.share == 0.8


def test_a_lattice_that_was_followed_is_known(scene: Scene) -> None:
    doubtful, lattice = (
        Find(*begun_with(scene.photo, 24.0), Evidence(100.0, 0.1)),
        begun_with(scene.photo, 24.0)[0].lattice,
    )
    frames = lattice[np.arange(12)].frames
    moved = replace(frames, points=frames.points + frames.bases[:, :, 0])
    slanting = replace(frames, bases=frames.bases @ np.array([[1.0, 1.0], [0.0, 1.0]]))
    large = replace(frames, points=2 * frames.points + 0.5, bases=2 * frames.bases)
    beside = replace(frames, points=frames.points + np.linspace(0, 24, 12)[:, None])
    for number, (other, scale) in enumerate(((moved, 1), (slanting, 1), (large, 2), (beside, 1), (large, 1))):
        small = Lattice(lattice.keys[:12], other)
        assert doubtful.has_followed(small, scale) == (number < 3)


def test_a_lattice_that_cannot_be_followed_is_refused(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    def lost(_: FittedCloth, found: Fit, step: Progress) -> Job[Fit]:
        yield step
        return replace(found, pieces=tuple(replace(piece, cells=piece.cells & False) for piece in found.pieces))

    monkeypatch.setattr(finding, "followed", lost)
    cloth, _ = begun_with(scene.photo, 24.0)
    with pytest.raises(NoPatternError):
        run(register(scene.photo, cloth.canvas, cloth.lattice, 0))


def test_a_region_too_narrow_to_be_searched_takes_the_lattice_of_the_whole_picture(scene: Scene) -> None:
    strip = np.zeros(scene.photo.shape[:2], bool)
    strip[70:110, 10:-10] = True
    found = run(decompose(scene.photo, region=strip))
    assert found.covered[strip].mean() > 0.8
    assert not found.covered[~strip].any()
    steps = np.linalg.solve(scene.basis, found.basis)
    assert abs(np.linalg.det(steps)) == pytest.approx(1, abs=0.1)


def test_grey_levels_of_the_region_are_opacity(scene: Scene) -> None:
    opacity = np.linspace(-0.2, 1.0, scene.photo.shape[1], dtype=np.float32).clip(0)
    region = np.broadcast_to(opacity, scene.photo.shape[:2])
    found = run(decompose(scene.photo, region=region))
    inside = np.zeros(region.shape, bool)
    inside[20:-20, 60:-20] = True
    assert np.allclose(found.coverage[inside & found.covered], region[inside & found.covered])
    assert found.covered[inside].mean() > 0.9
    assert not found.covered[region == 0].any()


@pytest.mark.parametrize(("second", "is_wider"), [(2.0, True), (0.5, False), (None, False)])
def test_whole_cloth_keeps_the_better_find(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, second: float | None, is_wider: bool
) -> None:
    def follow(found: FoundCloth, region: Bools, _: int, **__: bool) -> Job[FoundCloth]:
        yield Progress(0.0)
        if second is None:
            raise NoPatternError
        wider = replace(found, opacity=np.float32(0.5))
        wider.__dict__["explained"] = second * found.explained
        return wider

    def whole(_: Image, known: Bools) -> Job[Bools]:
        yield Progress(0.0)
        return known

    monkeypatch.setattr(decomposition, "whole_object", whole)
    monkeypatch.setattr(decomposition, "follow", follow)
    photo = Image(np.rint(255 * scene.photo).astype(np.uint8))
    found = run(decompose_whole_cloth(photo))
    assert found.coverage.max() == (0.5 if is_wider else 1.0)


def test_of_lattices_that_explain_as_much_the_one_with_the_least_texel_is_taken() -> None:
    found = run(decompose(cloth((512, 512))))
    texels = float(found.covered.sum()) / abs(float(np.linalg.det(found.basis)))
    assert 135 < texels < 160
