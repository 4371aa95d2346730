"""Texels of which a photo shows a few only, and lattices that are none of the cloth's."""

from contextlib import nullcontext
from dataclasses import replace

import cv2
import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.detection.alignment import FlatPicture
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.displacement_votes import (
    Pairs,
    count_votes,
    find_alike,
    find_bases,
    first_of_each,
)
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError, find_lattices, flat_canvas
from core.overlay.filters import magnifying
from core.overlay.mesh import ClothMesh
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.evidence import Evidence
from core.overlay.search import finding, large_periods
from core.overlay.search.finding import Find, best_completed, find_cloth, find_print
from core.overlay.search.large_periods import STEP_PX, find_large, find_likely, fit_plate, lay
from core.overlay.texel import Texel
from core.progress import Job, Progress, run
from tests.core.overlay.overlay_scenes import Scene, make_scene, motif

LARGE = np.array([[62.0, 6.0], [-5.0, 62.0]])


def sett(n: int = 96) -> Texel:
    """Return a texel of crossing stripes of several widths."""
    across, down = (np.full((n, 3), 0.85) for _ in range(2))
    for stripes, first in ((across, 0.05), (down, 0.1)):
        for width, colour in ((0.14, (0.1, 0.1, 0.3)), (0.2, (0.7, 0.2, 0.1)), (0.1, (0.2, 0.4, 0.2))):
            stripes[round(first * n) : round((first + width) * n)] = colour
            first += width + 0.12
    return Texel((across[None] + down[:, None]) / 2)


def print_of_blots(seed: int, n: int = 180) -> Texel:
    """Return a texel of scattered blots of several forms, no two alike."""
    rng = np.random.default_rng(seed)
    pixels = np.full((n, n, 3), 0.8)
    for _ in range(26):
        corners = rng.uniform(0, n, 2) + rng.uniform(4, 16, (7, 1)) * circle(7, rng.uniform(0.5, 1.0))
        colour = rng.uniform(0.1, 0.7, 3).tolist()
        for across in (-n, 0, n):
            for down in (-n, 0, n):
                cv2.fillPoly(pixels, [np.rint(corners + [across, down]).astype(np.int32)], colour)
    return Texel(pixels)


def tartan(n: int = 120) -> Texel:
    """Return a texel of a wide and two thin crossing stripes on even ground, most of it."""
    stripes = np.tile([0.75, 0.19, 0.15], (n, 1))
    lines = ((0.1, 0.18, (0.12, 0.14, 0.12)), (0.55, 0.03, (0.9, 0.8, 0.3)), (0.72, 0.03, (0.9, 0.9, 0.9)))
    for first, width, colour in lines:
        stripes[round(first * n) : round((first + width) * n)] = colour
    return Texel((stripes[None] + stripes[:, None]) / 2)


def circle(count: int, squeeze: float) -> Floats:
    """Return points (count, 2) around the origin."""
    angle = 2 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angle), squeeze * np.sin(angle)], -1)


PRINT = np.array([[118.0, 10.0], [-12.0, 124.0]])


@pytest.fixture(scope="module")
def printed() -> Scene:
    return make_scene(print_of_blots(0), size=(300, 280), basis=PRINT, bend=4.0)


def canvas_of(photo: Floats) -> FlatPicture:
    return flat_canvas(photo, np.ones(photo.shape[:2], bool))


def painted(photo: Floats) -> FlatPicture:
    """Return the canvas of a photo that is cloth but for its outermost pixels."""
    return flat_canvas(photo, np.pad(np.ones((photo.shape[0] - 4, photo.shape[1] - 4), bool), 2))


@pytest.fixture(scope="module")
def followed(printed: Scene) -> tuple[FittedCloth, Fit]:
    cloth, found, _ = run(find_large(printed.photo, painted(printed.photo)))
    return cloth, found


def strokes(n: int = 150) -> Texel:
    """Return a texel of nine motifs of three thin strokes each."""
    rng, pixels = np.random.default_rng(0), np.full((n, n, 3), 0.25)
    for _ in range(9):
        middle, turn = rng.uniform(0, n, 2), rng.uniform(0, 2 * np.pi)
        ends = (
            circle(3, 1.0) @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]] * rng.uniform(5, 12, (3, 1))
        )
        for across in (-n, 0, n):
            for down in (-n, 0, n):
                points = np.rint(middle + [across, down] + np.insert(ends, [0, 1, 2], 0, axis=0)).astype(np.int32)
                cv2.polylines(pixels, [points], False, (0.8, 0.8, 0.75), 2)
    return Texel(pixels)


def test_motifs_of_few_pixels_are_told_in_an_enlarged_photo(monkeypatch: pytest.MonkeyPatch) -> None:
    basis = np.array([[50.0, -2.0], [5.0, 50.0]])
    scene = make_scene(strokes(), size=(240, 220), basis=basis, bend=2.0, noise=0.02)
    sure: list[float] = []
    for longest in (10, 1000):
        monkeypatch.setattr(magnifying, "LONGEST_PX", longest)
        (votes, found), *_ = find_likely(canvas_of(scene.photo))[1]
        assert np.abs(found - basis).max() < 3
        sure.append(votes)
    assert sure[1] > 1.5 * sure[0]


def test_noise_of_an_enlarged_photo_repeats_nowhere() -> None:
    photo = 0.5 + 0.1 * np.random.default_rng(0).standard_normal((300, 280, 3))
    assert not find_likely(canvas_of(photo))[1]


def test_where_the_enlarged_photo_is_certain_of_nothing_its_own_pixels_tell(
    printed: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(large_periods, "SURE", 1e3)
    pairs, ((_, basis), *_) = find_likely(canvas_of(printed.photo))
    assert len(pairs.points) == len(pairs_of(printed.photo).points)
    steps = np.linalg.solve(printed.basis, basis)
    assert np.abs(steps - np.rint(steps)).max() < 0.05


def pairs_of(photo: Floats) -> Pairs:
    return find_alike(canvas_of(photo).image, np.ones(photo.shape[:2], bool), STEP_PX)


@pytest.mark.parametrize("seed", range(3))
def test_votes_of_alike_keypoints_tell_vectors_that_fit_into_a_photo_twice(seed: int) -> None:
    scene = make_scene(print_of_blots(seed), size=(300, 280), basis=PRINT, bend=4.0)
    steps = np.linalg.solve(scene.basis, find_bases(count_votes(pairs_of(scene.photo), STEP_PX))[0][1])
    assert np.abs(steps - np.rint(steps)).max() < 0.1
    assert abs(np.linalg.det(np.rint(steps))) == 1


def test_a_few_large_texels_are_laid_where_they_are(printed: Scene, followed: tuple[FittedCloth, Fit]) -> None:
    cloth, found = followed
    cells = found.pieces[0].cells
    assert cells.mean() > 0.9
    uv, inside = cloth.mesh.to_pixels(found.pieces[0].uv, cells), cloth.mesh.pixels_of(cells)
    steps = np.rint(np.linalg.solve(printed.basis, cloth.basis))
    off = uv[inside] @ steps.T - printed.uv[inside]
    # What moves all copies alike cannot be told from the texel: places are compared with the same ones of other texels.
    place = np.floor(12 * (printed.uv[inside] % 1)).astype(int) @ [1, 12]
    count = np.bincount(place)
    off -= np.stack([np.bincount(place, column) / count for column in off.T], -1)[place]
    assert np.percentile(np.linalg.norm(off @ printed.basis.T, axis=-1), 90) < 1.0


def test_thin_lines_on_even_ground_are_laid_on_one_another() -> None:
    basis = np.array([[84.0, 4.0], [-3.0, 82.0]])
    scene = make_scene(tartan(), size=(400, 360), basis=basis, bend=3.0)
    inside = np.pad(np.ones((330, 290), bool), ((40, 30), (40, 30)))
    photo = np.where(inside[..., None], scene.photo, 0.93)
    cloth, found, weight = run(find_large(photo, canvas_of(photo)))
    steps = np.linalg.solve(basis, cloth.basis)
    assert np.abs(steps - np.rint(steps)).max() < 0.1
    assert weight.explained > 0
    assert cloth.mesh.pixels_of(found.cells)[inside].mean() > 0.4


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


def test_large_texels_are_looked_for_where_no_lattice_is_found(
    printed: Scene, followed: tuple[FittedCloth, Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(*_: object, **__: object) -> Job[list[Lattice]]:
        yield Progress(0.0, "")
        raise NoPatternError

    def found_large(photo: Floats, *_: object) -> Job[tuple[FittedCloth, Fit, Evidence]]:
        np.testing.assert_array_equal(photo, printed.photo)
        yield Progress(0.0, "")
        return (*followed, Evidence(-1.0, -0.1))

    monkeypatch.setattr(finding, "find_lattices", none)
    monkeypatch.setattr(finding, "find_large", found_large)
    monkeypatch.setattr(finding, "weigh", lambda *_: Evidence(-1.0, -0.1))
    found = run(find_cloth(printed.photo, painted(printed.photo), 0))
    assert found.followed.cells.mean() > 0.9
    assert abs(np.linalg.det(found.cloth.basis)) == pytest.approx(np.linalg.det(printed.basis), rel=0.1)


def leave(cloth: FittedCloth, found: Fit, *_: object) -> Job[tuple[FittedCloth, Fit]]:
    yield Progress(0.0, "")
    return cloth, found


@pytest.mark.parametrize(("shares", "kept"), [((0.2, 0.4), 1), ((0.4, 0.2), 0)])
def test_of_what_keypoints_and_a_lattice_tell_what_takes_away_more_of_the_error_is_kept(
    followed: tuple[FittedCloth, Fit], monkeypatch: pytest.MonkeyPatch, shares: tuple[float, float], kept: int
) -> None:
    share_of = iter(shares)
    monkeypatch.setattr(finding, "complete", leave)
    monkeypatch.setattr(finding, "weigh", lambda *_: Evidence(1.0, next(share_of)))
    finds = [Find(*followed, Evidence(1.0, 0.3)), Find(*followed, Evidence(2.0, -0.1), repeats=True)]
    assert run(best_completed(finds, 0)).repeats == finds[kept].repeats


@pytest.mark.parametrize(("share", "ends", "kept"), [(0.4, (2.0, 1.0, 3.0, 9.0), 3.0), (0.6, (2.0, 9.0), 2.0)])
def test_where_the_likeliest_find_leaves_doubts_others_may_explain_more_in_the_end(
    followed: tuple[FittedCloth, Fit], monkeypatch: pytest.MonkeyPatch, share: float, ends: tuple[float], kept: float
) -> None:
    explained = iter(ends)
    monkeypatch.setattr(finding, "complete", leave)
    monkeypatch.setattr(finding, "weigh", lambda *_: Evidence(next(explained), 0.3))
    finds = [Find(*followed, Evidence(9.0 - k, share)) for k in range(4)]
    assert run(best_completed(finds[::-1], 0)).explained == kept


@pytest.mark.parametrize(("explained", "completed"), [(1.0, 1), (3.0, 2)])
def test_a_find_is_completed_only_if_it_could_explain_more_than_another_one_does(
    followed: tuple[FittedCloth, Fit], monkeypatch: pytest.MonkeyPatch, explained: float, completed: int
) -> None:
    seen: list[int] = []

    def complete(cloth: FittedCloth, found: Fit, *_: object) -> Job[tuple[FittedCloth, Fit]]:
        seen.append(int(found.cells.sum()))
        return (yield from leave(cloth, found))

    monkeypatch.setattr(finding, "complete", complete)
    monkeypatch.setattr(finding, "weigh", lambda *_: Evidence(9.0, 0.3))
    cloth, fit = followed
    cells = fit.pieces[0].cells.copy()
    cells[len(cells) // 4 :] = False
    quarter = replace(fit, pieces=(replace(fit.pieces[0], cells=cells),))
    finds = [Find(cloth, fit, Evidence(8.0, 0.3)), Find(cloth, quarter, Evidence(explained, 0.3))]
    assert run(best_completed(finds, 0)).explained == 9.0
    assert len(seen) == completed


@pytest.mark.parametrize(
    ("explained", "share", "repeats", "texels", "alone"),
    [
        (1.0, 0.3, True, -1, True),
        (1.0, 0.3, True, 1, False),
        (-1.0, -0.3, True, -1, False),
        (1.0, 0.3, False, -1, False),
        (1.0, 0.7, False, 1, True),
    ],
)
def test_where_nobody_says_that_there_is_cloth_a_find_is_clear_or_shows_enough_large_texels(
    followed: tuple[FittedCloth, Fit],
    monkeypatch: pytest.MonkeyPatch,
    explained: float,
    share: float,
    repeats: bool,
    texels: int,
    alone: bool,
) -> None:
    cloth, fit = followed
    shown = (cloth.valid & cloth.mesh.pixels_of(fit.cells)).sum() / np.linalg.det(cloth.basis)
    monkeypatch.setattr(finding, "LEAST_UNTOLD", shown + texels)
    assert Find(cloth, fit, Evidence(explained, share), repeats=repeats).stands_alone == alone


@pytest.mark.parametrize(("share", "kept"), [(-1.0, 9.0), (0.3, 2.0)])
def test_a_find_that_completing_makes_incredible_stays_as_it_was(
    followed: tuple[FittedCloth, Fit], monkeypatch: pytest.MonkeyPatch, share: float, kept: float
) -> None:
    monkeypatch.setattr(finding, "complete", leave)
    monkeypatch.setattr(finding, "weigh", lambda *_: Evidence(2.0, share))
    assert run(best_completed([Find(*followed, Evidence(9.0, 0.4))], 0)).explained == kept


def test_nothing_large_is_found_in_noise_stripes_one_motif_or_a_print_seen_hardly_twice(printed: Scene) -> None:
    rng = np.random.default_rng(0)
    photo = np.full((220, 240, 3), 0.6) + rng.normal(0, 0.01, (220, 240, 3))
    photo[60:140, 70:150] = sett(80).pixels
    y, x = np.indices((220, 240))
    stripes = 0.5 + 0.3 * np.sin(0.1 * x + 0.04 * y)[..., None] * [1, 0.8, 0.6] + rng.normal(0, 0.01, (220, 240, 3))
    for picture in (photo, rng.random((220, 240, 3)), stripes, printed.photo[:170, :200]):
        with pytest.raises(NoPatternError):
            run(find_large(picture, painted(picture)))


def test_without_a_region_more_texels_are_asked_for(printed: Scene) -> None:
    with pytest.raises(NoPatternError):
        run(find_large(printed.photo, canvas_of(printed.photo)))


def test_of_lattices_that_are_as_likely_that_is_kept_whose_texel_explains_most(
    printed: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    canvas = painted(printed.photo)
    pairs, likely = find_likely(canvas)
    sure, basis = likely[0]
    wrong = basis @ np.array([[1.0, 0.0], [0.45, 1.0]])
    for surer, kept in ((1.1, basis), (1.5, wrong)):
        monkeypatch.setattr(
            large_periods, "find_likely", lambda _, surer=surer: (pairs, [(surer * sure, wrong), (sure, basis)])
        )
        cloth, _, weight = run(find_large(printed.photo, canvas))
        assert np.allclose(cloth.basis, kept, atol=1e-6)
        assert weight.is_clear == (kept is basis)


@pytest.mark.parametrize("is_told", [True, False])
def test_what_the_user_says_is_cloth_is_seen_however_much_of_it_is_followed(
    printed: Scene, monkeypatch: pytest.MonkeyPatch, is_told: bool
) -> None:
    photo = printed.photo.copy()
    photo[:70] = photo[:70].mean((0, 1))
    least = 0.95 * photo[..., 0].size / abs(np.linalg.det(PRINT))
    monkeypatch.setattr(large_periods, "LEAST_TEXELS", least)
    with nullcontext() if is_told else pytest.raises(NoPatternError):
        cloth, found, _ = run(find_large(photo, painted(photo), least=None if is_told else least))
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
        run(find_large(printed.photo, painted(printed.photo), least=least))
    assert len(seen) == laid


@pytest.mark.parametrize(("least", "is_found"), [(4.0, True), (20.0, False)])
def test_a_print_has_to_show_enough_texels_where_nobody_said_that_there_is_cloth(
    printed: Scene, monkeypatch: pytest.MonkeyPatch, least: float, is_found: bool
) -> None:
    monkeypatch.setattr(finding, "LEAST_UNTOLD", least)
    with nullcontext() if is_found else pytest.raises(NoPatternError):
        found = run(find_print(printed.photo, painted(printed.photo), 0))
        assert found.repeats
        assert found.stands_alone


@pytest.mark.parametrize(("least", "registered"), [(0.9, True), (1.1, False)])
def test_large_texels_are_registered_only_if_pairs_tell_of_enough_cloth(
    printed: Scene, monkeypatch: pytest.MonkeyPatch, least: float, registered: bool
) -> None:
    reached: list[int] = []

    def refit(_cloth: FittedCloth, found: Fit, **_: object) -> Fit:
        reached.append(int(found.cells.sum()))
        return found

    monkeypatch.setattr(large_periods, "refit", refit)
    canvas, photo = painted(printed.photo), printed.photo
    pairs, [(_, basis), *_] = find_likely(canvas)
    cloth, _ = lay(photo, canvas, pairs, basis, 0.0)
    near = reached.pop() * cloth.mesh.cell**2
    with nullcontext() if registered else pytest.raises(NoPatternError):
        lay(photo, canvas, pairs, basis, least * near)
    assert len(reached) == registered


@pytest.mark.parametrize("explained", [1.0, -1.0])
def test_what_nobody_said_is_cloth_is_followed_only_where_more_speaks_for_it_than_against_it(
    printed: Scene, monkeypatch: pytest.MonkeyPatch, explained: float
) -> None:
    grown: list[Fit] = []

    def follow(_cloth: FittedCloth, found: Fit, _step: Progress) -> Job[Fit]:
        yield Progress(0.0, "")
        grown.append(found)
        return found

    monkeypatch.setattr(large_periods, "weigh", lambda *_: Evidence(explained, explained))
    monkeypatch.setattr(large_periods, "followed", follow)
    monkeypatch.setattr(large_periods, "LEAST_TEXELS", 2.0)
    with nullcontext() if explained > 0 else pytest.raises(NoPatternError):
        run(find_large(printed.photo, canvas_of(printed.photo)))
    assert len(grown) == (explained > 0)


@pytest.mark.parametrize("in_region", [True, False])
def test_what_votes_are_certain_of_needs_nothing_else_where_the_user_says_that_there_is_cloth(
    printed: Scene, monkeypatch: pytest.MonkeyPatch, in_region: bool
) -> None:
    monkeypatch.setattr(large_periods, "weigh", lambda *_: Evidence(-1.0, 0.9))
    monkeypatch.setattr(large_periods, "LEAST_TEXELS", 2.0)
    if in_region:
        assert run(find_large(printed.photo, painted(printed.photo)))[1].cells.mean() > 0.9
    else:
        with pytest.raises(NoPatternError):
            run(find_large(printed.photo, canvas_of(printed.photo)))


@pytest.fixture(scope="module")
def small() -> Scene:
    return make_scene(motif(), basis=24.0 * np.eye(2), bend=0.0)


@pytest.mark.parametrize(("share", "tried", "refused"), [(0.9, 0, False), (0.4, 1, False), (0.02, 1, True)])
def test_large_texels_are_looked_for_where_a_lattice_explains_little_and_what_explains_less_is_refused(
    small: Scene, monkeypatch: pytest.MonkeyPatch, share: float, tried: int, refused: bool
) -> None:
    looked: list[Floats] = []

    def none(photo: Floats, *_: object, **__: object) -> None:
        looked.append(photo)
        raise NoPatternError

    monkeypatch.setattr(finding, "find_large", none)
    monkeypatch.setattr(finding, "weigh", lambda *_: Evidence(1.0, share))
    photo = small.photo[:110, :120]
    job = find_cloth(photo, canvas_of(photo), 0)
    if refused:
        with pytest.raises(NoPatternError):
            run(job)
    else:
        assert run(job).followed.cells.mean() > 0.9
    assert len(looked) == tried


def test_a_marked_texel_is_enough_where_there_are_few() -> None:
    scene = make_scene(sett(), size=(150, 160), basis=LARGE)
    marked = Proposal(np.array([75.0, 70.0]), scene.basis, 1.0)
    canvas, rng = canvas_of(scene.photo), np.random.default_rng(0)
    assert len(run(find_lattices(canvas, rng, start=marked))[0]) < 9
    one = canvas_of(np.clip(0.6 + rng.normal(0, 0.02, scene.photo.shape), 0, 1))
    with pytest.raises(NoPatternError):
        run(find_lattices(one, rng, start=marked))


def test_pairs_between_the_same_blocks_are_one_vote_that_of_the_first() -> None:
    rng = np.random.default_rng(3)
    points, (first, second) = rng.uniform(0, 100, (40, 2)), rng.integers(0, 40, (2, 300))
    block = rng.integers(0, 5, 40)
    kept = first_of_each(Pairs(points, first, second), block, 5)
    _, rows = np.unique(block[first] * 5 + block[second], return_index=True)
    assert np.array_equal(kept.first, first[rows])
    assert np.array_equal(kept.second, second[rows])
