"""Texels of which a photo shows a few only: how they are laid, and what is refused."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.detection.alignment import FlatPicture
from core.overlay.detection.displacement_votes import Pairs
from core.overlay.detection.seeding import NoPatternError
from core.overlay.mesh import ClothMesh
from core.overlay.registration import evidence
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.evidence import Evidence
from core.overlay.search import large_periods
from core.overlay.search.large_periods import (
    UNTOLD,
    find_large,
    find_likely,
    find_likely_of_patches,
    fit_plate,
    lay,
    register_coarsely,
)
from core.progress import Job, Progress, run
from tests.core.overlay.overlay_scenes import Scene, make_scene
from tests.core.overlay.prints import PRINT, canvas_of, displaced_px, find_likeliest, painted, sett, tartan


def likely_and_another(scene: Scene) -> tuple[FlatPicture, Pairs, float, Floats, Floats]:
    """Return the canvas, pairs, how sure the surest lattice of their votes is, its basis and another of the lattice."""
    canvas = painted(scene.photo)
    pairs, ((sure, basis), *_) = find_likely(canvas)
    return canvas, pairs, sure, basis, basis @ np.array([[1.0, 1.0], [0.0, 1.0]])


def test_a_few_large_texels_are_laid_where_they_are(printed: Scene, followed: tuple[FittedCloth, Fit]) -> None:
    cloth, found = followed
    cells = found.pieces[0].cells
    assert cells.mean() > 0.9
    assert np.percentile(displaced_px(printed, cloth, found.pieces[0]), 90) < 1.0


def test_thin_lines_on_even_ground_are_laid_on_one_another() -> None:
    basis = np.array([[84.0, 4.0], [-3.0, 82.0]])
    scene = make_scene(tartan(), size=(400, 360), basis=basis, bend=3.0)
    inside = np.pad(np.ones((330, 290), bool), ((40, 30), (40, 30)))
    photo = np.where(inside[..., None], scene.photo, 0.93)
    cloth, found, weight = find_likeliest(photo, canvas_of(photo))
    steps = np.linalg.solve(basis, cloth.basis)
    assert np.abs(steps - np.rint(steps)).max() < 0.1
    assert weight.explained > 0
    assert cloth.mesh.pixels_of(found.cells)[inside].mean() > 0.4


def test_of_what_is_laid_but_cannot_be_followed_nothing_is_found(
    printed: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    def give_all_up(_: FittedCloth, found: Fit, __: Progress) -> Job[Fit]:
        yield Progress(0.5)
        none = np.zeros_like(found.cells)
        return replace(found, pieces=tuple(replace(piece, cells=none) for piece in found.pieces))

    monkeypatch.setattr(large_periods, "followed", give_all_up)
    with pytest.raises(NoPatternError):
        find_likeliest(printed.photo, painted(printed.photo))


@pytest.mark.parametrize("in_region", [True, False])
def test_only_what_is_cloth_in_all_is_stiff_while_it_is_registered_coarsely(
    printed: Scene, monkeypatch: pytest.MonkeyPatch, in_region: bool
) -> None:
    stiff: list[bool] = []

    def note_stiff(_cloth: FittedCloth, found: Fit, *, is_stiff: bool, **_: object) -> Fit:
        stiff.append(is_stiff)
        return found

    canvas = (painted if in_region else canvas_of)(printed.photo)
    pairs, ((_, basis), *_) = find_likely(canvas)
    cloth, rough = lay(printed.photo, canvas, pairs, basis, 0.0)
    monkeypatch.setattr(large_periods, "refit", note_stiff)
    assert register_coarsely(cloth, rough) is rough
    assert stiff == [in_region]


def test_pairs_of_chance_do_not_bend_the_plate() -> None:
    mesh, rng = ClothMesh((240, 260), 10), np.random.default_rng(0)
    first = rng.uniform(20, 130, (80, 2))
    second = first + np.repeat([[100.0, 0.0], [0.0, 90.0]], 40, 0)
    wrong = rng.uniform(20, 220, (60, 2))
    rows = np.arange(110)
    pairs = Pairs(np.concatenate([first, wrong[:30], second, wrong[30:]]), rows, rows + 110)
    begin = mesh.positions() @ np.linalg.inv([[104.0, 3.0], [-4.0, 93.0]]).T
    uv, kept = fit_plate(mesh, pairs, begin)
    slopes = np.gradient(uv, mesh.cell, axis=(0, 1))
    assert kept[:80].all()
    assert kept[80:].mean() < 0.3
    assert np.allclose(np.median(slopes[1], axis=(0, 1)), [0.01, 0.0], atol=2e-4)
    assert np.allclose(np.median(slopes[0], axis=(0, 1)), [0.0, 1 / 90], atol=2e-4)


def test_nothing_large_is_found_in_noise_stripes_one_motif_or_a_print_seen_hardly_twice(printed: Scene) -> None:
    rng = np.random.default_rng(0)
    photo = np.full((220, 240, 3), 0.6) + rng.normal(0, 0.01, (220, 240, 3))
    photo[60:140, 70:150] = sett(80).pixels
    y, x = np.indices((220, 240))
    stripes = 0.5 + 0.3 * np.sin(0.1 * x + 0.04 * y)[..., None] * [1, 0.8, 0.6] + rng.normal(0, 0.01, (220, 240, 3))
    for picture in (photo, rng.random((220, 240, 3)), stripes, printed.photo[:170, :200]):
        with pytest.raises(NoPatternError):
            find_likeliest(picture, painted(picture))


def test_without_a_region_more_texels_are_asked_for(printed: Scene) -> None:
    with pytest.raises(NoPatternError):
        find_likeliest(printed.photo, canvas_of(printed.photo))


def test_texels_are_about_as_large_as_the_user_says(printed: Scene) -> None:
    canvas, side = painted(printed.photo), float(np.sqrt(np.linalg.det(printed.basis)))
    cloth, *_ = find_likeliest(printed.photo, canvas, texel_px=1.2 * side)
    assert cloth.side_px == pytest.approx(side, rel=0.1)
    with pytest.raises(NoPatternError):
        find_likeliest(printed.photo, canvas, texel_px=3 * side)


def test_of_likely_lattices_that_comes_first_whose_texel_explains_most(
    printed: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    canvas = painted(printed.photo)
    pairs, likely = find_likely(canvas)
    sure, basis = likely[0]
    wrong = basis @ np.array([[1.0, 0.0], [0.5, 1.0]])
    monkeypatch.setattr(large_periods, "find_likely", lambda _: (pairs, [(1.5 * sure, wrong), (sure, basis)]))
    (first, _, clear), (second, _, doubtful) = run(find_large(printed.photo, canvas))
    assert np.allclose([first.basis, second.basis], [basis, wrong], atol=1e-6)
    assert clear.is_clear
    assert not doubtful.is_clear


def test_where_no_texel_takes_error_away_votes_decide(printed: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    canvas, pairs, sure, basis, other = likely_and_another(printed)
    monkeypatch.setattr(large_periods, "find_likely", lambda _: (pairs, [(1.1 * sure, basis), (sure, other)]))
    shares = iter((-0.4, -0.2, -0.4))
    monkeypatch.setattr(large_periods, "weigh", lambda *_: Evidence(1.0, next(shares)))
    assert np.allclose(find_likeliest(printed.photo, canvas)[0].basis, basis, atol=1e-6)


@pytest.mark.parametrize("is_told", [True, False])
def test_a_lattice_whose_texels_have_nothing_to_do_with_one_another_is_one_only_of_what_the_user_says_is_cloth(
    printed: Scene, monkeypatch: pytest.MonkeyPatch, is_told: bool
) -> None:
    canvas, pairs, sure, basis, other = likely_and_another(printed)
    monkeypatch.setattr(large_periods, "find_likely", lambda _: (pairs, [(1.5 * sure, other), (sure, basis)]))

    def weigh(cloth: FittedCloth, _found: Fit) -> Evidence:
        return Evidence(1.0, -1.5 if np.allclose(cloth.basis, other) else 0.9)

    monkeypatch.setattr(large_periods, "weigh", weigh)
    finds = run(find_large(printed.photo, canvas, least=None if is_told else 2.0))
    assert np.allclose([cloth.basis for cloth, *_ in finds], [other, basis] if is_told else [basis], atol=1e-6)


def test_where_more_speaks_against_all_lattices_than_for_them_those_of_motifs_alone_are_likely_too(
    printed: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    canvas, pairs, sure, basis, other = likely_and_another(printed)
    monkeypatch.setattr(large_periods, "find_likely", lambda _: (pairs, [(1.1 * sure, other), (sure, basis)]))
    for explained, kept in ((-0.5, [basis, basis, other]), (0.5, [basis, other])):

        def weigh(cloth: FittedCloth, _found: Fit, explained: float = explained) -> Evidence:
            is_other = np.allclose(cloth.basis, other)
            return Evidence(-1.0 if is_other else explained, 0.1)

        monkeypatch.setattr(large_periods, "weigh", weigh)
        bases = [cloth.basis for cloth, *_ in run(find_large(printed.photo, canvas))]
        assert np.allclose(bases, kept, atol=1e-6)


@pytest.mark.parametrize("is_told", [True, False])
def test_what_motifs_alone_tell_is_laid_where_the_user_says_that_there_is_cloth(
    printed: Scene, monkeypatch: pytest.MonkeyPatch, is_told: bool
) -> None:
    canvas = painted(printed.photo)
    likely = find_likely(canvas.of_motifs)
    monkeypatch.setattr(large_periods, "LEAST_TEXELS", 2.0)
    monkeypatch.setattr(
        large_periods, "find_likely", lambda view: likely if view is canvas.of_motifs else (likely[0], [])
    )
    with nullcontext() if is_told else pytest.raises(NoPatternError):
        found = find_likeliest(printed.photo, canvas, least=None if is_told else 2.0)[1]
        assert found.cells.mean() > 0.9


@pytest.mark.parametrize("is_told", [True, False])
def test_what_the_user_says_is_cloth_is_seen_however_much_of_it_is_followed(
    printed: Scene, monkeypatch: pytest.MonkeyPatch, is_told: bool
) -> None:
    photo = printed.photo.copy()
    photo[:70] = photo[:70].mean((0, 1))
    least = 0.95 * photo[..., 0].size / abs(np.linalg.det(PRINT))
    monkeypatch.setattr(large_periods, "LEAST_TEXELS", least)
    monkeypatch.setattr(large_periods, "TRIED", 1)
    if not is_told:  # what is followed decides, however little lies near the pairs
        monkeypatch.setattr(large_periods, "lay", lambda a, b, c, d, _: lay(a, b, c, d, 0.0))
    with nullcontext() if is_told else pytest.raises(NoPatternError):
        cloth, found, _ = find_likeliest(photo, painted(photo), least=None if is_told else least)
        assert cloth.mesh.pixels_of(found.cells)[100:].mean() > 0.8
        assert cloth.mesh.pixels_of(found.cells).mean() < 0.9


@pytest.mark.parametrize(("least", "laid"), [(5.0, 1), (20.0, 0)])
def test_where_too_few_large_texels_could_be_seen_none_is_laid(
    printed: Scene, monkeypatch: pytest.MonkeyPatch, least: float, laid: int
) -> None:
    seen: list[Floats] = []

    def lay(*arguments: object) -> None:
        seen.append(np.asarray(arguments[3]))
        raise NoPatternError

    monkeypatch.setattr(large_periods, "TRIED", 1)
    monkeypatch.setattr(large_periods, "lay", lay)
    with pytest.raises(NoPatternError):
        find_likeliest(printed.photo, painted(printed.photo), least=least)
    assert len(seen) == laid


@pytest.mark.parametrize(("least", "is_laid"), [(0.9, True), (1.1, False)])
def test_large_texels_are_laid_only_if_pairs_tell_of_enough_cloth(printed: Scene, least: float, is_laid: bool) -> None:
    canvas, photo = painted(printed.photo), printed.photo
    pairs, [(_, basis), *_] = find_likely(canvas)
    cloth, rough = lay(photo, canvas, pairs, basis, 0.0)
    near = int(rough.cells.sum()) * cloth.mesh.cell**2
    with nullcontext() if is_laid else pytest.raises(NoPatternError):
        lay(photo, canvas, pairs, basis, least * near)


@pytest.mark.parametrize("explained", [1.0, -1.0])
def test_what_nobody_said_is_cloth_is_followed_only_where_more_speaks_for_it_than_against_it(
    printed: Scene, monkeypatch: pytest.MonkeyPatch, explained: float
) -> None:
    grown: list[Fit] = []

    def follow(_cloth: FittedCloth, found: Fit, _step: Progress) -> Job[Fit]:
        yield Progress(0.0, "")
        grown.append(found)
        return found

    for module in (large_periods, evidence):
        monkeypatch.setattr(module, "weigh", lambda *_: Evidence(explained, explained))
    monkeypatch.setattr(large_periods, "followed", follow)
    monkeypatch.setattr(large_periods, "LEAST_TEXELS", 2.0)
    with nullcontext() if explained > 0 else pytest.raises(NoPatternError):
        find_likeliest(printed.photo, canvas_of(printed.photo))
    assert len(grown) == (explained > 0)


@pytest.mark.parametrize(("in_region", "least"), [(True, None), (True, 2.0), (True, 20.0), (False, 2.0)])
def test_what_votes_are_certain_of_in_a_region_needs_nothing_else_but_texels_if_nobody_said_that_it_is_cloth(
    printed: Scene, monkeypatch: pytest.MonkeyPatch, in_region: bool, least: float | None
) -> None:
    monkeypatch.setattr(large_periods, "weigh", lambda *_: Evidence(-1.0, 0.9))
    monkeypatch.setattr(large_periods, "LEAST_TEXELS", 2.0)
    if in_region and least != 20.0:
        assert find_likeliest(printed.photo, painted(printed.photo), least=least)[1].cells.mean() > 0.9
    else:
        with pytest.raises(NoPatternError):
            find_likeliest(printed.photo, (painted if in_region else canvas_of)(printed.photo), least=least)


def test_patches_are_more_often_alike_by_chance_than_keypoints_where_nobody_said_that_there_is_cloth(
    printed: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    canvas = painted(printed.photo)
    likely = find_likely_of_patches(canvas)
    # All patches of a photo are compared once, which takes most of the time.
    monkeypatch.setattr(large_periods, "find_likely_of_patches", lambda _canvas: likely)
    (sure, _), *_ = likely[1]
    assert sure > UNTOLD["patches"] > UNTOLD["keypoints"]
    for certain, surplus in ((True, sure - 1), (False, sure + 1)):
        monkeypatch.setitem(UNTOLD, "patches", surplus)
        with nullcontext() if certain else pytest.raises(NoPatternError):
            find_likeliest(printed.photo, canvas, alike="patches", least=2.0)
        assert find_likeliest(printed.photo, canvas, alike="patches")[1].cells.any()
