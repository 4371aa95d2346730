"""Draws the canvas of the window: what changed is drawn anew, the rest is kept from the frame before."""

import time
from collections.abc import Sequence
from dataclasses import replace

import moderngl
import numpy as np

from app.render import gpu
from app.render.cloth import DressedSource
from app.render.dressing import Dressing
from app.render.marks_layer import MarksLayer
from app.render.mesh import Mesh
from app.render.picture_pass import PicturePass
from app.render.programs import programs_of
from app.render.scene import Color, Scene
from app.render.source import Box, Source
from app.render.thumbnails import draw_thumbnails
from core import color, tracing
from core.arrays import Bytes, Points
from core.images import Image

CHECK_PX = 8.0
DRAFT_S = 0.016
"""What drawing a draft may take."""
MOST_SHRINK = 3
NO_MARKS = 1e9
SOURCES_KEPT = 2
"""A picture and what was made of it can be looked at in turn, or side by side."""
NO_FRAME = (0.0, 0.0, 0.0, 0.0)


class Renderer:
    """The canvas in one GL context.

    It leaves the bound framebuffer and the viewport as they were, and blending and scissor off.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._programs = programs_of(context)
        self._marks = MarksLayer(context)
        self._meshes: dict[str, Mesh] = {}
        self._sources: list[Source] = []
        """Of the pictures drawn last, the newest first."""
        self._cloth: DressedSource | None = None
        self._layers: dict[bool, _Layers] = {}
        """For the canvas at rest and for drafts."""
        self._cost_s = 0.0

    def draw(self, scene: Scene, viewport: tuple[int, int, int, int]) -> None:
        """Draw `scene` into the bound framebuffer.

        `viewport` is left, bottom (upwards, as OpenGL has it), width and height in framebuffer pixels; the scene's view
        is that of a canvas widget of this size.
        """
        shrink = self._shrink if scene.draft else 1
        if shrink > 1:
            scene = replace(scene, pixel_ratio=scene.pixel_ratio / shrink)
        with tracing.span("draw", shrink=shrink):
            layers = self._layers_of(
                (max(-(-viewport[2] // shrink), 1), max(-(-viewport[3] // shrink), 1)), scene.draft
            )
            started = time.perf_counter()
            same_picture = scene.shows_same_picture(layers.drawn)
            if not same_picture:
                self._draw_picture(scene, layers)
            if not (same_picture and scene.shows_same_marks(layers.drawn)):
                self._compose(scene, layers)
            if not same_picture:
                self._context.finish()
                self._learn_cost((time.perf_counter() - started) * shrink**2)
            layers.drawn = scene
            self._show(layers, viewport, shrink)

    @property
    def _shrink(self) -> int:
        """By how much a draft is drawn smaller, so that it keeps up with the mouse: 1 on any GPU."""
        fitting = (shrink for shrink in range(1, MOST_SHRINK) if self._cost_s <= DRAFT_S * shrink**2)
        return next(fitting, MOST_SHRINK)

    def _learn_cost(self, seconds: float) -> None:
        """Take note of what drawing the whole canvas costs; a single late frame does not count much."""
        self._cost_s = seconds if self._cost_s == 0.0 else 0.7 * self._cost_s + 0.3 * seconds

    def thumbnails(self, image: Image, rest: Points, warps: Sequence[Points], size: tuple[int, int]) -> list[Bytes]:
        """Return `image` under each of `warps`, (R, C, 2) like `rest`, fitted into `size`: (h, w, 4)."""
        return draw_thumbnails(self._context, self._source_of(image), rest, warps, size)

    def release(self) -> None:
        """Free the GPU objects; drawing makes them anew."""
        self._marks.release()
        for held in (*self._meshes.values(), *self._sources, self._cloth, *self._layers.values()):
            if held is not None:
                held.release()
        self._meshes, self._sources, self._cloth, self._layers = {}, [], None, {}

    def _draw_picture(self, scene: Scene, layers: "_Layers") -> None:
        """Draw the picture in linear light: the result, the picture as it was, or both beside the divider."""
        width, height = layers.picture.size
        divider = _divider(scene, width)
        parts: list[tuple[str, Points, Box]] = [
            ("before", scene.rest, (0, 0, divider, height)),
            ("result", scene.warped, (divider, 0, width, height)),
        ]
        source = self._source_of(scene.image) if scene.dressing is None else self._dressed(scene, scene.dressing)
        layers.picture.clear()
        for name, nodes, box in parts:
            if box[0] < box[2]:
                mesh = self._mesh_of(name, scene.rest)
                mesh.place(scene.rest, _framebuffer_positions(scene, nodes))
                drawn = self._source_of(scene.before or scene.image) if name == "before" else source
                layers.picture.draw(mesh, drawn, box, draft=scene.draft)

    def _compose(self, scene: Scene, layers: "_Layers") -> None:
        frame = NO_FRAME
        if scene.frame is not None:
            left, top, right, bottom = (_framebuffer_positions(scene, np.reshape(scene.frame, (2, 2))) + 0.5).ravel()
            frame = float(left), float(top), float(right), float(bottom)
        dark, light = scene.palette.checks
        with layers.shown.drawing():
            layers.picture.light.texture.use(0)
            layers.cells.texture.use(1)
            self._programs.fullscreen(
                "compose.frag",
                light=0,
                cells=1,
                marks_from=float(_divider(scene, layers.picture.size[0])) if scene.marks.any else NO_MARKS,
                frame=frame,
                check_px=CHECK_PX * scene.pixel_ratio,
                desk=_linear(scene.palette.desk),
                check_dark=_linear(dark),
                check_light=_linear(light),
                **self._marks.uniforms(scene),
            )

    def _show(self, layers: "_Layers", viewport: tuple[int, int, int, int], shrink: int) -> None:
        before, self._context.viewport = self._context.viewport, viewport
        smooth = moderngl.NEAREST if shrink == 1 else moderngl.LINEAR
        layers.shown.texture.filter = (smooth, smooth)
        layers.shown.texture.use(0)
        self._programs.fullscreen("show.frag", canvas=0, viewport=viewport, shrink=float(shrink))
        self._context.viewport = before

    def _layers_of(self, size: tuple[int, int], draft: bool) -> "_Layers":
        layers = self._layers.get(draft)
        if layers is None or layers.picture.size != size:
            if layers is not None:
                layers.release()
            layers = self._layers[draft] = _Layers(self._context, size)
        return layers

    def _source_of(self, image: Image) -> Source:
        held = next((source for source in self._sources if source.image is image), None)
        held = held or Source(self._context, image, margin=0.25)
        sources = [held, *(source for source in self._sources if source is not held)]
        for dropped in sources[SOURCES_KEPT:]:
            dropped.release()
        self._sources = sources[:SOURCES_KEPT]
        return held

    def _dressed(self, scene: Scene, dressing: Dressing) -> DressedSource:
        if self._cloth is None or self._cloth.image is not scene.image or self._cloth.parts is not dressing.parts:
            if self._cloth is not None:
                self._cloth.release()
            self._cloth = DressedSource(self._context, scene.image, dressing.parts)
        self._cloth.dress(dressing, draft=scene.draft)
        return self._cloth

    def _mesh_of(self, name: str, rest: Points) -> Mesh:
        """Return the mesh called `name`, made anew for another grid shape."""
        shape = (rest.shape[0], rest.shape[1])
        if name not in self._meshes or self._meshes[name].shape != shape:
            if name in self._meshes:
                self._meshes[name].release()
            self._meshes[name] = Mesh(self._context, shape)
        return self._meshes[name]


class _Layers:
    """What is kept from frame to frame: the picture in linear light, and the canvas as shown."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.picture = PicturePass(context, size, with_cells=True)
        self.shown = gpu.Offscreen(context, size, "f1")
        self.drawn: Scene | None = None
        """What they show."""

    @property
    def cells(self) -> gpu.Offscreen:
        """Grid coordinates of every pixel."""
        assert self.picture.cells is not None
        return self.picture.cells

    def release(self) -> None:
        """Free the GPU objects."""
        self.picture.release()
        self.shown.release()


def _divider(scene: Scene, width: int) -> int:
    """Return the framebuffer column from which on the result is shown."""
    return {"result": 0, "before": width}.get(scene.compare, round(scene.split * width))


def _framebuffer_positions(scene: Scene, points: Points) -> Points:
    """Return canvas positions in framebuffer pixels, centres at integers.

    Where a canvas pixel is a whole number of framebuffer pixels, their borders are made to coincide, which moves the
    picture by half a pixel at most: at 100 % the pixels of the file are those of the screen.
    """
    zoom = scene.view.zoom * scene.pixel_ratio
    corner = np.asarray(scene.view.pan) * scene.pixel_ratio - zoom / 2
    if abs(zoom - round(zoom)) < 1e-6 and zoom > 0.5 and not scene.draft:
        corner = np.round(corner)
    positions: Points = (points + 0.5) * zoom + corner - 0.5
    return positions


def _linear(shade: Color) -> tuple[float, float, float]:
    red, green, blue = color.decode(np.asarray(shade[:3], np.float32)).tolist()
    return red, green, blue
