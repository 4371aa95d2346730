"""Further pieces of cloth with large texels: a sleeve that lies turned beside a belt."""

from dataclasses import replace

import numpy as np
import pytest

from core.arrays import Bools, Floats
from core.overlay.detection.alignment import FlatPicture, PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import flat_canvas
from core.overlay.registration import pieces
from core.overlay.registration.cloth import Fit, FittedCloth, estimate, make_cloth, make_divided_cloth, measure
from core.overlay.registration.matched_keypoints import agreement, find_starts, match
from core.overlay.registration.pieces import with_more_pieces
from core.overlay.registration.registration import ClothState
from core.progress import run
from tests.core.overlay.overlay_scenes import make_scene
from tests.core.overlay.prints import print_of_blots

SIDE, STEPS, SIZE = np.array([[72.0, 6.0], [-5.0, 70.0]]), 3, (200, 380)
BELT = [0.8, 0.75, 0.2]
BODY, SLEEVE = (slice(None), slice(0, 190)), (slice(20, -20), slice(230, 370))


def photo_with_sleeve(seed: int = 0) -> tuple[Floats, Floats]:
    """Return a photo of cloth, a belt and a turned sleeve of a print of that seed, and its coordinates."""
    turn = np.deg2rad(55)
    turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    body = make_scene(print_of_blots(0), size=SIZE, basis=SIDE, bend=2.0)
    sleeve = make_scene(print_of_blots(seed), size=SIZE, basis=turned @ SIDE, bend=2.0, seed=1)
    photo, uv = np.full((*SIZE, 3), BELT), np.full((*SIZE, 2), np.nan)
    for scene, where in ((body, BODY), (sleeve, SLEEVE)):
        photo[where], uv[where] = scene.photo[where], scene.uv[where]
    return photo, uv


def followed_body(photo: Floats, uv: Floats) -> tuple[FittedCloth, Fit]:
    """Return the cloth of a photo with its body registered."""
    inside: Bools = np.ones(SIZE, bool)
    inside[:3] = False
    frames = PatchFrames(np.array([[80.0, 100.0]]), SIDE[None] / STEPS, np.ones(1))
    lattice = Lattice(np.zeros((1, 2), np.int64), frames)
    cloth = make_cloth(photo, flat_canvas(photo, inside), lattice, STEPS * np.eye(2))
    at = np.clip(np.rint(cloth.mesh.positions()).astype(int), 0, np.array(SIZE[::-1]) - 1)
    known = uv[at[..., 1], at[..., 0]]
    cells = cloth.mesh.cell_means(np.isfinite(uv[..., 0]).astype(float)) == 1
    cells[:, at[0, :-1, 0] > 180] = False
    state = ClothState(np.nan_to_num(known), cloth.brightness, cells)
    return cloth, measure(cloth, estimate(cloth, (state,)), (state,))


@pytest.fixture(scope="module")
def sewn() -> tuple[FittedCloth, Fit, Floats]:
    photo, uv = photo_with_sleeve()
    return *followed_body(photo, uv), uv


def missed_px(cloth: FittedCloth, state: ClothState, uv: Floats) -> Floats:
    """Return by how much (n,) a state's coordinates miss the true ones, but for whole texels, on the sleeve."""
    inside = cloth.mesh.pixels_of(state.cells)
    inside[:, :230] = False
    inside &= np.isfinite(uv[..., 0])
    missed = (cloth.mesh.to_pixels(state.uv, state.cells) - uv)[inside]
    return np.asarray(np.linalg.norm((missed - np.rint(missed)) @ SIDE.T, axis=-1), np.float64)


def test_a_turned_sleeve_is_told_from_where_its_keypoints_lie_in_the_texel(
    sewn: tuple[FittedCloth, Fit, Floats],
) -> None:
    cloth, fit, uv = sewn
    start = next(find_starts(cloth, match(cloth, fit), fit.cells))
    missed = missed_px(cloth, start, uv)
    assert len(missed) > 1500
    assert np.percentile(missed, 90) < 0.1 * np.sqrt(np.linalg.det(SIDE))


def test_it_is_followed_from_there(sewn: tuple[FittedCloth, Fit, Floats]) -> None:
    cloth, fit, uv = sewn
    found = run(with_more_pieces(cloth, fit, np.random.default_rng(0), 0.5))
    assert cloth.mesh.pixels_of(found.cells)[SLEEVE].mean() > 0.8
    assert np.percentile(missed_px(cloth, found.pieces[-1], uv), 90) < 1.0


@pytest.mark.parametrize("is_divided", [True, False])
def test_what_looks_like_a_step_is_not_looked_for_where_steps_are_parts_of_a_texel(
    sewn: tuple[FittedCloth, Fit, Floats], monkeypatch: pytest.MonkeyPatch, *, is_divided: bool
) -> None:
    cloth, fit, _ = sewn
    asked: list[Lattice] = []

    def find_none(_canvas: FlatPicture, known: Lattice, _rng: "np.random.Generator") -> PatchFrames:
        asked.append(known)
        return known.frames[np.zeros(0, np.int64)]

    monkeypatch.setattr(pieces, "find_texels", find_none)
    found = run(with_more_pieces(replace(cloth, is_divided=is_divided), fit, np.random.default_rng(0), 0.5))
    assert len(asked) == (not is_divided)
    assert cloth.mesh.pixels_of(found.cells)[SLEEVE].mean() > 0.8


def test_texels_larger_than_a_motif_are_divided() -> None:
    photo, _ = photo_with_sleeve()
    canvas = flat_canvas(photo, np.ones(SIZE, np.bool_))
    for times, is_divided in ((1.0, True), (0.3, False)):
        frames = PatchFrames(np.array([[80.0, 100.0]]), times * SIDE[None], np.ones(1))
        lattice = Lattice(np.zeros((1, 2), np.int64), frames)
        assert make_divided_cloth(photo, canvas, lattice).is_divided == is_divided


def test_a_piece_that_shows_few_keypoints_is_followed() -> None:
    whole, true = photo_with_sleeve()
    photo, uv = whole.copy(), true.copy()
    photo[:, 190:], uv[:, 190:] = BELT, np.nan
    part = slice(75, 125), slice(275, 325)
    photo[part], uv[part] = whole[part], true[part]
    cloth, fit = followed_body(photo, uv)
    found = run(with_more_pieces(cloth, fit, np.random.default_rng(0), 0.5))
    assert cloth.mesh.pixels_of(found.cells)[part].mean() > 0.6
    assert np.percentile(missed_px(cloth, found.pieces[-1], uv), 90) < 2.0


@pytest.mark.parametrize("seed", range(3, 8))
def test_a_sleeve_of_another_print_is_not_followed(seed: int) -> None:
    cloth, fit = followed_body(*photo_with_sleeve(seed))
    found = run(with_more_pieces(cloth, fit, np.random.default_rng(0), 0.5))
    assert not cloth.mesh.pixels_of(found.cells)[SLEEVE].any()


def test_keypoints_confirm_a_piece_that_lies_as_they_say(sewn: tuple[FittedCloth, Fit, Floats]) -> None:
    cloth, fit, _ = sewn
    matches = match(cloth, fit)
    piece = run(with_more_pieces(cloth, fit, np.random.default_rng(0), 0.5)).pieces[-1]
    assert matches.confirm(cloth.mesh, piece) > 10
    assert matches.confirm(cloth.mesh, replace(piece, uv=piece.uv + [3.0, -2.0])) > 10
    assert matches.confirm(cloth.mesh, replace(piece, uv=piece.uv + [0.5, 0.0])) < 2
    assert matches.confirm(cloth.mesh, replace(piece, cells=np.zeros_like(piece.cells))) == 0


def test_nothing_begins_where_cells_are_taken_meanwhile(sewn: tuple[FittedCloth, Fit, Floats]) -> None:
    cloth, fit, _ = sewn
    taken = fit.cells.copy()
    starts = find_starts(cloth, match(cloth, fit), taken)
    first = next(starts)
    assert not (first.cells & fit.cells).any()
    taken |= first.cells
    rest = list(starts)
    assert rest
    assert not any((start.cells & first.cells).any() for start in rest)


def test_matches_agree_by_whole_texels_only(sewn: tuple[FittedCloth, Fit, Floats]) -> None:
    cloth, fit, _ = sewn
    matches = match(cloth, fit)
    sure, agree = agreement(matches)
    best = int(sure.argmax())
    at, uv, slopes = matches.points[best], matches.uv[best], matches.slopes[best]
    assert len(agree[best]) > 10
    same = matches.agreeing(at, uv + [2.0, -1.0], slopes)
    np.testing.assert_array_equal(np.flatnonzero(same), np.sort(agree[best]))
    assert not matches.agreeing(at, uv + [0.5, 0.0], slopes)[agree[best]].any()


def test_where_nothing_is_followed_or_left_there_is_no_match(sewn: tuple[FittedCloth, Fit, Floats]) -> None:
    cloth, fit, _ = sewn
    for cells in (np.zeros_like(fit.cells), np.ones_like(fit.cells)):
        state = ClothState(fit.pieces[0].uv, fit.pieces[0].rho, cells)
        assert not list(find_starts(cloth, match(cloth, Fit(fit.texel, (state,), fit.tolerance)), cells))
