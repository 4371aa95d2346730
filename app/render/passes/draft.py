"""The canvas while something moves: small, a little less sharp, drawn in two passes.

The picture at its best takes a pass for every quantity, cut into pieces. A renderer in software waits between passes,
and reads back what it has just written.
"""

import time

import moderngl
import numpy as np

from app.render import gpu
from app.render.passes.mesh import MeshBuffers
from app.render.passes.picture_pass import DRAFT_STRETCH, picture_uniforms, viewport_around, what_is_read
from app.render.programs import Names, programs_of
from app.render.scene import CanvasScene
from app.render.sources.source import Box, Source
from core.arrays import Points

CELL_PX = 8.0
"""Cells of a draft are about so many of its pixels wide, where the grid's are smaller."""
LOADING_S = 0.004
"""What loading may take of the time for a draft, and a piece more."""
PLACE_UNIT, SHAPE_UNIT = 3, 4
"""Texture units, beside those of the nodes, of the picture and of the marks."""


class Draft:
    """A canvas of `size`, (w, h), that drafts are drawn on."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.size = size
        self.side = gpu.power_of_two(max(size))
        self.shown = gpu.Offscreen(context, size, "f1")
        self.shown.texture.repeat_x = self.shown.texture.repeat_y = False
        self.shown.texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self.drawn: CanvasScene | None = None
        """What `shown` shows."""
        self.bounds: Box = (0, 0, 0, 0)
        """The pixels outside which there is nothing but desk, or nothing is drawn."""
        self._part: Box | None = None
        self._place = gpu.Offscreen(context, size, "f4")
        self._shape = gpu.Offscreen(context, size, "f2")
        self._places = context.framebuffer([self._place.texture, self._shape.texture])
        self._programs = programs_of(context)

    def shows(self, scene: CanvasScene, part: Box | None) -> bool:
        """Return whether `shown` shows that `part` of `scene`, or all where it is None, marks included."""
        return part == self._part and scene.shows_same_picture(self.drawn) and scene.shows_same_marks(self.drawn)

    def begin(self, scene: CanvasScene, part: Box | None) -> None:
        """Clear the desk for `scene`, of which only `part` is to be drawn, and a pixel around it."""
        self.drawn, self._part, self.bounds = scene, part, scene.bounds(self.size)
        if part is not None:
            self.bounds = _common(self.bounds, (part[0] - 1, part[1] - 1, part[2] + 1, part[3] + 1))
        self.shown.clear(scene.palette.desk)

    def draw(self, mesh: MeshBuffers, source: Source, box: Box, look: dict[str, object], defined: Names) -> None:
        """Draw the pixels of `box`, with the uniforms of canvas.glsl and marks.glsl and what the latter has defined.

        What is not loaded is shown by few texels, and loaded for a while.
        """
        box = _common(box, self.bounds)
        if box[0] >= box[2] or box[1] >= box[3]:
            return
        touched = mesh.bounds_in(box)
        read, started = what_is_read(mesh, source, touched, DRAFT_STRETCH), time.perf_counter()
        for _ in source.loading(*read):
            if time.perf_counter() - started >= LOADING_S:
                break
        window = source.glimpse(*read)
        uniforms = {
            **picture_uniforms(window, source, self.side),
            "least_stretch": DRAFT_STRETCH,
        }
        self._shape.clear()
        with gpu.drawing(self._places, viewport_around(self.side), _rectangle(touched)):
            mesh.draw("draft_place.frag", mesh.blocks_in(touched), **uniforms)
        window.use()
        self._place.texture.use(PLACE_UNIT)
        self._shape.texture.use(SHAPE_UNIT)
        with self.shown.drawing(None, _rectangle(box)):
            self._programs.fullscreen(
                "draft.frag", ("DRAFT", *defined), place=PLACE_UNIT, shape=SHAPE_UNIT, **uniforms, **look
            )

    def release(self) -> None:
        """Free the GPU objects."""
        gpu.release(self._places, self.shown, self._place, self._shape)


def _rectangle(box: Box) -> gpu.Rectangle:
    return box[0], box[1], box[2] - box[0], box[3] - box[1]


def _common(a: Box, b: Box) -> Box:
    """Return the part that two boxes share."""
    left, top = max(a[0], b[0]), max(a[1], b[1])
    return left, top, max(min(a[2], b[2]), left), max(min(a[3], b[3]), top)


def draft_stride(nodes: Points, scale: float = 1.0, cell_px: float = CELL_PX) -> int:
    """Return which nodes of a row a draft draws, from their positions (R, C, 2): every so manieth.

    Its cells are about `cell_px` wide, where the grid's are smaller, in pixels of the draft: `scale` of them make one
    of the positions'.
    """
    cells = nodes.shape[1] - 1, nodes.shape[0] - 1
    span = scale * max(float(np.ptp(nodes[..., axis])) / cells[axis] for axis in (0, 1))
    return max(int(cell_px / max(span, 1e-3)), 1)
