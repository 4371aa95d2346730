"""The meshes of the parts of a canvas, on the GPU, placed anew only where a scene has them elsewhere."""

from typing import TypeAlias

import moderngl

from app.model.spaces import View
from app.render.gpu import release
from app.render.passes.draft import draft_stride
from app.render.passes.mesh import MeshBuffers
from app.render.scene import CanvasScene
from core.arrays import Points

_Placing: TypeAlias = tuple[Points, Points, View, float]
"""Nodes on the picture and on the canvas, how that is looked at, and drawn pixels per screen pixel."""


class PlacedMeshes:
    """Meshes by the name of their part, those of drafts apart."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._meshes: dict[tuple[str, bool], MeshBuffers] = {}
        self._placings: dict[tuple[str, bool], _Placing] = {}
        """What each of them was placed for last."""

    def place(self, name: str, scene: CanvasScene, nodes: Points) -> MeshBuffers:
        """Return the mesh of the part called `name` with its `nodes` in place."""
        rest = scene.before_rest if name == "before" and scene.before_rest is not None else scene.rest
        key, seen = (name, scene.draft), (rest, nodes, scene.view, scene.pixel_ratio / scene.shrink)
        if not _says_same(seen, self._placings.get(key)):
            positions = scene.in_framebuffer(nodes)
            self._mesh_of(key, positions).place(rest, positions)
            self._placings[key] = seen
        return self._meshes[key]

    def release(self) -> None:
        """Free the GPU objects; placing makes them anew."""
        release(*self._meshes.values())
        self._meshes, self._placings = {}, {}

    def _mesh_of(self, key: tuple[str, bool], positions: Points) -> MeshBuffers:
        """Return the mesh of a part, made anew for another grid shape; `place` knows where its nodes are."""
        shape = positions.shape[0], positions.shape[1]
        stride = draft_stride(positions) if key[1] else 1
        held = self._meshes.get(key)
        if held is None or (held.shape, held.stride) != (shape, stride):
            release(held)
            held = self._meshes[key] = MeshBuffers(self._context, shape, stride=stride)
        return held


def _says_same(one: _Placing, other: _Placing | None) -> bool:
    """Return whether two placings are of the same arrays in the same view."""
    return other is not None and one[0] is other[0] and one[1] is other[1] and one[2:] == other[2:]
