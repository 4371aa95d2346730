"""A document's picture for a file: the map at rest, drawn by the shaders of the preview, at a chosen depth and size."""

from typing import Any, Literal, TypeAlias

import numpy as np

from app.render.export import rendering
from app.requests import ExportOptions
from core import color, document_overlay, document_retexture
from core.canvas import Canvas, Framing
from core.document import Document
from core.document_map import settled
from core.grid import Grid
from core.images import Image, save
from core.progress import Job, Progress, part

Bits: TypeAlias = Literal[8, 16, 32]

DEPTHS: dict[Bits, tuple[Any, bool]] = {8: (np.uint8, False), 16: (np.uint16, False), 32: (np.float32, True)}
"""By bits: type of a sample, and whether it is linear light."""


def exporting(document: Document, options: ExportOptions) -> Job[None]:
    """Write the picture of `document` as `options` say; raise `InputError` where that cannot be done."""
    job = drawing(document, frame=options.frame, width_px=options.size_px[0], bits=options.bits)
    picture = yield from part(job, 0.0, 0.9)
    yield Progress(0.9, "writing")
    save(picture, options.path, quality=options.quality)


def drawing(
    document: Document,
    *,
    frame: Framing,
    width_px: int | None = None,
    scale: float = 1.0,
    bits: Bits | None = None,
) -> Job[Image]:
    """Return the picture of `document`, in its own frame or in one that holds all of the warp.

    `width_px` is the result's width; without it, the result has `scale` pixels for each of the canvas.
    """
    if document.mode == "retexture":
        made = document_retexture.picture(document, at_depth(document.image, bits))
        return (yield from resized(made, document, scale=scale, width_px=width_px))
    if document.mode == "overlay":
        made = document_overlay.picture(document, at_depth(document.image, bits))
        return (yield from resized(made, document, scale=scale, width_px=width_px))
    found = yield from part(settled(document), 0.0, 0.3)
    canvas = Canvas.of(frame, found.warped, document.canvas_px)
    if width_px is not None:
        scale = width_px / canvas.width_px
    final = Canvas(max(1, round(canvas.width_px * scale)), max(1, round(canvas.height_px * scale)))
    moved, image = canvas.placed(found.warped), at_depth(document.image, bits)
    return (yield from part(rendering(image, found.rest, moved, size=final.size, scale=scale), 0.3, 1.0))


def resized(made: Job[Image], document: Document, *, scale: float, width_px: int | None) -> Job[Image]:
    """Return a result of the size of the document's picture, resampled only where it is to have another size."""
    image = yield from part(made, 0.0, 0.9)
    scale = scale if width_px is None else width_px / image.width_px
    size = max(1, round(image.width_px * scale)), max(1, round(image.height_px * scale))
    if size == document.size_px:
        return image
    nodes = Grid(*document.size_px).nodes
    return (yield from part(rendering(image, nodes, nodes, size=size, scale=scale), 0.9, 1.0))


def at_depth(image: Image, bits: Bits | None) -> Image:
    """Return `image` with samples of so many bits, itself where it has them or `bits` is None."""
    if bits is None or image.pixels.dtype.itemsize * 8 == bits:
        return image
    depth, linear = DEPTHS[bits]
    light = color.linear_light(image.pixels, linear=image.linear)
    return Image(color.stored(light, depth=depth, linear=linear), linear, image.icc, image.metadata)
