"""Cloth that is seen but not followed."""

import numpy as np
import pytest

from core.arrays import Bools, Floats
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import flat_canvas
from core.overlay.pixels.filling import Filling, amid, carried_on, filled
from core.overlay.registration.cloth import Fit, FittedCloth, estimate, make_cloth, measure
from core.overlay.registration.registration import ClothState
from tests.core.overlay.overlay_scenes import COLOURS, make_scene, motif

SCENE = make_scene(motif(), bend=0.0, noise=0.004)
SIZE = SCENE.shading.shape
HOLE = (slice(72, 92), slice(72, 96))


def straight(photo: Floats, valid: Bools) -> tuple[FittedCloth, ClothState]:
    """Return the cloth of a photo and its whole mesh where the scene has it."""
    keys = np.array([(i, j) for i in range(-2, 9) for j in range(-2, 9)])
    points = keys @ SCENE.basis.T
    inside = (points > 4).all(1) & (points < np.array(SIZE[::-1]) - 4).all(1)
    keys, points = keys[inside], points[inside]
    lattice = Lattice(keys, PatchFrames(points, np.repeat(SCENE.basis[None], len(keys), 0), np.ones(len(keys))))
    cloth = make_cloth(photo, flat_canvas(photo, valid), lattice, np.eye(2))
    uv = cloth.mesh.positions() @ np.linalg.inv(SCENE.basis).T
    return cloth, ClothState(uv, 0.9 + 0.25 * np.sin(uv @ np.array([0.5, 0.6])), np.ones(cloth.mesh.cells, bool))


def filling(photo: Floats, missing: Bools, valid: Bools | None = None) -> tuple[FittedCloth, Filling]:
    """Return the cloth and what is filled where it is missing."""
    cloth, whole = straight(photo, np.ones(SIZE, bool) if valid is None else valid)
    cells = cloth.mesh.cell_means(missing.astype(float)) == 0
    piece = ClothState(whole.uv + 0.0, whole.rho + 0.0, cells)
    # What is not followed has values that mean nothing.
    unknown = ~cloth.mesh.nodes_of(cells)
    piece.uv[unknown], piece.rho[unknown] = 0.0, 9.0
    found: Fit = measure(cloth, estimate(cloth, (piece,)), (piece,))
    return cloth, filled(cloth, found, [piece], [cloth.mesh.pixels_of(cells) & cloth.valid])


def fill(photo: Floats, missing: Bools, valid: Bools | None = None) -> tuple[Floats, Bools]:
    """Return the coordinates (H, W, 2) and the pixels that the mesh fills of those that are missing."""
    cloth, more = filling(photo, missing, valid)
    if not more.pieces:
        return np.zeros((*SIZE, 2)), np.zeros(SIZE, bool)
    return cloth.mesh.smooth_to_pixels(more.pieces[0].uv, (slice(0, SIZE[0]), slice(0, SIZE[1]))), more.masks[0]


def in_region(photo: Floats, missing: Bools) -> Bools:
    """Return the pixels that are filled of those that are missing from a region that the artist gave."""
    valid = np.ones(SIZE, bool)
    valid[:6] = False
    more = filling(photo, missing, valid)[1]
    return np.asarray(np.any([more.apart, *more.masks], axis=0), np.bool_)


def in_hole() -> Bools:
    missing = np.zeros(SIZE, bool)
    missing[HOLE] = True
    return missing


def with_hole(patch: Floats) -> Floats:
    photo = SCENE.photo.copy()
    photo[HOLE] = patch
    return photo


def test_pattern_that_slipped_is_cloth_and_lies_as_around_it() -> None:
    slipped = np.roll(SCENE.photo, (11, 7), (0, 1))[HOLE]
    uv, more = fill(with_hole(slipped), in_hole())
    assert more[in_hole()].mean() > 0.7
    off = np.linalg.norm((uv - SCENE.uv)[more] @ SCENE.basis.T, axis=-1)
    assert off.max() < 0.5


@pytest.mark.parametrize("colour", [[0.1, 0.7, 0.2], [0.95, 0.9, 0.1]])
def test_button_keeps_its_pixels(colour: list[float]) -> None:
    _, more = fill(with_hole(np.array(colour)), in_hole())
    assert not more[74:90, 74:94].any()


def test_belt_of_a_colour_of_the_pattern_keeps_its_pixels() -> None:
    photo, belt = SCENE.photo.copy(), np.zeros(SIZE, bool)
    belt[60:100, 30:160] = True
    photo[belt] = COLOURS[1]
    assert fill(photo, belt)[1].mean() < 0.1 * belt.mean()


def test_cloth_at_the_edge_is_filled_only_where_the_artist_says_that_it_is_cloth() -> None:
    missing, valid = np.zeros(SIZE, bool), np.ones(SIZE, bool)
    missing[:, 172:] = True
    assert not fill(SCENE.photo, missing)[1].any()
    valid[:6] = False
    more = fill(SCENE.photo, missing, valid)[1]
    assert more[10:160, 174:186].mean() > 0.8
    assert not more[:6].any()


def test_a_gap_between_pieces_is_cloth_though_it_is_open_at_one_end() -> None:
    """Two sheets that meet in the middle were followed up to a strip, which leads out of the picture."""
    missing = np.zeros(SIZE, bool)
    missing[:120, 92:108] = True
    assert fill(SCENE.photo, missing)[1][10:115, 94:106].mean() > 0.8
    belt = SCENE.photo.copy()
    belt[missing] = [0.1, 0.7, 0.2]
    assert fill(belt, missing)[1].mean() < 0.1 * missing.mean()


FAR = (slice(68, 98), slice(168, 190))
"""Further than a lattice step from what is followed where `at_the_edge` is missing."""


def at_the_edge() -> Bools:
    missing = np.zeros(SIZE, bool)
    missing[40:126, 136:] = True
    return missing


def test_cloth_in_a_region_is_filled_however_far() -> None:
    assert in_region(SCENE.photo, at_the_edge())[FAR].mean() > 0.9


def test_hand_in_a_region_keeps_its_pixels() -> None:
    photo = SCENE.photo.copy()
    photo[64:102, 156:] = [0.8, 0.55, 0.4]
    filled_there = in_region(photo, at_the_edge())
    assert not filled_there[68:98, 160:].any()
    assert filled_there[44:60, 150:].mean() > 0.9


def test_cloth_in_a_region_is_filled_however_large() -> None:
    missing = np.zeros(SIZE, bool)
    missing[:, 90:] = True
    assert in_region(SCENE.photo, missing)[20:150, 100:].mean() > 0.9


def test_plain_cloth_of_a_colour_of_the_pattern_is_filled_in_a_region() -> None:
    """A leg on which the motifs were not followed has more of the ground between them than the texel has."""
    missing, photo = np.zeros(SIZE, bool), SCENE.photo.copy()
    missing[:, 90:] = True
    photo[:, 96:] = 0.9 * COLOURS[0]
    assert in_region(photo, missing)[20:150, 100:].mean() > 0.9


def test_thin_thing_of_a_colour_of_the_pattern_keeps_its_pixels_beside_the_cloth() -> None:
    missing, photo = np.zeros(SIZE, bool), SCENE.photo.copy()
    missing[:, 100:] = True
    photo[:, 104:] = [0.2, 0.75, 0.15]
    photo[80:87, 96:] = 0.8 * COLOURS[1]
    assert not in_region(photo, missing)[:, 120:].any()


def test_spot_in_much_more_light_amid_the_cloth_of_a_region_is_filled() -> None:
    photo = 0.5 * SCENE.photo
    photo[HOLE] *= 1.9
    assert in_region(photo, in_hole())[in_hole()].mean() > 0.9
    assert fill(photo, in_hole())[1][in_hole()].mean() < 0.5


def test_cloth_is_not_carried_on_where_it_would_be_crushed() -> None:
    cloth, whole = straight(SCENE.photo, np.ones(SIZE, bool))
    cells = np.ones(cloth.mesh.cells, bool)
    cells[:, 8:11] = False
    uv = whole.uv.copy()
    # Two texels less beyond the gap than there is room for.
    uv[:, 11:] += [-2.0, 0.0]
    wanted = cloth.mesh.pixels_of(~cells)
    assert carried_on(cloth, ClothState(whole.uv, whole.rho, cells), wanted)[1][wanted].mean() > 0.95
    crushed = carried_on(cloth, ClothState(uv, whole.rho, cells), wanted)[1]
    assert crushed[wanted].mean() < 0.2


def test_gap_in_which_cloth_would_be_crushed_is_filled_from_its_sides() -> None:
    cloth, whole = straight(SCENE.photo, np.ones(SIZE, bool))
    cells = np.ones(cloth.mesh.cells, bool)
    cells[4:-4, 8:11] = False
    uv = whole.uv.copy()
    uv[:, 11:] += [-2.0, 0.0]
    piece = ClothState(uv, whole.rho, cells)
    found = measure(cloth, estimate(cloth, (ClothState(whole.uv, whole.rho, cells),)), (piece,))
    gap = cloth.mesh.pixels_of(~cells)
    more = filled(cloth, found, [piece], [~gap])
    assert more.apart[gap].mean() > 0.5
    assert not (more.apart & np.any([*more.masks, ~gap], axis=0)).any()


def test_spot_is_amid_cloth_also_at_the_rim_and_a_cuff_is_not() -> None:
    cloth = np.zeros((40, 50), bool)
    cloth[10:30, 10:30] = True
    spot, cuff = np.zeros_like(cloth), np.zeros_like(cloth)
    spot[10:15, 15:21] = True
    cuff[14:20, 30:36] = True
    kept = amid(spot | cuff, cloth & ~spot, 36)
    np.testing.assert_array_equal(kept, spot)
    assert not amid(spot, cloth & ~spot, 29).any()
