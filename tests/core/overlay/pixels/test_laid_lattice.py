"""The lattice of the cloth as it is laid."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from core.arrays import Bools, Floats
from core.overlay.decomposition import Decomposition, decompose
from core.overlay.pixels.laid_lattice import find_vertices, measure_basis
from core.progress import run
from tests.core.overlay.overlay_scenes import make_scene, motif

SCENE = make_scene(motif())
STEP = np.array([[20.0, 4.0], [-3.0, 18.0]])
SIZE = 120, 150


def slanted() -> Floats:
    """Return coordinates (H, W, 2) of texels with the vectors `STEP`."""
    y, x = np.indices(SIZE)
    return np.stack([x - 0.3, y - 0.3], -1) @ np.linalg.inv(STEP).T


@pytest.fixture(scope="module")
def found() -> Decomposition:
    """Return a decomposition of a painted scene with a gap that nothing could be followed in."""
    photo = SCENE.photo.copy()
    photo[60:95, 60:110] = photo[60:95, 60:110][::-1, ::-1]
    return run(decompose(photo, region=np.ones(photo.shape[:2], bool)))


def test_every_whole_coordinate_has_a_vertex_where_it_lies() -> None:
    keys, points = find_vertices(slanted(), np.ones(SIZE, bool))
    np.testing.assert_allclose(points, keys @ STEP.T + 0.3, atol=1e-9)
    assert len(np.unique(keys, axis=0)) == len(keys)
    every = np.stack(np.meshgrid(*(np.arange(-20, 20),) * 2), -1).reshape(-1, 2) @ STEP.T + 0.3
    inside = (every > 0) & (every < np.array(SIZE[::-1]) - 1)
    assert len(keys) == inside.all(1).sum() > 30


def test_there_is_no_vertex_where_cloth_is_torn() -> None:
    whole: Bools = np.ones(SIZE, bool)
    whole[:, 70:80] = False
    _, points = find_vertices(slanted(), whole)
    assert len(points) > 20
    assert ((points[:, 0] <= 69) | (points[:, 0] >= 80)).all()


def test_what_was_filled_between_followed_cloth_has_vertices_too(found: Decomposition) -> None:
    inside = ((found.lattice.frames.points > (60, 60)) & (found.lattice.frames.points < (110, 95))).all(1)
    assert found.covered[60:95, 60:110].all()
    assert inside.sum() >= 2
    area = found.covered.sum() / abs(np.linalg.det(found.basis))
    assert len(found.lattice) > 0.8 * area


def test_vertices_lie_where_the_coordinates_say_with_the_vectors_there(found: Decomposition) -> None:
    points, bases = found.lattice.frames.points, found.lattice.frames.bases
    x, y = np.rint(points).astype(int).T
    # A sheet that would meet another one has its keys moved by whole texels.
    off = found.uv[y, x] - np.rint(found.uv[y, x])
    assert np.linalg.norm(off @ found.basis.T, axis=1).max() < 1.0
    assert (np.rint(found.uv[y, x]) == found.lattice.keys).all(1).mean() > 0.9
    is_followed = ((points < (50, 50)) | (points > (120, 105))).any(1)
    area = np.linalg.det(bases[is_followed]) / np.linalg.det(found.basis)
    assert is_followed.sum() > 15
    assert ((area > 0.7) & (area < 1.4)).all()


@pytest.mark.parametrize(("is_turned_over", "scale"), [(False, 1), (False, 2), (True, 1)])
def test_the_usual_texel_is_measured_where_the_cloth_is_not_turned_over(*, is_turned_over: bool, scale: int) -> None:
    uv = np.repeat(np.repeat(slanted(), scale, 0), scale, 1)
    model: Any = SimpleNamespace(
        uv=uv[:, ::-1] if is_turned_over else uv,
        scale=scale,
        basis=1.5 * STEP * scale,
        cloth=SimpleNamespace(basis=1.5 * STEP),
    )
    measured = measure_basis(model)
    np.testing.assert_allclose(measured, (1.5 if is_turned_over else 1) * STEP * scale, rtol=1e-6)


def test_parts_that_lie_otherwise_do_not_change_the_usual_texel() -> None:
    y, x = np.indices(SIZE)
    uv = slanted()
    for sleeve, degrees in ((x < 45, 50.0), (x >= 105, -50.0)):
        cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        turned = np.array([[cos, -sin], [sin, cos]]) @ STEP
        uv[sleeve] = np.stack([x, y], -1)[sleeve] @ np.linalg.inv(turned).T
    model: Any = SimpleNamespace(uv=uv, scale=1, basis=1.5 * STEP, cloth=SimpleNamespace(basis=1.5 * STEP))
    np.testing.assert_allclose(measure_basis(model), STEP, rtol=1e-6)


def test_a_quad_that_shows_another_thing_is_less_explained_than_any_other(found: Decomposition) -> None:
    frames = found.lattice.frames
    middles = frames.points + frames.bases.sum(-1) / 2
    is_other = ((middles > (60, 60)) & (middles < (110, 95))).all(1)
    assert is_other.any()
    assert frames.scores[is_other].max() < 0.65 < 0.75 < frames.scores[~is_other].min()
