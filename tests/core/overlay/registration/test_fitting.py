"""Cloth registered from a lattice that is known: the user's, or that of a find that goes on."""

from dataclasses import replace

import numpy as np
import pytest

from core.overlay.decomposition import decompose
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError, flat_canvas
from core.overlay.registration import cloth as cloth_module
from core.overlay.registration import fitting
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.fitting import begun, complete
from core.overlay.registration.pieces import join_by
from core.progress import Job, Progress, run
from tests.core.overlay.overlay_scenes import Scene, make_scene
from tests.core.overlay.prints import print_of_blots

LARGE, SIZE = np.array([[72.0, 6.0], [-5.0, 70.0]]), (220, 400)


@pytest.fixture(scope="module")
def scene() -> Scene:
    """Return cloth with large texels."""
    return make_scene(print_of_blots(0), size=SIZE, basis=LARGE, bend=3.0)


def lattice_of(scene: Scene, columns: slice) -> Lattice:
    """Return the vertices of the scene that lie in these columns, as somebody might set them."""
    keys, points = [], []
    for key in np.ndindex(8, 6):
        place = np.array(key) - [1, 1]
        away = np.linalg.norm(scene.uv[:, columns] - place, axis=-1)
        row, column = np.unravel_index(away.argmin(), away.shape)
        if away[row, column] < 0.02:
            keys.append(place)
            points.append([column + columns.start, row])
    frames = PatchFrames(np.array(points, np.float64), np.tile(LARGE, (len(keys), 1, 1)), np.ones(len(keys)))
    return Lattice(np.array(keys), frames)


def test_large_texels_are_registered_on_a_mesh_as_fine_as_narrow_folds(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    x = np.indices(SIZE)[1]
    uv = scene.uv + 2.0 * np.sin(2 * np.pi * x / 30)[..., None] @ np.linalg.inv(LARGE)[:, :1].T
    photo = np.clip(scene.shading[..., None] * print_of_blots(0)(uv), 0, 1)
    lattice = [lattice_of(replace(scene, uv=uv), slice(0, SIZE[1]))]
    inside = np.pad(np.ones((SIZE[0] - 4, SIZE[1] - 4), np.float32), 2)
    fine = run(decompose(photo, region=inside, lattice=lattice)).explained
    monkeypatch.setattr(cloth_module, "STEP_PX", 1e3)
    coarse = run(decompose(photo, region=inside, lattice=lattice)).explained
    assert fine > 1.15 * coarse


def test_a_lattice_of_large_texels_in_two_parts_leads_to_both(scene: Scene) -> None:
    inside = np.pad(np.ones((SIZE[0] - 4, SIZE[1] - 4), bool), 2)
    inside[:, 200:215] = False
    one, other = lattice_of(scene, slice(0, 200)), lattice_of(scene, slice(215, SIZE[1]))
    cloth, found = run(begun(scene.photo, flat_canvas(scene.photo, inside), one, 0, trusted=True))
    both = run(join_by(cloth, found, other, Progress(0.5, "")))
    assert not cloth.mesh.pixels_of(found.cells)[:, 215:].any()
    assert cloth.mesh.pixels_of(both.cells)[10:-10, 225:-10].mean() > 0.9


@pytest.mark.parametrize("both", [False, True])
def test_a_piece_that_following_gives_up_is_gone_and_so_is_the_cloth_without_another(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, both: bool
) -> None:
    left = np.indices(SIZE)[1] < SIZE[1] // 2
    lattice = lattice_of(scene, slice(0, SIZE[1]))
    cloth, found = run(begun(scene.photo, flat_canvas(scene.photo, np.ones(SIZE, bool)), lattice, 0, trusted=True))
    cells = left[:: cloth.mesh.cell, :: cloth.mesh.cell][tuple(map(slice, found.cells.shape))] & found.cells
    halves = (replace(found.pieces[0], cells=found.cells & ~cells), replace(found.pieces[0], cells=cells))
    pieces = halves if both else found.pieces
    times = 0

    def give_up(cloth: FittedCloth, found: Fit, step: Progress) -> Job[Fit]:
        nonlocal times
        times += 1
        yield step
        last = found.pieces[-1]
        return (
            found
            if times == 1
            else replace(found, pieces=(*found.pieces[:-1], replace(last, cells=last.cells & False)))
        )

    def leave(cloth: FittedCloth, found: Fit, *_: object) -> Job[Fit]:
        yield Progress(0.5, "")
        return found

    monkeypatch.setattr(fitting, "followed", give_up)
    monkeypatch.setattr(fitting, "with_more_pieces", leave)
    job = complete(cloth, replace(found, pieces=pieces), [], 0)
    if both:
        assert [piece.cells.any() for piece in run(job)[1].pieces] == [True]
    else:
        with pytest.raises(NoPatternError):
            run(job)
