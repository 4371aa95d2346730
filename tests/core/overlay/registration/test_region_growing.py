"""The growth of a registered mesh to where the cloth ends."""

import numpy as np
import pytest

from core.arrays import Bools
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import flat_canvas
from core.overlay.registration import region_growing
from core.overlay.registration.cloth import Fit, FittedCloth, estimate, make_cloth, measure, starting_state
from core.overlay.registration.region_growing import followed
from core.overlay.registration.registration import ClothState
from core.progress import Progress, run
from tests.core.overlay.overlay_scenes import make_scene, motif

BASIS = 24.0 * np.eye(2)


@pytest.fixture(scope="module")
def begun() -> tuple[FittedCloth, Fit]:
    """Return a cloth that is registered around the middle of a photo."""
    return begin_with(0.0)


def begin_with(noise: float) -> tuple[FittedCloth, Fit]:
    """Return a cloth that is registered around the middle of a photo with so much noise in each channel."""
    scene = make_scene(motif(), size=(140, 150), basis=BASIS, bend=1.0)
    photo = scene.photo + np.random.default_rng(0).normal(0, noise, scene.photo.shape)
    canvas = flat_canvas(photo, np.ones((140, 150), bool))
    keys = np.array([(i, j) for i in (2, 3) for j in (2, 3)])
    points = np.array([np.argwhere(np.linalg.norm(scene.uv - key, axis=-1) < 0.05).mean(0)[::-1] for key in keys])
    lattice = Lattice(keys, PatchFrames(points, np.tile(BASIS, (len(keys), 1, 1)), np.ones(len(keys))))
    cloth = make_cloth(photo, canvas, lattice, np.eye(2))
    pieces = (starting_state(cloth, lattice),)
    return cloth, measure(cloth, estimate(cloth, pieces), pieces)


def test_cloth_is_followed_to_where_it_ends(begun: tuple[FittedCloth, Fit]) -> None:
    cloth, found = begun
    assert found.cells.mean() < 0.4
    assert run(followed(cloth, found, Progress(0.0))).cells.mean() > 0.9


def test_cloth_is_followed_on_a_noisy_photo(begun: tuple[FittedCloth, Fit]) -> None:
    cloth, found = begin_with(0.1)
    found = measure(cloth, begun[1].texel, found.pieces)
    assert found.tolerance.noise > 0.3 * found.tolerance.own
    assert run(followed(cloth, found, Progress(0.0))).cells.mean() > 0.9


def test_growth_ends_where_cells_are_taken_and_given_up_by_turns(
    begun: tuple[FittedCloth, Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    cloth, found = begun
    start, trials = found.pieces[-1].cells, list[Bools]()

    def widen(_cloth: FittedCloth, state: ClothState, trial: Bools, _found: Fit) -> ClothState:
        """Take every second of the cells that were tried first, and give up the others."""
        trials.append(trial)
        odd = np.arange(trial.shape[1]) % 2 == len(trials) % 2
        return ClothState(state.uv, state.rho, start | (trials[0] & odd))

    monkeypatch.setattr(region_growing, "widen", widen)
    run(followed(cloth, found, Progress(0.0)))
    assert len(trials) == 3
