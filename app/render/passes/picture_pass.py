"""Draws a warped picture in linear light: places, filter, outline.

First the mesh is drawn with nothing but the source place and the footprint of every pixel (place.frag); then one pass
over the pixels filters the picture (resample.frag); then the pixels that the outline cuts are laid over, since they let
what is behind them through (edge.frag).
"""

from collections.abc import Iterator
from contextlib import contextmanager

import moderngl
import numpy as np

from app.render import gpu
from app.render.passes.mesh import MeshBuffers
from app.render.programs import programs_of
from app.render.source_footprint import Read
from app.render.sources.source import ENCODED_UNIT, PICTURE_UNIT, Box, Source, Window
from core.arrays import Bools

PLACE_UNIT, FOOTPRINT_UNIT = 3, 4
"""Texture units; the nodes of the grid have 0 and 1."""
LEAST_STRETCH = 1.5
"""How many texels of its level a shrinking kernel spans at least: more is slower, less lets the pyramid show."""
DRAFT_STRETCH = 0.75
Area = tuple[Box, int, int | None]
"""A box of the picture, the finest level of its pyramid that is read, and the coarsest, None if that is not known."""
NOTHING_READ: Area = (0, 0, 1, 1), 0, None
PIECE_BLOCKS = 24
STRIP_PIXELS = 1 << 14
"""Where the picture is shrunk, the filter may take a microsecond a pixel."""


def draw_at_once(pieces: Iterator[None]) -> None:
    """Draw all pieces of what is drawn with stops."""
    for _ in pieces:
        pass


class PicturePass:
    """A target of `size`, (w, h), and the passes that draw into it.

    `light` holds the picture, linear and premultiplied; `cells`, if asked for, grid coordinates for the marks.
    """

    def __init__(
        self, context: moderngl.Context, size: tuple[int, int], *, exact: bool = False, with_cells: bool = False
    ) -> None:
        self.size = size
        self.side = gpu.power_of_two(max(size))
        self._context = context
        self._programs = programs_of(context)
        self.light = gpu.Offscreen(context, size, "f4" if exact else "f2")
        self.cells = gpu.Offscreen(context, size, "f4") if with_cells else None
        self._place = gpu.Offscreen(context, size, "f4")
        self._footprint = gpu.Offscreen(context, size, "f4")
        layers = [self._place.texture, self._footprint.texture]
        self._places = context.framebuffer([*layers, self.cells.texture] if self.cells else layers)

    def clear(self) -> None:
        """Empty the target."""
        self._footprint.clear()
        self.light.clear()
        if self.cells is not None:
            self.cells.clear()

    def drawing(
        self,
        mesh: MeshBuffers,
        source: Source,
        box: Box,
        *,
        origin: tuple[int, int] = (0, 0),
        draft: bool = False,
        read: Read | None = None,
        in_pieces: bool = False,
    ) -> Iterator[None]:
        """Draw the output pixels of `box`, which nothing was drawn in since `clear`, with a stop after each piece.

        `origin` is the output pixel that is the target's first. A `draft` is less sharp. `read` is what the mesh
        says that this reads, where that is known. `in_pieces`, each takes a few milliseconds at most; else there are
        as few as can be, for `draw_at_once`.
        """
        box = mesh.bounds_in(box)
        blocks = mesh.blocks_in(box)
        if not blocks.any():
            return
        least_stretch = DRAFT_STRETCH if draft else LEAST_STRETCH
        area = what_is_read(mesh, source, box, least_stretch) if read is None else read[:3]
        filters = () if read is None else read.filters
        yield
        window = source.window(*area)
        uniforms = {
            **picture_uniforms(window, source, self.side, origin),
            "least_stretch": least_stretch,
        }
        defined = window.names(*area[1:]) + (("DRAFT",) if draft else ())
        viewport = viewport_around(self.side)
        for piece in _pieces(blocks) if in_pieces else (blocks,):
            with gpu.drawing(self._places, viewport, _shifted(box, origin)):
                mesh.draw("place.frag", piece, **uniforms)
            yield
        for strip in strips(box, STRIP_PIXELS) if in_pieces else (box,):
            with self.light.drawing(None, _shifted(strip, origin)):
                source.window(*area).use()
                self._place.texture.use(PLACE_UNIT)
                self._footprint.texture.use(FOOTPRINT_UNIT)
                self._programs.fullscreen(
                    "resample.frag", defined + filters, place=PLACE_UNIT, footprint=FOOTPRINT_UNIT, **uniforms
                )
            yield
        source.window(*area).use()
        with self.light.drawing(viewport, _shifted(box, origin)), self._blending():
            mesh.draw_edge("edge.frag", defined, **uniforms)
        if self.cells is not None:
            with self.cells.drawing(viewport, _shifted(box, origin)):
                mesh.draw_edge("edge_cells.frag", **uniforms)

    @contextmanager
    def _blending(self) -> Iterator[None]:
        self._context.enable(moderngl.BLEND)
        self._context.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        yield
        self._context.disable(moderngl.BLEND)

    def release(self) -> None:
        """Free the GPU objects."""
        gpu.release(self._places, self.light, self.cells, self._place, self._footprint)


def what_is_read(mesh: MeshBuffers, source: Source, box: Box, least_stretch: float) -> Area:
    """Return what drawing the output pixels of `box` reads of the picture."""
    if source.is_small:
        return source.whole, 0, None
    read = mesh.source_of(box, least_stretch=least_stretch)
    return NOTHING_READ if read is None else (read.box, read.level, None)


def picture_uniforms(window: Window, source: Source, side: int, origin: tuple[int, int] = (0, 0)) -> dict[str, object]:
    """Return the uniforms of mesh.vert and filter.glsl for a square target of `side`, a power of two."""
    return {
        "picture": PICTURE_UNIT,
        "picture_bytes": ENCODED_UNIT,
        "picture_size": (source.image.width_px, source.image.height_px),
        "window": (*window.box[:2], *window.base_size),
        "coarser_left": window.coarser_left,
        "base_level": window.base,
        "top_level": window.top,
        "target_origin": (float(origin[0]), float(origin[1])),
        "target_extent": float(side),
    }


def viewport_around(side: int) -> gpu.Rectangle:
    """Return the viewport that mesh.vert expects for a square target of `side`."""
    return -side // 2, -side // 2, 2 * side, 2 * side


def _shifted(box: Box, origin: tuple[int, int]) -> gpu.Rectangle:
    """Return the rectangle of a target that `box` is, the target's first pixel being `origin`."""
    return box[0] - origin[0], box[1] - origin[1], box[2] - box[0], box[3] - box[1]


def _pieces(blocks: Bools) -> Iterator[Bools]:
    """Cut the blocks that are to be drawn into pieces, in the order of drawing."""
    number = np.cumsum(blocks).reshape(blocks.shape)
    for first in range(0, int(blocks.sum()), PIECE_BLOCKS):
        yield blocks & (number > first) & (number <= first + PIECE_BLOCKS)


def strips(box: Box, pixels: int) -> Iterator[Box]:
    """Cut `box` into strips of full rows, of so many pixels at most where a row has no more."""
    left, top, right, bottom = box
    rows = max(pixels // max(right - left, 1), 1)
    for y in range(top, bottom, rows):
        yield left, y, right, min(y + rows, bottom)
