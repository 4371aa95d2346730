"""Further pieces of cloth."""

import numpy as np
import pytest

from core.arrays import Bools, Floats
from core.overlay.detection.alignment import FlatPicture, PatchFrames, Template
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import flat_canvas, grown_piece
from core.overlay.registration import cloth as cloth_module
from core.overlay.registration import pieces
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.fitting import begun, complete
from core.progress import run
from tests.core.overlay.overlay_scenes import make_scene
from tests.core.overlay.prints import LARGE, sett

SIZE, BELT = (120, 290), slice(165, 185)


def belted() -> tuple[Floats, Floats]:
    """Return a photo of a few large texels on both sides of a belt, where they do not meet, and their coordinates."""
    scene = make_scene(sett(), size=SIZE, basis=LARGE, bend=1.0)
    photo = scene.photo.copy()
    photo[:, BELT.stop :] = np.roll(photo, (31, 25), (0, 1))[:, BELT.stop :]
    photo[:, BELT] = [0.8, 0.75, 0.2]
    return photo, scene.uv


@pytest.fixture(scope="module")
def found() -> tuple[FittedCloth, Fit]:
    """Return the cloth that is found from one side of the belt, and from single texels beyond it."""
    photo, uv = belted()
    inside: Bools = np.ones(SIZE, bool)
    inside[:, BELT] = False
    keys = np.array([(0, 1), (1, 1), (2, 1)])
    points = np.array([np.argwhere(np.linalg.norm(uv - key, axis=-1) < 0.02).mean(0)[::-1] for key in keys])
    lattice = Lattice(keys, PatchFrames(points, np.tile(LARGE, (3, 1, 1)), np.ones(3)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cloth_module, "STEP_PX", 1e3)  # as of a lattice that grew, whose steps are texels
        cloth, fit = run(begun(photo, flat_canvas(photo, inside), lattice, 0, trusted=True))

    def single(canvas: FlatPicture, template: Template, frame: PatchFrames) -> Lattice:
        return grown_piece(canvas, template, frame)[np.array([0])]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pieces, "grown_piece", single)
        return run(complete(cloth, fit, [], 0))


def test_of_few_texels_one_is_enough_to_go_on_from_beyond_a_belt(found: tuple[FittedCloth, Fit]) -> None:
    cloth, fit = found
    covered = cloth.mesh.pixels_of(fit.cells)
    assert len(fit.pieces) == 2
    assert covered[10:-10, 10:150].mean() > 0.95
    assert covered[10:-10, 200:-10].mean() > 0.8
