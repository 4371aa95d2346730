"""The canvas at its best, bent along: what is shown while something moves and there is no time to draw it anew."""

import moderngl

from app.render import gpu
from app.render.layers import CanvasLayers
from app.render.passes.draft import draft_stride
from app.render.passes.mesh import MeshBuffers
from app.render.passes.picture_pass import viewport_around
from app.render.programs import programs_of
from app.render.scene import CanvasScene
from app.render.sources.source import PICTURE_UNIT, Box
from core.arrays import Points

CELL_PX = 16.0
"""Cells are about so wide, where the grid's are smaller: as far on the screen as those of a draft."""


class BentCanvas:
    """A canvas of `size`, (w, h), that takes its pixels from another one."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.size = size
        self.shown = gpu.Offscreen(context, size, "f1")
        self.shown.texture.repeat_x = self.shown.texture.repeat_y = False
        self._drawn: tuple[CanvasScene, CanvasScene] | None = None
        self._context = context
        self._mesh: MeshBuffers | None = None
        self._programs = programs_of(context)
        self._side = gpu.power_of_two(max(size))

    def shows(self, scene: CanvasScene, before: CanvasScene) -> bool:
        """Return whether it shows `scene`, made from a canvas that shows `before`."""
        if self._drawn is None or self._drawn[1] is not before:
            return False
        return scene.shows_same_picture(self._drawn[0]) and scene.shows_same_marks(self._drawn[0])

    def draw(self, best: CanvasLayers, scene: CanvasScene, places: Points, box: Box, look: dict[str, object]) -> None:
        """Draw the pixels of `box` of `scene`, whose nodes lie at `places` (R, C, 2) in `best`, in framebuffer pixels.

        `look` are the uniforms of canvas.glsl.
        """
        assert best.drawn is not None
        self._drawn, here, canvas = (scene, best.drawn), scene.in_framebuffer(scene.warped), best.shown
        part = box[0], box[1], box[2] - box[0], box[3] - box[1]
        with self.shown.drawing(None, part):
            self._programs.fullscreen("backdrop.frag", **look)
        canvas.texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        canvas.texture.use(PICTURE_UNIT)
        uniforms = {"target_origin": (0.0, 0.0), "target_extent": float(self._side), "least_stretch": 1.0}
        with self.shown.drawing(viewport_around(self._side), part):
            mesh = self._placed(places, here)
            blocks = mesh.blocks_in(box)
            mesh.draw(
                "bent.frag", blocks, canvas=PICTURE_UNIT, pixel=(1 / canvas.size[0], 1 / canvas.size[1]), **uniforms
            )
        canvas.texture.filter = (moderngl.NEAREST, moderngl.NEAREST)

    def _placed(self, places: Points, here: Points) -> MeshBuffers:
        """Return the mesh of a grid, its nodes from `places` put `here`."""
        shape, stride = (here.shape[0], here.shape[1]), draft_stride(here, cell_px=CELL_PX)
        if self._mesh is None or (self._mesh.shape, self._mesh.stride) != (shape, stride):
            gpu.release(self._mesh)
            self._mesh = MeshBuffers(self._context, shape, stride=stride)
        self._mesh.place(places, here)
        return self._mesh

    def release(self) -> None:
        """Free the GPU objects."""
        gpu.release(self.shown, self._mesh)
