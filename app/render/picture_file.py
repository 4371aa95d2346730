"""A document's picture for a file: the map at rest, drawn by the shaders of the preview, at a chosen depth and size."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from app.model.orbit import Orbit
from app.model.requests import ExportOptions
from app.render.export import rendering, rendering_file, scaled
from app.render.surface_view import draw_view
from core.arrays import Points
from core.canvas import Canvas, Framing
from core.document import overlay, overlay_texture
from core.document import retexture as document_retexture
from core.document.document import Document
from core.document.map import frame_result
from core.document.map_solver import settle_map
from core.files.atomic import atomic_file
from core.grid import Grid
from core.imaging import color
from core.imaging.images import Image, write
from core.mapping.result import Warped
from core.notices import notice
from core.progress import Job, Progress, part

Bits: TypeAlias = Literal[8, 16, 32]

DEPTHS: dict[Bits, tuple[Any, bool]] = {8: (np.uint8, False), 16: (np.uint16, False), 32: (np.float32, True)}
"""By bits: type of a sample, and whether it is linear light."""


def exporting(document: Document, options: ExportOptions) -> Job[None]:
    """Write the picture of `document` as `options` say; raise `InputError` where that cannot be done."""
    width_px = options.size_px[0]
    if options.view is not None:
        return writing_view(document, options.path, options.view, width_px, settled=options.settled)
    return writing(
        document,
        options.path,
        frame=options.frame,
        width_px=width_px,
        bits=options.bits,
        quality=options.quality,
        settled=options.settled,
    )


@dataclass(frozen=True, eq=False)
class Drawing:
    """A picture and where its grid goes, ready to be drawn."""

    image: Image
    rest: Points
    """Nodes (R, C, 2) in pixels of the picture."""
    moved: Points
    """Where they go, in pixels of the result at `scale` 1."""
    size: tuple[int, int]
    """Width and height of the result."""
    scale: float = 1.0

    @classmethod
    def unmoved(cls, image: Image, *, width_px: int | None = None, scale: float = 1.0) -> "Drawing":
        """Return the drawing of a picture that is finished but for its size."""
        nodes = Grid(*image.size_px).nodes
        scale = scale if width_px is None else width_px / image.width_px
        return cls(image, nodes, nodes, scale_size(image.size_px, scale), scale)

    @property
    def is_finished(self) -> bool:
        """Whether the picture is the result."""
        return self.rest is self.moved and self.size == self.image.size_px


def writing(
    document: Document,
    path: Path,
    *,
    frame: Framing,
    width_px: int | None = None,
    scale: float = 1.0,
    bits: Bits | None = None,
    quality: int = 95,
    settled: Warped | None = None,
) -> Job[None]:
    """Write the picture of `document`, in its own frame or in one that holds all of the warp.

    `width_px` is the result's width; without it, the result has `scale` pixels for each of the canvas. `settled` is the
    document's map at rest, if that is known.
    """
    if document.mode == "warp":
        found = settled or (yield from part(settle_map(document), 0.0, 0.3))
        drawing, drawn = (
            draw_warped(document, found, path.name, frame=frame, width_px=width_px, scale=scale, bits=bits),
            0.3,
        )
    elif document.mode == "overlay" and (factor := _factor(document, scale, width_px)) > 1:
        image = yield from part(_enlarged_overlay(document, factor, bits), 0.0, 0.9)
        drawing, drawn = Drawing.unmoved(image), 0.9
    else:
        made = document_retexture if document.mode == "retexture" else overlay_texture
        image = yield from part(made.picture(document, at_depth(document.image, bits)), 0.0, 0.9)
        drawing, drawn = Drawing.unmoved(image, width_px=width_px, scale=scale), 0.9
    with atomic_file(path) as place:
        yield from part(drawing_file(drawing, place, named=path, quality=quality), drawn, 1.0)


def writing_view(
    document: Document, path: Path, orbit: Orbit, width_px: int, *, settled: Warped | None = None
) -> Job[None]:
    """Write a picture, so wide and high, of the document's surface with the result on it; `settled` as in `writing`."""
    found = settled or (yield from part(settle_map(document), 0.0, 0.8))
    yield Progress(0.8, "drawing")
    with atomic_file(path) as place:
        write(draw_view(document, found, orbit, width_px), place, named=path)


def draw_warped(
    document: Document,
    found: Warped,
    name: str,
    *,
    frame: Framing,
    width_px: int | None = None,
    scale: float = 1.0,
    bits: Bits | None = None,
) -> Drawing:
    """Return the drawing of a document by its map; what the map could not keep is a notice about the file `name`.

    Of a picture on a surface in space that is the surface's texture.
    """
    for complaint in found.complaints():
        notice(f"{name}: {complaint}")
    canvas, moved = frame_result(document, found, frame)
    scale = scale if width_px is None else width_px / canvas.width_px
    image, size = at_depth(document.image, bits), scale_size(canvas.size, scale)
    return Drawing(image, found.rest, moved, size, scale)


def drawing_file(drawing: Drawing, place: Path, *, named: Path, quality: int = 95) -> Job[None]:
    """Write a drawing to `place`; faults name the file `named`, which it is to become."""
    if drawing.is_finished:
        yield Progress(0.0, "writing")
        write(drawing.image, place, named=named, quality=quality)
        return
    yield from rendering_file(
        drawing.image,
        drawing.rest,
        scaled(drawing.moved, drawing.scale),
        place,
        named=named,
        size=drawing.size,
        quality=quality,
    )


def _factor(document: Document, scale: float, width_px: int | None) -> float:
    """Return pixels of the result for each of the document's picture."""
    return scale if width_px is None else width_px / document.size_px[0]


def _enlarged_overlay(document: Document, factor: float, bits: Bits | None) -> Job[Image]:
    """Return the picture at a larger size: the photo is filtered, and the texture sampled at that size."""
    nodes = Grid(*document.size_px).nodes
    photo, size = at_depth(document.image, bits), scale_size(document.size_px, factor)
    if overlay_texture.is_changed(document.cloth):
        layers = yield from part(overlay.find_layers(document), 0.0, 0.6)
        photo = yield from part(rendering(photo, nodes, nodes, size=size, scale=factor), 0.6, 0.8)
        yield Progress(0.8, "laying the texture")
        photo = overlay_texture.lay_on(photo, layers, document.cloth)
    else:
        photo = yield from part(rendering(photo, nodes, nodes, size=size, scale=factor), 0.0, 0.9)
    return photo


def scale_size(size_px: tuple[int, int], scale: float) -> tuple[int, int]:
    """Return a size multiplied by `scale`; raise `InputError` if no picture can have it."""
    width, height = (max(1, round(side * scale)) for side in size_px)
    return Canvas(width, height).size


def at_depth(image: Image, bits: Bits | None) -> Image:
    """Return `image` with samples of so many bits, itself where it has them or `bits` is None."""
    if bits is None or image.pixels.dtype.itemsize * 8 == bits:
        return image
    depth, linear = DEPTHS[bits]
    light = color.linear_light(image.pixels, linear=image.linear)
    return Image(color.store(light, depth=depth, linear=linear), linear, image.icc, image.metadata)
