"""The meshes of the parts of a canvas, on the GPU."""

import moderngl

from app.render.gpu import release
from app.render.passes.draft import draft_stride
from app.render.passes.mesh import MeshBuffers
from app.render.scene import CanvasScene
from core.arrays import Points


class PlacedMeshes:
    """Meshes by the name of their part, those of drafts apart."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._meshes: dict[tuple[str, bool], MeshBuffers] = {}

    def place(self, name: str, scene: CanvasScene, nodes: Points) -> MeshBuffers:
        """Return the mesh of the part called `name` with its `nodes` (R, C, 2), on the canvas, in place."""
        rest = scene.before_rest if name == "before" and scene.before_rest is not None else scene.rest
        mesh = self._mesh_of((name, scene.draft), nodes, scene.scaling.scale)
        mesh.place(rest, nodes, scene.scaling)
        return mesh

    def release(self) -> None:
        """Free the GPU objects; placing makes them anew."""
        release(*self._meshes.values())
        self._meshes = {}

    def _mesh_of(self, key: tuple[str, bool], nodes: Points, scale: float) -> MeshBuffers:
        """Return the mesh of a part, made anew for another grid shape; `place` knows where its nodes are."""
        shape = nodes.shape[0], nodes.shape[1]
        stride = draft_stride(nodes, scale) if key[1] else 1
        held = self._meshes.get(key)
        if held is None or (held.shape, held.stride) != (shape, stride):
            release(held)
            held = self._meshes[key] = MeshBuffers(self._context, shape, stride=stride)
        return held
