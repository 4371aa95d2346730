"""A picture of a surface in space with the warped picture laid on it (FAT fig. 5)."""

import math
from dataclasses import dataclass

import moderngl
import numpy as np

from app.model.orbit import Orbit
from app.render import gpu
from app.render.passes.mesh import MeshBuffers
from app.render.passes.picture_pass import PicturePass, draw_at_once
from app.render.programs import programs_of, set_uniforms
from app.render.sources.source import Source
from app.render.sources.sources import Sources
from core.arrays import Bytes, Points
from core.document.document import Document
from core.imaging.image import Image
from core.mapping.result import Warped
from core.surfaces.surface import Surface

MOST_PX, DRAFT_PX = 1024, 384
"""The result is laid on a surface at a size of so many pixels a side at most, at its best and while it moves."""
FINER = 2
"""A surface is drawn at so many times its size each way, and averaged."""
CHART_NODES = 257
"""A chart is looked up in a raster of so many nodes a side."""
AMBIENT = 0.35
"""How bright a surface is that is seen from its side."""
VIEW_PX = 256, 2048
"""A view is from so many to so many pixels a side where nobody says."""
NO_DESK = 0.0, 0.0, 0.0, 0.0


@dataclass(frozen=True, eq=False)
class Laid:
    """What lies on a surface: a picture by its nodes."""

    surface: Surface
    rest: Points
    """Nodes (R, C, 2) in pixels of the picture."""
    moved: Points
    """Where they are on the canvas of the surface's chart."""
    canvas_px: tuple[int, int]

    def shows_same(self, other: "Laid") -> bool:
        """Return whether another one is of the same arrays."""
        return self.rest is other.rest and self.moved is other.moved and self.surface is other.surface


class SurfaceView:
    """Draws a surface with a picture on it in one GL context; what has not changed is kept."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.size = max(size[0], 1), max(size[1], 1)
        self._context = context
        self._shown = context.texture((FINER * self.size[0], FINER * self.size[1]), 4, dtype="f1")
        self._shown.filter = moderngl.LINEAR, moderngl.LINEAR
        self._depth = context.depth_renderbuffer(self._shown.size)
        self._target = context.framebuffer([self._shown], self._depth)
        self._surface: Surface | None = None
        self._array: moderngl.VertexArray | None = None
        self._corners: moderngl.Buffer | None = None
        self._chart: moderngl.Texture | None = None
        self._picture: PicturePass | None = None
        self._laid: tuple[Laid, Source, bool] | None = None
        """What the picture shows."""
        self._seen: tuple[object, ...] | None = None
        """What was drawn, and how."""

    def draw(
        self,
        laid: Laid,
        source: Source,
        orbit: Orbit,
        desk: tuple[float, float, float, float] = NO_DESK,
        *,
        draft: bool = False,
    ) -> moderngl.Texture:
        """Draw what is laid on its surface as a camera sees it, on a ground of the colour `desk`.

        A `draft` lays a smaller picture on it.
        """
        if laid.surface is not self._surface:
            self._take(laid.surface)
        if self._laid is None or not laid.shows_same(self._laid[0]) or self._laid[1:] != (source, draft):
            self._lay(laid, source, DRAFT_PX if draft else MOST_PX)
            self._laid = laid, source, draft
        if self._seen == (self._laid, orbit, desk):
            return self._shown
        self._seen = self._laid, orbit, desk
        assert self._array is not None
        assert self._chart is not None
        assert self._picture is not None
        self._chart.use(0)
        self._picture.light.texture.use(1)
        uniforms = {
            "to_clip": tuple(orbit.clip_matrix(laid.surface, self.size).T.ravel().tolist()),
            "to_camera": tuple(orbit.turned().T.ravel().tolist()),
            "chart": 0,
            "picture": 1,
            "ambient": AMBIENT,
        }
        set_uniforms(programs_of(self._context).get("surface.vert", "surface.frag"), **uniforms)
        with gpu.drawing(self._target, (0, 0, *self._shown.size)):
            self._target.clear(color=desk)
            self._context.enable(moderngl.DEPTH_TEST)
            programs_of(self._context).render(self._array, 3 * len(laid.surface.triangles))
            self._context.disable(moderngl.DEPTH_TEST)
        return self._shown

    def read(self) -> Bytes:
        """Return what was drawn last as pixels (h, w, 4), straight alpha, encoded for the screen."""
        width, height = self._shown.size
        pixels = np.frombuffer(self._target.read(components=4), np.uint8).reshape(height, width, 4)[::-1]
        fine = pixels.reshape(self.size[1], FINER, self.size[0], FINER, 4).astype(np.float32)
        cover = fine[..., 3:].sum(axis=(1, 3))
        colour = (fine[..., :3] * fine[..., 3:]).sum(axis=(1, 3)) / np.maximum(cover, 1)
        return np.asarray(np.rint(np.concatenate([colour, cover / FINER**2], axis=-1)), np.uint8)

    def _take(self, surface: Surface) -> None:
        """Send another surface to the GPU."""
        gpu.release(self._array, self._corners, self._chart)
        program = programs_of(self._context).get("surface.vert", "surface.frag")
        corners = np.concatenate(
            [surface.vertices[surface.triangles], surface.normals[surface.triangles], surface.corners], axis=-1
        )
        self._corners = self._context.buffer(corners.astype("f4").tobytes())
        self._array = self._context.vertex_array(program, [(self._corners, "3f 3f 2f", "place", "normal", "share")])
        even = np.linspace(0, 1, CHART_NODES)
        share = np.stack(np.meshgrid(even, even), axis=-1)
        places = surface.chart.at(share) / surface.chart.places.max(axis=(0, 1))
        chart = self._context.texture((CHART_NODES, CHART_NODES), 2, places.astype("f4").tobytes(), dtype="f4")
        chart.filter = moderngl.LINEAR, moderngl.LINEAR
        chart.repeat_x = chart.repeat_y = False
        self._surface, self._chart, self._laid = surface, chart, None

    def _lay(self, laid: Laid, source: Source, most_px: int) -> None:
        """Draw the result that is laid on the surface, by so many pixels a side at most."""
        scale = min(1.0, most_px / max(laid.canvas_px))
        size = max(1, round(laid.canvas_px[0] * scale)), max(1, round(laid.canvas_px[1] * scale))
        if self._picture is None or self._picture.size != size:
            gpu.release(self._picture)
            self._picture = PicturePass(self._context, size)
        mesh = MeshBuffers(self._context, laid.rest.shape[:2])
        mesh.place(laid.rest, (laid.moved + 0.5) * (np.array(size) / laid.canvas_px) - 0.5)
        self._picture.clear()
        draw_at_once(self._picture.drawing(mesh, source, (0, 0, *size), draft=most_px == DRAFT_PX))
        mesh.release()
        light = self._picture.light.texture
        light.build_mipmaps()
        light.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
        light.repeat_x = light.repeat_y = False

    def release(self) -> None:
        """Free the GPU objects."""
        gpu.release(self._array, self._corners, self._chart, self._picture, self._target, self._depth, self._shown)


class SurfaceViews:
    """Views of surfaces in one context, kept by their names; pictures come from `sources`."""

    def __init__(self, context: moderngl.Context, sources: Sources) -> None:
        self._context, self._sources = context, sources
        self._views: dict[str, SurfaceView] = {}

    def view(self, name: str, size: tuple[int, int]) -> SurfaceView:
        """Return the view of a name, made anew for another size, (w, h)."""
        found = self._views.get(name)
        if found is None or found.size != size:
            gpu.release(found)
            found = self._views[name] = SurfaceView(self._context, size)
        return found

    def source(self, image: Image) -> Source:
        """Return what a picture is drawn from."""
        return self._sources.of(image)

    def release(self) -> None:
        """Free the GPU objects."""
        gpu.release(*self._views.values())
        self._views.clear()


def draw_view(document: Document, found: Warped, orbit: Orbit, width_px: int | None = None) -> Image:
    """Return a square picture of a document's surface; without `width_px` about as large as the document's picture."""
    assert document.surface is not None
    side = width_px or min(max(round(math.sqrt(math.prod(document.size_px))), VIEW_PX[0]), VIEW_PX[1])
    context = gpu.standalone()
    view, source = SurfaceView(context, (side, side)), Source(context, document.image)
    try:
        view.draw(Laid(document.surface, found.rest, found.warped, document.canvas_px), source, orbit)
        return Image(view.read())
    finally:
        gpu.release(view, source)
