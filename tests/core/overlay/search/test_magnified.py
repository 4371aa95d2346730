"""Small texels are looked for in the enlarged photo, and what is found there is the photo's own cloth."""

import numpy as np
import pytest

from core.overlay.detection.alignment import FlatPicture
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError, find_lattices, flat_canvas
from core.overlay.filters.magnifying import TIMES, can_be_magnified
from core.overlay.search import finding
from core.overlay.search.finding import find_cloth
from core.overlay.search.magnified import MOST_PX, magnified
from core.progress import Job, Progress, run
from tests.core.overlay.overlay_scenes import make_scene, motif

SCENE = make_scene(motif(), size=(110, 120), basis=np.array([[9.0, 1.2], [-0.8, 8.5]]), bend=1.5)
EVERYWHERE = np.ones(SCENE.photo.shape[:2], bool)


def test_what_is_found_enlarged_lies_on_the_photos_pixels(monkeypatch: pytest.MonkeyPatch) -> None:
    def find_enlarged(
        canvas: FlatPicture, rng: np.random.Generator, *, texel_px: float | None, most_px: float = np.inf
    ) -> Job[list[Lattice]]:
        if most_px == np.inf:
            yield Progress(0.0, "")
            raise NoPatternError
        return (yield from find_lattices(canvas, rng, texel_px=texel_px, most_px=most_px))

    monkeypatch.setattr(finding, "find_lattices", find_enlarged)
    (best,) = run(find_cloth(SCENE.photo, flat_canvas(SCENE.photo, EVERYWHERE), 0))
    cloth, found = best.cloth, best.followed
    assert list(cloth.mesh.shape) == list(EVERYWHERE.shape)
    steps = np.linalg.solve(SCENE.basis, cloth.basis)
    np.testing.assert_allclose(steps, np.rint(steps), atol=0.1)
    assert abs(np.linalg.det(steps)) == pytest.approx(1, abs=0.1)
    piece = max(found.pieces, key=lambda piece: int(piece.cells.sum()))
    inside = cloth.mesh.pixels_of(piece.cells)
    assert inside.mean() > 0.7
    away = cloth.mesh.to_pixels(piece.uv, piece.cells)[inside] @ np.rint(steps).T - SCENE.uv[inside]
    rest = (away - np.median(away, axis=0)) @ SCENE.basis.T
    assert np.sqrt((rest**2).sum(-1).mean()) < 0.6


def test_only_what_is_smaller_than_the_least_exemplar_is_looked_for_enlarged() -> None:
    _, canvas = magnified(SCENE.photo, EVERYWHERE)
    found = run(find_lattices(canvas, np.random.default_rng(0), most_px=MOST_PX))
    assert found[0].texel_area == pytest.approx(TIMES**2 * np.linalg.det(SCENE.basis), rel=0.1)
    large = make_scene(motif(), size=(110, 120), basis=27.0 * np.eye(2), bend=0.0)
    _, canvas = magnified(large.photo, EVERYWHERE)
    with pytest.raises(NoPatternError):
        run(find_lattices(canvas, np.random.default_rng(0), most_px=MOST_PX))


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
