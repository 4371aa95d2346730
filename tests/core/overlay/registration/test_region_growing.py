"""Cloth that is followed, where it surely lies right and where not."""

import numpy as np
import pytest

from core.arrays import Bools, Floats
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import flat_canvas
from core.overlay.registration.cloth import Fit, FittedCloth, estimate, make_cloth, measure
from core.overlay.registration.fitting import DOUBTFUL, from_the_surest
from core.overlay.registration.region_growing import all_followed, doubtful, surest
from core.overlay.registration.registration import ClothState
from core.progress import Progress, run
from tests.core.overlay.overlay_scenes import make_scene, motif

SIZE, FOLD = (160, 240), 144
BASIS = np.array([[14.0, 2.0], [-1.0, 13.0]])
SCENE = make_scene(motif(), size=SIZE, basis=BASIS, bend=0.0, noise=0.004)
STEP = Progress(0.0, "")


def cloth_of(photo: Floats) -> tuple[FittedCloth, ClothState]:
    """Return the cloth of a photo and its whole mesh where the scene has it."""
    keys = np.array([(i, j) for i in range(-3, 20) for j in range(-3, 20)])
    points = keys @ BASIS.T
    inside = (points > 4).all(1) & (points < np.array(SIZE[::-1]) - 4).all(1)
    keys, points = keys[inside], points[inside]
    lattice = Lattice(keys, PatchFrames(points, np.repeat(BASIS[None], len(keys), 0), np.ones(len(keys))))
    cloth = make_cloth(photo, flat_canvas(photo, np.ones(SIZE, bool)), lattice, np.eye(2))
    uv = cloth.mesh.positions() @ np.linalg.inv(BASIS).T
    return cloth, ClothState(uv, 0.9 + 0.25 * np.sin(uv @ np.array([0.5, 0.6])), np.ones(cloth.mesh.cells, bool))


def beyond(cloth: FittedCloth) -> Bools:
    """Return the cells beyond the fold."""
    return np.asarray(np.indices(cloth.mesh.cells)[1] * cloth.mesh.cell >= FOLD, np.bool_)


def past_a_fold(shift: tuple[float, float] = (0.5, 0.4)) -> tuple[FittedCloth, ClothState, Fit]:
    """Return a cloth, its true mesh, and a fit of it that is a part of a texel off beyond a fold."""
    cloth, true = cloth_of(SCENE.photo)
    texel = estimate(cloth, (ClothState(true.uv, true.rho, ~beyond(cloth)),))
    off = cloth.mesh.nodes_of(beyond(cloth))[..., None] * np.array(shift)
    return cloth, true, measure(cloth, texel, (ClothState(true.uv + off, true.rho, true.cells),))


def test_cloth_beyond_a_fold_that_lies_beside_the_pattern_is_doubtful() -> None:
    cloth, _, found = past_a_fold()
    assert doubtful(cloth, found) > 0.8 * cloth.steps_of(beyond(cloth)) > DOUBTFUL
    kept, _ = surest(cloth, found)
    assert not kept.cells[:, FOLD // cloth.mesh.cell :].any()
    assert kept.cells[:, : FOLD // cloth.mesh.cell - 4].mean() > 0.95


def test_cloth_that_lies_right_is_not_doubtful() -> None:
    cloth, true, found = past_a_fold((0.0, 0.0))
    assert doubtful(cloth, found) == 0
    assert surest(cloth, found)[0].cells.mean() > 0.99
    assert np.array_equal(found.pieces[0].uv, true.uv)


def test_what_lies_beside_the_pattern_gives_way_to_a_piece_that_lies_right() -> None:
    cloth, true, found = past_a_fold()
    whole = run(from_the_surest(cloth, found, 0))
    assert whole is not None
    away = np.full(cloth.mesh.nodes, np.nan)
    for piece in whole.pieces:
        nodes = cloth.mesh.nodes_of(piece.cells)
        turns = (piece.uv - true.uv + 0.5) % 1 - 0.5
        away[nodes] = np.linalg.norm(turns @ BASIS.T, axis=-1)[nodes]
    assert np.isfinite(away[1:-1, 1:-1]).mean() > 0.9
    assert np.nanmean(away > 1.0) < 0.05


def test_where_no_other_piece_belongs_nothing_is_followed_anew() -> None:
    cloth, _, found = past_a_fold((0.0, 0.0))
    assert run(from_the_surest(cloth, found, 0)) is None


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_every_piece_is_followed_until_another_begins(order: tuple[int, int]) -> None:
    cloth, true, found = past_a_fold((0.0, 0.0))
    columns = np.indices(cloth.mesh.cells)[1] * cloth.mesh.cell
    starts = (columns < 60, (columns >= 180) & (columns < 220))
    pieces = tuple(ClothState(true.uv, true.rho, np.asarray(starts[k], np.bool_)) for k in order)
    whole = run(all_followed(cloth, Fit(found.texel, pieces, found.tolerance), STEP))
    assert sum(piece.cells.sum() for piece in whole.pieces) == whole.cells.sum()
    assert whole.cells[1:-1, 1:-1].mean() > 0.97
    assert whole.pieces[0].cells[:, 0].any()
