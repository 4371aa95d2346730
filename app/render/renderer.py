"""Draws the canvas of the window: what changed is drawn anew, the rest is kept from the frame before."""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import moderngl
import numpy as np

from app.render.cloth import DressedSource
from app.render.gpu import Offscreen, Rectangle
from app.render.layers import Costs, Layers
from app.render.marks_layer import MarksLayer, names_of
from app.render.mesh import Mesh
from app.render.picture_pass import strips
from app.render.programs import programs_of
from app.render.scene import Color, Scene
from app.render.source import Box, Source
from app.render.thumbnails import draw_thumbnails
from app.render.touched import touched_by_painting
from core import color, tracing
from core.arrays import Bytes, Points
from core.images import Image

CHECK_PX = 8.0
COMPOSED_PIXELS = 1 << 18
"""So much of the canvas is composed in one piece."""
DRAFT_CELL_PX = 6.0
"""Cells of a draft are about so many of its pixels wide, where the grid's are smaller."""
NO_MARKS = 1e9
SOURCES_KEPT = 2
"""A picture and what was made of it can be looked at in turn, or side by side."""
NO_FRAME = (0.0, 0.0, 0.0, 0.0)


class Renderer:
    """The canvas in one GL context.

    Where drawing it at its best takes longer than `frame_s`, what moves is drawn as a draft, and what rests gets better
    over several frames: the last picture, or a draft, stays until the best one is whole.

    It leaves the bound framebuffer and the viewport as they were, and blending and scissor off.
    """

    def __init__(
        self,
        context: moderngl.Context,
        *,
        frame_s: float = math.inf,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        self._context = context
        self._programs = programs_of(context)
        self._clock = clock
        self._marks = MarksLayer(context)
        self._meshes: dict[tuple[str, bool], Mesh] = {}
        self._sources: list[Source] = []
        """Of the pictures drawn last, the newest first."""
        self._cloth: DressedSource | None = None
        self._layers: dict[bool, Layers] = {}
        """For the canvas at its best and for drafts."""
        self._costs = Costs(frame_s)
        self._shows_best = False
        """Whether the window shows the canvas at its best."""

    @property
    def is_at_rest(self) -> bool:
        """Whether the canvas that was drawn last was there at its best."""
        return self._shows_best

    @property
    def is_refining(self) -> bool:
        """Whether drawing the same scene once more makes it better."""
        return False in self._layers and self._layers[False].steps is not None

    def draw(self, scene: Scene, viewport: tuple[int, int, int, int]) -> None:
        """Draw `scene` into the bound framebuffer.

        `viewport` is left, bottom (upwards, as OpenGL has it), width and height in framebuffer pixels; the scene's view
        is that of a canvas widget of this size.
        """
        best = self._layers_of((viewport[2], viewport[3]), draft=False)
        with tracing.span("draw"):
            if scene.draft and self._costs.full_fits is False:
                best.give_up()
                self._shows_best = False
            elif self._refine(replace(scene, draft=False), best):
                self._shows_best = True
            elif not (self._shows_best and _lies_alike(scene, best.drawn)):
                self._shows_best = False
            if self._shows_best:
                self._show(best, viewport, 1)
            else:
                self._show_draft(scene, viewport)

    def _refine(self, scene: Scene, best: Layers) -> bool:
        """Draw on for as long as a frame may take; return whether the canvas is there at its best."""
        if best.shows(scene):
            best.give_up()
            return True
        if not scene.shows_same_picture(best.goal):
            best.begin(scene, self._best(scene, best))
        if best.steps is not None and not self._goes_on(best):
            return False
        if not best.shows(scene):
            _exhaust(self._composing(scene, best))
        return True

    def _best(self, scene: Scene, best: Layers) -> Iterator[None]:
        """Draw the picture and then the canvas, piece by piece."""
        yield from self._drawing(scene, best)
        yield
        yield from self._composing(scene, best)

    def _goes_on(self, best: Layers) -> bool:
        """Take the next steps; return whether there are no more."""
        assert best.steps is not None
        started, fits = self._clock(), self._costs.full_fits
        with tracing.span("refine"):
            for _ in best.steps:
                if fits or math.isinf(self._costs.frame_s):
                    continue
                self._context.finish()
                if self._clock() - started >= self._costs.frame_s:
                    best.spent_s += self._clock() - started
                    self._costs.learn_full(best.spent_s, finished=False)
                    return False
            self._context.finish()
        best.spent_s += self._clock() - started
        best.steps = None
        self._costs.learn_full(best.spent_s, finished=True)
        return True

    def _show_draft(self, scene: Scene, viewport: tuple[int, int, int, int]) -> None:
        """Draw and show `scene` with fewer pixels and larger cells."""
        shrink = self._costs.shrink
        scene = replace(scene, pixel_ratio=scene.pixel_ratio / shrink, draft=True)
        layers = self._layers_of((-(-viewport[2] // shrink), -(-viewport[3] // shrink)), draft=True)
        with tracing.span("draft", shrink=shrink):
            started = self._clock()
            same_picture = scene.shows_same_picture(layers.drawn)
            if not same_picture:
                _exhaust(self._drawing(scene, layers))
            if not layers.shows(scene):
                _exhaust(self._composing(scene, layers))
            if not same_picture:
                self._context.finish()
                self._costs.learn_draft(self._clock() - started, shrink)
        self._show(layers, viewport, shrink)

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

    def _drawing(self, scene: Scene, layers: Layers) -> Iterator[None]:
        """Draw the picture in linear light, piece by piece: the result, the picture as it was, or both."""
        width, height = layers.picture.size
        divider = _divider(scene, width)
        parts: list[tuple[str, Points, Box]] = [
            ("before", scene.rest, (0, 0, divider, height)),
            ("result", scene.warped, (divider, 0, width, height)),
        ]
        layers.picture.clear()
        yield
        for name, nodes, box in parts:
            if box[0] < box[2]:
                positions = scene.in_framebuffer(nodes)
                mesh = self._mesh_of(name, scene, positions)
                mesh.place(scene.rest, positions)
                source = self._source_of(scene.before or scene.image) if name == "before" else self._result_of(scene)
                yield from layers.picture.drawing(mesh, source, box, draft=scene.draft)

    def _composing(self, scene: Scene, layers: Layers) -> Iterator[None]:
        """Lay the picture on the desk and the marks on the picture: piece by piece, or only where they have changed."""
        touched = touched_by_painting(scene, layers.drawn)
        if touched is not None:
            self._compose(scene, layers, layers.shown, _rectangle(touched, layers.shown.size))
        else:
            width, height = layers.coming.size
            for _, top, _, bottom in strips((0, 0, width, height), COMPOSED_PIXELS):
                self._compose(scene, layers, layers.coming, (0, top, width, bottom - top))
                yield
            layers.turn()
        layers.drawn = scene

    def _compose(self, scene: Scene, layers: Layers, canvas: Offscreen, part: Rectangle) -> None:
        """Compose a part of the canvas."""
        frame = NO_FRAME
        if scene.frame is not None:
            left, top, right, bottom = (scene.in_framebuffer(np.reshape(scene.frame, (2, 2))) + 0.5).ravel()
            frame = float(left), float(top), float(right), float(bottom)
        dark, light = scene.palette.checks
        with canvas.drawing(None, part):
            layers.picture.light.texture.use(0)
            layers.cells.texture.use(1)
            self._programs.fullscreen(
                "compose.frag",
                names_of(scene.marks),
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

    def _show(self, layers: Layers, viewport: tuple[int, int, int, int], shrink: int) -> None:
        before, self._context.viewport = self._context.viewport, viewport
        smooth = moderngl.NEAREST if shrink == 1 else moderngl.LINEAR
        layers.shown.texture.filter = (smooth, smooth)
        layers.shown.texture.use(0)
        part = tuple(viewport[axis] / (shrink * layers.shown.size[axis - 2]) for axis in (2, 3))
        self._programs.fullscreen("show.frag", (), "show.vert", canvas=0, part=part)
        self._context.viewport = before

    def _layers_of(self, size: tuple[int, int], *, draft: bool) -> Layers:
        size = max(size[0], 1), max(size[1], 1)
        layers = self._layers.get(draft)
        if layers is None or layers.picture.size != size:
            if layers is not None:
                layers.release()
            layers = self._layers[draft] = Layers(self._context, size)
        return layers

    def _source_of(self, image: Image) -> Source:
        held = next((source for source in self._sources if source.image is image), None)
        held = held or Source(self._context, image, margin=0.25)
        sources = [held, *(source for source in self._sources if source is not held)]
        for dropped in sources[SOURCES_KEPT:]:
            dropped.release()
        self._sources = sources[:SOURCES_KEPT]
        return held

    def _result_of(self, scene: Scene) -> Source:
        """Return what the result is drawn from: the picture, with the texture laid on if there is one."""
        dressing = scene.dressing
        if dressing is None:
            return self._source_of(scene.image)
        if self._cloth is None or self._cloth.image is not scene.image or self._cloth.parts is not dressing.parts:
            if self._cloth is not None:
                self._cloth.release()
            self._cloth = DressedSource(self._context, scene.image, dressing.parts)
        self._cloth.dress(dressing, draft=scene.draft)
        return self._cloth

    def _mesh_of(self, name: str, scene: Scene, positions: Points) -> Mesh:
        """Return the mesh called `name`, made anew for another grid shape."""
        key, shape = (name, scene.draft), (positions.shape[0], positions.shape[1])
        stride = _draft_stride(positions) if scene.draft else 1
        held = self._meshes.get(key)
        if held is None or (held.shape, held.stride) != (shape, stride):
            if held is not None:
                held.release()
            held = self._meshes[key] = Mesh(self._context, shape, stride=stride)
        return held


def _exhaust(steps: Iterator[None]) -> None:
    """Take all steps at once."""
    for _ in steps:
        pass


def _lies_alike(scene: Scene, shown: Scene | None) -> bool:
    """Return whether the picture that is `shown` may stay till `scene` is drawn: it fills the same place."""
    return (
        shown is not None
        and scene.image is shown.image
        and scene.before is shown.before
        and (scene.view, scene.pixel_ratio, scene.compare, scene.split)
        == (shown.view, shown.pixel_ratio, shown.compare, shown.split)
    )


def _draft_stride(positions: Points) -> int:
    """Return which nodes of a row a draft draws, from their positions (R, C, 2) in its pixels: every so manieth."""
    cells = positions.shape[1] - 1, positions.shape[0] - 1
    span = max(float(np.ptp(positions[..., axis])) / cells[axis] for axis in (0, 1))
    return max(int(DRAFT_CELL_PX / max(span, 1e-3)), 1)


def _rectangle(box: Box, size: tuple[int, int]) -> Rectangle:
    """Return the part of a target of `size` that `box` covers."""
    left, top = min(max(box[0], 0), size[0]), min(max(box[1], 0), size[1])
    return left, top, max(min(box[2], size[0]) - left, 0), max(min(box[3], size[1]) - top, 0)


def _divider(scene: Scene, width: int) -> int:
    """Return the framebuffer column from which on the result is shown."""
    return {"result": 0, "before": width}.get(scene.compare, round(scene.split * width))


def _linear(shade: Color) -> tuple[float, float, float]:
    red, green, blue = color.decode(np.asarray(shade[:3], np.float32)).tolist()
    return red, green, blue
