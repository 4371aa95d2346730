"""Small pictures of one picture under many warps."""

from collections.abc import Sequence

import moderngl
import numpy as np

from app.render import gpu
from app.render.passes.mesh import MeshBuffers
from app.render.passes.picture_pass import PicturePass, draw_at_once
from app.render.programs import programs_of
from app.render.sources.source import Source
from core.arrays import Bytes, Points


def draw_thumbnails(
    context: moderngl.Context, source: Source, rest: Points, warps: Sequence[Points], size: tuple[int, int]
) -> list[Bytes]:
    """Return the picture under each of `warps`, (R, C, 2) like `rest`, fitted into `size`, (w, h).

    Each is (h, w, 4), straight alpha, encoded for the screen.
    """
    target, pixels = PicturePass(context, size), gpu.Offscreen(context, size, "f1")
    mesh = MeshBuffers(context, (rest.shape[0], rest.shape[1]))
    pictures = []
    for warped in warps:
        mesh.place(rest, _fit_curve(warped, size))
        target.clear()
        draw_at_once(target.drawing(mesh, source, (0, 0, *size), draft=True))
        with pixels.drawing():
            target.light.texture.use(0)
            programs_of(context).fullscreen("encode.frag", tile=0, linear=False)
        pictures.append(np.frombuffer(pixels.read(size), np.uint8).reshape(size[1], size[0], 4))
    gpu.release(mesh, target, pixels)
    return pictures


def _fit_curve(warped: Points, size: tuple[int, int]) -> Points:
    """Return positions scaled and moved so that they fill `size` in one direction and are centred."""
    low, high = warped.min(axis=(0, 1)), warped.max(axis=(0, 1))
    zoom = (np.asarray(size) / np.maximum(high - low, 1e-6)).min()
    fitted: Points = (warped - (low + high) / 2) * zoom + (np.asarray(size) - 1) / 2
    return fitted
