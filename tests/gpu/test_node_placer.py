"""Nodes that the GPU scales lie where the processor has them, and the picture drawn from them is the same."""

from collections.abc import Iterator

import moderngl
import numpy as np
import pytest

from app.render import gpu
from app.render.nodes import NodePlacer, Scaling
from app.render.passes.mesh import MeshBuffers
from app.render.passes.picture_pass import PicturePass, draw_at_once
from app.render.sources.source import Source
from core.arrays import Points, Singles
from tests.gpu.scenes import grid, picture, wavy

SHAPE = (26, 37)
SCALINGS = (Scaling(), Scaling(0.7, (3.25, -8.5)), Scaling(41.3, (-12345.6, -23456.7)))
BOXES = ((0, 0, 40, 30), (35, 20, 90, 64), (-500, -500, -400, 900), (0, 0, 3000, 2000))


@pytest.fixture
def context() -> moderngl.Context:
    found = gpu.standalone()
    if found.version_code < gpu.COMPUTE:
        pytest.skip("needs OpenGL 4.3")
    return found


@pytest.fixture(params=[1, 3])
def meshes(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, context: moderngl.Context
) -> Iterator[tuple[MeshBuffers, MeshBuffers]]:
    """Two of the same nodes, placed by the GPU and by the processor."""
    made = []
    for find in (NodePlacer, lambda *_: None):
        monkeypatch.setattr("app.render.passes.mesh.find_placer", find)
        made.append(MeshBuffers(context, SHAPE, stride=request.param))
    yield made[0], made[1]
    gpu.release(*made)


def nodes() -> tuple[Points, Points]:
    rest = grid(400, 300, cells=SHAPE[1] - 1)[: SHAPE[0]]
    return rest, wavy(rest, amount=5.0)


def sent(mesh: MeshBuffers) -> Singles:
    texture = mesh._nodes["moved_nodes"].texture
    return np.frombuffer(texture.read(), np.float32).reshape(texture.height, texture.width, 4)


@pytest.mark.parametrize("scaling", SCALINGS)
def test_both_place_the_nodes_alike(meshes: tuple[MeshBuffers, MeshBuffers], scaling: Scaling) -> None:
    rest, moved = nodes()
    for rests_at in (moved, moved + [2.75, -1.5]):  # the second time only the positions are others
        for mesh in meshes:
            mesh.place(rest, rests_at, scaling)
        ours, theirs = (sent(mesh).astype(float) for mesh in meshes)
        assert np.abs((ours[..., :2] + ours[..., 2:]) - (theirs[..., :2] + theirs[..., 2:])).max() < 1e-6
        assert (ours[..., 2:] == np.floor(ours[..., 2:])).all()
        assert (ours[..., :2] >= 0).all()


@pytest.mark.parametrize("scaling", SCALINGS)
def test_both_draw_the_same_blocks(meshes: tuple[MeshBuffers, MeshBuffers], scaling: Scaling) -> None:
    for mesh in meshes:
        mesh.place(*nodes(), scaling)
    ours, theirs = meshes
    for box in BOXES:
        assert np.array_equal(ours.blocks_in(box), theirs.blocks_in(box))
        assert ours.bounds_in(box) == theirs.bounds_in(box)


def test_another_view_alone_moves_the_nodes(meshes: tuple[MeshBuffers, MeshBuffers]) -> None:
    rest, moved = nodes()
    for scaling in SCALINGS:
        for mesh in meshes:
            mesh.place(rest, moved, scaling)
    ours, theirs = (sent(mesh).astype(float) for mesh in meshes)
    assert np.abs((ours - theirs)[..., :2] + (ours - theirs)[..., 2:]).max() < 1e-6


def test_the_picture_is_the_same(context: moderngl.Context, meshes: tuple[MeshBuffers, MeshBuffers]) -> None:
    source, size, drawn = Source(context, picture(400, 300)), (200, 150), []
    for mesh in meshes:
        mesh.place(*nodes(), Scaling(0.5, (-0.25, -0.25)))
        target = PicturePass(context, size)
        target.clear()
        draw_at_once(target.drawing(mesh, source, (0, 0, *size)))
        drawn.append(np.frombuffer(target.light.read(size), np.float16).astype(float))
        gpu.release(target)
    gpu.release(source)
    assert drawn[0].max() > 0.5
    assert np.abs(drawn[0] - drawn[1]).max() < 2e-3


def test_what_is_read_is_known_without_the_gpu(meshes: tuple[MeshBuffers, MeshBuffers]) -> None:
    reads = []
    for mesh in meshes:
        mesh.place(*nodes(), SCALINGS[1])
        reads.append(mesh.source_of((0, 0, 90, 64), least_stretch=1.0))
    assert reads[0] is not None
    assert reads[0] == reads[1]
