"""A picture of a surface in space with the warped picture laid on it (FAT fig. 5)."""

import functools
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import moderngl
import numpy as np

from app.model.orbit import Orbit
from app.render import gpu
from app.render.passes.draft import draft_stride
from app.render.passes.mesh import MeshBuffers
from app.render.passes.picture_pass import LEAST_STRETCH, PicturePass, draw_at_once, what_is_read
from app.render.programs import programs_of, set_uniforms
from app.render.sources.source import Source
from app.render.sources.sources import Sources
from core.arrays import Bytes, Floats, Points
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
BARE = 0.6
"""How light a surface is, in linear light, where the picture on it is clear."""
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


class LaidPicture:
    """What is laid on a surface, drawn by `most_px` pixels a side at most.

    A draft has larger cells, where the grid's are smaller, and no pyramid of averages.
    """

    def __init__(self, context: moderngl.Context, most_px: int, *, draft: bool) -> None:
        self._context, self._most_px, self._draft = context, most_px, draft
        self._pass: PicturePass | None = None
        self.shown: tuple[Laid, Source] | None = None
        """What was drawn whole."""
        self._goal: tuple[Laid, Source] | None = None
        """What is being drawn."""
        self._steps: Iterator[None] = iter(())

    @property
    def light(self) -> moderngl.Texture:
        """What was drawn."""
        assert self._pass is not None
        return self._pass.light.texture

    def shows(self, laid: Laid, source: Source) -> bool:
        """Return whether the picture of this is there."""
        return _are_same(self.shown, laid, source)

    def draw(self, laid: Laid, source: Source, frame_s: float = math.inf) -> None:
        """Draw for so long, going on with what was begun; `shows` says whether all is there then."""
        if not _are_same(self._goal, laid, source):
            self.shown, self._goal, self._steps = None, (laid, source), self._drawing(laid, source)
        if math.isinf(frame_s):
            draw_at_once(self._steps)
        else:
            started = time.perf_counter()
            for _ in self._steps:
                self._context.finish()
                if time.perf_counter() - started > frame_s:
                    return
        self.shown = self._goal

    def _drawing(self, laid: Laid, source: Source) -> Iterator[None]:
        """Draw the picture with a stop after each piece, and then the pyramid."""
        scale = min(1.0, self._most_px / max(laid.canvas_px))
        size = max(1, round(laid.canvas_px[0] * scale)), max(1, round(laid.canvas_px[1] * scale))
        if self._pass is None or self._pass.size != size:
            gpu.release(self._pass)
            self._pass = PicturePass(self._context, size)
        moved = (laid.moved + 0.5) * (np.array(size) / laid.canvas_px) - 0.5
        stride = draft_stride(moved) if self._draft else 1
        mesh, box = MeshBuffers(self._context, laid.rest.shape[:2], stride=stride), (0, 0, *size)
        try:
            mesh.place(laid.rest, moved)
            self._pass.clear()
            if not self._draft:
                yield from source.loading(*what_is_read(mesh, source, mesh.bounds_in(box), LEAST_STRETCH))
            yield from self._pass.drawing(mesh, source, box, draft=self._draft, in_pieces=not self._draft)
        finally:
            mesh.release()
        self.light.repeat_x = self.light.repeat_y = False
        if not self._draft:
            yield from self._prepare_pyramids(size)
            self.light.build_mipmaps()
            self.light.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
            yield

    def _prepare_pyramids(self, size: tuple[int, int]) -> Iterator[None]:
        """Build two small pyramids, with stops: the first ones take a software driver as long as a frame may take.

        It translates a program for the finest level and one for the others, for sides that are powers of two or not.
        """
        least = [2 if gpu.power_of_two(side) == side else 3 for side in size]
        for sides in ((least[0], least[1]), (2 * least[0], 2 * least[1])):
            yield
            small = self._context.texture(sides, 4, dtype="f2")
            small.build_mipmaps()
            small.release()
        yield

    def release(self) -> None:
        """Free the GPU objects."""
        self._steps = iter(())
        gpu.release(self._pass)


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
        self._best = LaidPicture(context, MOST_PX, draft=False)
        self._draft = LaidPicture(context, DRAFT_PX, draft=True)
        self._picture: LaidPicture | None = None
        """What lies on the surface."""
        self.is_refining = False
        """Whether drawing the same once more makes it better."""
        self.has_drawn = False
        """Whether it has taken time in this frame: for its surface, or for a picture that is laid on it."""
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
        frame_s: float = math.inf,
        waits: bool = False,
    ) -> moderngl.Texture:
        """Draw what is laid on its surface as a camera sees it, on a ground of the colour `desk`.

        A `draft` lays a smaller picture on it. So is done where the best one takes longer than `frame_s`, until it is
        there. One that `waits` for a frame of its own only turns what it shows, unless all is to be a draft.
        """
        self.has_drawn = False
        is_new, is_other = self._picture is None, laid.surface is not self._surface
        waits = waits and not draft
        if is_other and not waits:
            self._take(laid.surface)
            self.has_drawn = True
            waits = is_new and math.isfinite(frame_s)  # To draw it for the first time takes a frame of its own.
        if waits and self._picture is None:
            self._target.clear(color=desk)
            self.is_refining = True
            return self._shown
        if waits:
            self.is_refining = True
        else:
            self._picture = self._refine(laid, source, draft=draft, frame_s=frame_s)
        picture = self._picture
        assert picture is not None
        seen = picture, picture.shown, orbit, desk
        if self._seen == seen:
            return self._shown
        self._seen = seen
        assert self._surface is not None
        assert self._array is not None
        assert self._chart is not None
        self._chart.use(0)
        picture.light.use(1)
        uniforms = {
            "to_clip": tuple(orbit.clip_matrix(self._surface, self.size).T.ravel().tolist()),
            "to_camera": tuple(orbit.turned().T.ravel().tolist()),
            "chart": 0,
            "picture": 1,
            "ambient": AMBIENT,
            "bare": BARE if source.image.channels in (2, 4) else -1.0,
        }
        set_uniforms(programs_of(self._context).get("surface.vert", "surface.frag"), **uniforms)
        with gpu.drawing(self._target, (0, 0, *self._shown.size)):
            self._target.clear(color=desk)
            self._context.enable(moderngl.DEPTH_TEST)
            programs_of(self._context).render(self._array, 3 * len(self._surface.triangles))
            self._context.disable(moderngl.DEPTH_TEST)
        return self._shown

    def _refine(self, laid: Laid, source: Source, *, draft: bool, frame_s: float) -> LaidPicture:
        """Return the best picture that there can be in this frame of what is laid on the surface."""
        best, shown = self._best, self._draft
        if not best.shows(laid, source):
            if (draft or math.isfinite(frame_s)) and not shown.shows(laid, source):
                self.has_drawn = True
                shown.draw(laid, source)
            elif not draft:
                self.has_drawn = True
                best.draw(laid, source, frame_s)
        is_there = best.shows(laid, source)
        self.is_refining = not (draft or is_there)
        return best if is_there else shown

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
        corners, places = _find_corners(surface)
        self._corners = self._context.buffer(corners.tobytes())
        self._array = self._context.vertex_array(program, [(self._corners, "3f 3f 2f", "place", "normal", "share")])
        chart = self._context.texture((CHART_NODES, CHART_NODES), 2, places.tobytes(), dtype="f4")
        chart.filter = moderngl.LINEAR, moderngl.LINEAR
        chart.repeat_x = chart.repeat_y = False
        self._surface, self._chart = surface, chart

    def release(self) -> None:
        """Free the GPU objects."""
        gpu.release(self._array, self._corners, self._chart, self._best, self._draft)
        gpu.release(self._target, self._depth, self._shown)


def _are_same(one: tuple[Laid, Source] | None, laid: Laid, source: Source) -> bool:
    """Return whether one of two things laid on surfaces is the other: the same arrays, drawn from the same picture."""
    return one is not None and one[1] is source and laid.shows_same(one[0])


@functools.lru_cache(maxsize=1)
def _find_corners(surface: Surface) -> tuple[Floats, Floats]:
    """Return what is sent of a surface to each view of it, in single precision.

    The corners of its triangles (3 m, 8): place, normal and texture. And where places of the texture lie in the chart,
    (CHART_NODES, CHART_NODES, 2), as shares of its box.
    """
    corners = [surface.vertices[surface.triangles], surface.normals[surface.triangles], surface.corners]
    places = surface.chart.on_raster(CHART_NODES) / surface.chart.places.max(axis=(0, 1))
    return np.concatenate(corners, axis=-1).reshape(-1, 8).astype(np.float32), places.astype(np.float32)


class SurfaceViews:
    """Views of surfaces in one context, kept by their names; pictures come from `sources`.

    Each may take `frame_s` of a frame to get better, none while something else `gets_better` in the same frame.
    """

    def __init__(
        self, context: moderngl.Context, sources: Sources, frame_s: float, gets_better: Callable[[], bool]
    ) -> None:
        self._context, self._sources, self.frame_s, self.gets_better = context, sources, frame_s, gets_better
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
