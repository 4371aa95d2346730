"""Small texels are looked for in the enlarged photo, and what is found there is the photo's own cloth."""

import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.detection.alignment import FlatPicture
from core.overlay.detection.seeding import flat_canvas
from core.overlay.search import finding
from core.overlay.search.finding import Find, find_cloth
from core.overlay.search.magnified import TIMES, can_be_magnified, magnified
from core.progress import Job, Progress, run
from tests.core.overlay.overlay_scenes import make_scene, motif

SCENE = make_scene(motif(), size=(110, 120), basis=np.array([[9.0, 1.2], [-0.8, 8.5]]), bend=1.5)
EVERYWHERE = np.ones(SCENE.photo.shape[:2], bool)


def test_what_is_found_enlarged_lies_on_the_photos_pixels(monkeypatch: pytest.MonkeyPatch) -> None:
    search = finding.find_by_lattice

    def enlarged_only(
        photo: Floats, canvas: FlatPicture, place: FlatPicture, seed: int, texel_px: float | None
    ) -> Job[list[Find]]:
        if photo.shape == SCENE.photo.shape:
            yield Progress(0.0)
            return []
        return (yield from search(photo, canvas, place, seed, texel_px))

    monkeypatch.setattr(finding, "find_by_lattice", enlarged_only)
    cloth, found = run(find_cloth(SCENE.photo, flat_canvas(SCENE.photo, EVERYWHERE), 0))
    assert list(cloth.mesh.shape) == list(EVERYWHERE.shape)
    steps = np.linalg.solve(SCENE.basis, cloth.basis)
    np.testing.assert_allclose(steps, np.rint(steps), atol=0.1)
    assert abs(np.linalg.det(steps)) == pytest.approx(1, abs=0.1)
    piece = max(found.pieces, key=lambda piece: int(piece.cells.sum()))
    inside = cloth.mesh.pixels_of(piece.cells)
    assert inside.mean() > 0.7
    away = cloth.mesh.to_pixels(piece.uv)[inside] @ np.rint(steps).T - SCENE.uv[inside]
    rest = (away - np.median(away, axis=0)) @ SCENE.basis.T
    assert np.sqrt((rest**2).sum(-1).mean()) < 0.6


def test_a_photo_that_is_large_enough_is_not_enlarged() -> None:
    assert can_be_magnified((533, 400))
    assert not can_be_magnified((700, 400))


def test_enlarged_photo_shows_the_same_where_it_is_valid() -> None:
    inside = EVERYWHERE.copy()
    inside[:40] = False
    large, canvas = magnified(SCENE.photo, inside)
    assert large.shape == (TIMES * 110, TIMES * 120, 3)
    means = large.reshape(110, TIMES, 120, TIMES, 3).mean((1, 3))
    assert np.abs(means - SCENE.photo).mean() < 0.02
    np.testing.assert_array_equal(canvas.valid[..., 0] > 0, np.kron(inside, np.ones((TIMES, TIMES))) > 0)
