"""Cloth on which no lattice grows and no keypoints are alike: even steps are laid on all of it."""

from collections.abc import Callable

import cv2
import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError, flat_canvas
from core.overlay.search import crumpled_cloth, finding
from core.overlay.search.crumpled_cloth import find_crumpled, find_likely_steps, lay_evenly
from core.overlay.search.finding import find_cloth
from core.overlay.texel import Texel
from core.progress import Job, Progress, run
from tests.core.overlay.overlay_scenes import Scene, make_scene
from tests.core.overlay.prints import canvas_of, displaced_px, painted, sett

BASIS = np.array([[44.0, 3.0], [-2.0, 40.0]])


@pytest.fixture(scope="module")
def crumpled() -> Scene:
    return make_scene(sett(), size=(260, 240), basis=BASIS, bend=5.0)


def none(*_: object, **__: object) -> Job[list[Lattice]]:
    yield Progress(0.0, "")
    raise NoPatternError


def told(steps: list[Floats]) -> Callable[..., Job[list[Floats]]]:
    """Return a search for likely steps that comes to these."""

    def find(*_: object) -> Job[list[Floats]]:
        yield Progress(0.0, "")
        return steps

    return find


def test_even_steps_are_pulled_to_where_the_cloth_lies(crumpled: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(finding, "find_lattices", none)
    monkeypatch.setattr(finding, "find_large", none)
    (found,) = run(find_cloth(crumpled.photo, painted(crumpled.photo), 0))
    piece = found.followed.pieces[0]
    assert piece.cells.mean() > 0.8
    assert np.percentile(displaced_px(crumpled, found.cloth, piece), 90) < 1.0
    with pytest.raises(NoPatternError):
        run(find_cloth(crumpled.photo, canvas_of(crumpled.photo), 0))


def test_texels_are_about_as_large_as_the_user_says(crumpled: Scene) -> None:
    canvas = painted(crumpled.photo)
    assert len(run(find_likely_steps(crumpled.photo, canvas, 40.0)))
    larger = run(find_likely_steps(crumpled.photo, canvas, 80.0))
    assert all(np.sqrt(np.linalg.det(basis)) > 53 for basis in larger)
    with pytest.raises(NoPatternError):
        run(find_crumpled(crumpled.photo, canvas, 0, texel_px=15.0))


@pytest.mark.parametrize("steps", [None, [BASIS]])
def test_nothing_is_found_in_noise_and_spots(monkeypatch: pytest.MonkeyPatch, steps: list[Floats] | None) -> None:
    if steps is not None:
        monkeypatch.setattr(crumpled_cloth, "find_likely_steps", told(steps))
    noise = np.random.default_rng(0).random((220, 240, 3))
    spots = cv2.GaussianBlur(noise, (0, 0), 4)
    for picture in (noise, 0.5 + 0.15 * (spots - spots.mean()) / spots.std()):
        with pytest.raises(NoPatternError):
            run(find_crumpled(picture, painted(picture), 0))


def test_nothing_is_found_in_thin_lines_that_are_painted(crumpled: Scene) -> None:
    painted_rows = np.zeros(crumpled.photo.shape[:2], bool)
    painted_rows[::7] = painted_rows[1::7] = True
    with pytest.raises(NoPatternError):
        run(find_cloth(crumpled.photo, flat_canvas(crumpled.photo, painted_rows), 0))
    with pytest.raises(NoPatternError):
        lay_evenly(crumpled.photo, flat_canvas(crumpled.photo, painted_rows), BASIS)


def test_stripes_are_no_cloth_that_repeats_both_ways(crumpled: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    stripes = Texel(np.tile(sett().pixels[:, :1], (1, 96, 1)))
    scene = make_scene(stripes, size=(260, 240), basis=BASIS, bend=5.0)
    monkeypatch.setattr(crumpled_cloth, "find_likely_steps", told([BASIS]))
    assert run(find_crumpled(crumpled.photo, painted(crumpled.photo), 0))[2].is_clear
    with pytest.raises(NoPatternError):
        run(find_crumpled(scene.photo, painted(scene.photo), 0))
