"""Draws the canvas of the window: what changed is drawn anew, the rest is kept from the frame before."""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TypeAlias, TypeVar

import moderngl

from app.render.bending import find_places
from app.render.desk import desk_uniforms
from app.render.dirty_region import find_moved, find_painted
from app.render.gpu import Offscreen, Rectangle, around, release
from app.render.layers import CanvasLayers, Costs
from app.render.passes.bent import BentCanvas
from app.render.passes.blitter import Blitter
from app.render.passes.draft import Draft
from app.render.passes.marks_layer import MarksLayer, names_of
from app.render.passes.picture_pass import LEAST_STRETCH, draw_at_once, strips, what_is_read
from app.render.passes.placed_meshes import PlacedMeshes
from app.render.passes.thumbnails import draw_thumbnails
from app.render.programs import programs_of
from app.render.scene import CanvasScene
from app.render.sources.source import Box, Source
from app.render.sources.sources import Sources
from core import tracing
from core.arrays import Bytes, Points
from core.imaging.images import Image

COMPOSED_PIXELS = 1 << 18
"""So much of the canvas is composed in one piece."""
AT_REST = 2.5
"""So much longer than while something moves a frame may take to make what rests better: nothing waits for it."""
NO_MARKS = 1e9
Size: TypeAlias = tuple[int, int]
_Sized = TypeVar("_Sized", CanvasLayers, Draft, BentCanvas)


class Renderer:
    """The canvas in one GL context.

    Where drawing it at its best takes longer than `frame_s`, what moves is drawn as a draft, and what rests gets better
    over several frames: the last picture, or a draft, stays until the best one is whole. The first picture of all is a
    draft; the best one is begun in what that leaves of the frame.

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
        self._blitter = Blitter(context)
        self._marks = MarksLayer(context)
        self._meshes = PlacedMeshes(context)
        self.sources = Sources(context)
        self._layers: CanvasLayers | None = None
        """The canvas at its best."""
        self._draft: Draft | None = None
        self._bent: BentCanvas | None = None
        self._costs = Costs(frame_s)
        self._gpu_time = context.query(time=True)
        self._sent_s = 0.0
        """What sending off the last picture took that nobody waited for; `_gpu_time` has what it took the GPU."""
        self._shows_best = False
        """Whether the window shows the canvas at its best."""

    @property
    def is_at_rest(self) -> bool:
        """Whether the canvas that was drawn last was there at its best."""
        return self._shows_best

    @property
    def is_refining(self) -> bool:
        """Whether drawing the same scene once more makes it better."""
        layers = self._layers
        return self._draft is not None if layers is None else layers.steps is not None

    def draw(self, scene: CanvasScene, viewport: Rectangle) -> None:
        """Draw `scene` into the bound framebuffer.

        `viewport` is left, bottom (upwards, as OpenGL has it), width and height in framebuffer pixels; the scene's view
        is that of a canvas widget of this size.
        """
        with tracing.span("draw"):
            started, rests, is_slow = self._clock(), replace(scene, draft=False), self._costs.full_fits is False
            if self._layers is None and self._draft is None and self._costs.frame_s < math.inf:
                self._show_whole_draft(scene, viewport)
                if self._clock() - started >= self._costs.frame_s:
                    return
            best = self._layers = self._fitting(self._layers, CanvasLayers, (viewport[2], viewport[3]))
            stays = self._shows_best and scene.fills_same_place(best.drawn)
            is_drafted = is_slow and not stays and not best.has_picture(rests)
            if is_drafted:
                self._show_draft(scene, viewport, best)
            if scene.draft and is_slow:
                best.give_up()
                self._shows_best = False
            else:  # in what a draft leaves of the frame
                self._shows_best = self._refine(rests, best, started) or stays
            if self._shows_best:
                self._blitter.show(best, scene.palette.desk, viewport)
            elif not is_drafted:
                self._show_draft(scene, viewport, best)

    def _refine(self, scene: CanvasScene, best: CanvasLayers, started: float) -> bool:
        """Draw on for what is left of a frame that has `started`; return whether the canvas is there at its best."""
        if best.shows(scene):
            best.give_up()
            return True
        if not scene.shows_same_picture(best.goal):
            best.begin(scene, self._loading(scene, best), self._best(scene, best))
        if best.steps is not None and not (self._loads_on(best) and self._goes_on(best, started)):
            return False
        if not best.shows(scene):
            draw_at_once(self._composing(scene, best))
        return True

    def _loading(self, scene: CanvasScene, layers: CanvasLayers) -> Iterator[None]:
        """Send what the picture is drawn from to the GPU, piece by piece."""
        for name, nodes, box in scene.parts(layers.picture.size):
            mesh, source = self._meshes.place(name, scene, nodes), self._source_of(name, scene)
            yield from source.loading(*what_is_read(mesh, source, mesh.bounds_in(box), LEAST_STRETCH))

    def _loads_on(self, best: CanvasLayers) -> bool:
        """Load for as long as a frame may take; return whether all is there."""
        started = self._clock()
        return all(self._clock() - started < self._costs.frame_s for _ in best.loads)

    def _best(self, scene: CanvasScene, best: CanvasLayers) -> Iterator[None]:
        """Draw the picture and then the canvas, piece by piece."""
        yield from self._drawing(scene, best)
        yield
        yield from self._composing(scene, best)

    def _goes_on(self, best: CanvasLayers, frame_started: float) -> bool:
        """Take the next steps, one at least; return whether there are no more."""
        assert best.steps is not None
        if self._costs.full_fits:
            self._send(best, best.steps)
            return True
        started = self._clock()
        with tracing.span("refine"):
            for _ in best.steps:
                self._context.finish()
                if self._clock() - frame_started >= AT_REST * self._costs.frame_s:
                    best.spent_s += self._clock() - started
                    self._costs.learn_full(best.spent_s, finished=False)
                    return False
        best.spent_s += self._clock() - started
        best.steps = None
        self._costs.learn_full(best.spent_s, finished=True)
        return True

    def _send(self, best: CanvasLayers, steps: Iterator[None]) -> None:
        """Send all of the picture to the GPU, which draws it while the next frame is prepared; learn from the last."""
        if self._sent_s:
            self._costs.learn_full(max(self._sent_s, self._gpu_time.elapsed / 1e9), finished=True)
        started = self._clock()
        with tracing.span("refine"), self._gpu_time:
            draw_at_once(steps)
        self._sent_s = self._clock() - started
        best.steps = None

    def _show_draft(self, scene: CanvasScene, viewport: Rectangle, best: CanvasLayers) -> None:
        """Show `scene` as fast as can be, but what stands still at its best.

        What moves is bent along from the best, or drawn with fewer pixels and larger cells where that lacks something.
        """
        moved, shrink, blitter = find_moved(scene, best.drawn), self._costs.shrink, self._blitter
        if moved is None or best.drawn is None:
            self._show_whole_draft(scene, viewport)
            return
        blitter.show(best, scene.palette.desk, viewport)
        box = _common(moved, (scene.divider(best.size[0]), 0, *best.size))
        if box[0] >= box[2] or box[1] >= box[3]:
            return
        bent = self._bent = self._fitting(self._bent, BentCanvas, best.size)
        if not bent.shows(scene, best.drawn):
            places = find_places(scene, best.drawn, box)
            if places is None:
                part = _shrunk(box, shrink)
                blitter.copy(self._drafted(scene, viewport, shrink, part).shown, part, viewport, shrink)
                return
            with tracing.span("bend"):
                bent.draw(best, scene, places, box, desk_uniforms(scene))
        blitter.copy(bent.shown, box, viewport)

    def _show_whole_draft(self, scene: CanvasScene, viewport: Rectangle) -> None:
        """Show all of `scene` with fewer pixels and larger cells."""
        shrink = self._costs.shrink
        self._blitter.show(self._drafted(scene, viewport, shrink, None), scene.palette.desk, viewport, shrink)

    def _drafted(self, scene: CanvasScene, viewport: Rectangle, shrink: int, part: Box | None) -> Draft:
        """Return a draft of `scene`, so many times smaller, or of `part` of it, in its pixels."""
        scene = replace(scene, shrink=shrink, draft=True)
        size = -(-viewport[2] // shrink), -(-viewport[3] // shrink)
        draft = self._draft = self._fitting(self._draft, Draft, size)
        with tracing.span("draft", shrink=shrink):
            if not draft.shows(scene, part):
                started = self._clock()
                self._draw_draft(scene, draft, part)
                self._context.finish()
                self._costs.learn_draft(self._clock() - started, shrink)
        return draft

    def _draw_draft(self, scene: CanvasScene, draft: Draft, part: Box | None) -> None:
        """Draw desk, picture and marks, in the pixels of `part` if it is given."""
        look = self._look(scene, draft.size[0])
        draft.begin(scene, part)
        for name, nodes, box in scene.parts(draft.size):
            mesh = self._meshes.place(name, scene, nodes)
            draft.draw(mesh, self._source_of(name, scene), box, look, names_of(scene.marks))

    def thumbnails(self, image: Image, rest: Points, warps: Sequence[Points], size: tuple[int, int]) -> list[Bytes]:
        """Return `image` under each of `warps`, (R, C, 2) like `rest`, fitted into `size`: (h, w, 4)."""
        return draw_thumbnails(self._context, self.sources.of(image), rest, warps, size)

    def release(self) -> None:
        """Free the GPU objects; drawing makes them anew."""
        release(self._marks, self.sources, self._meshes, self._layers, self._draft, self._bent)
        self._layers, self._draft, self._bent = None, None, None

    def _drawing(self, scene: CanvasScene, layers: CanvasLayers) -> Iterator[None]:
        """Draw the picture in linear light: the result, the picture as it was, or both.

        That goes piece by piece unless a frame has time for all of it: each piece costs the processor, too.
        """
        layers.picture.clear()
        yield
        in_pieces = not self._costs.full_fits
        for name, nodes, box in scene.parts(layers.picture.size):
            mesh = self._meshes.place(name, scene, nodes)
            yield from layers.picture.drawing(mesh, self._source_of(name, scene), box, in_pieces=in_pieces)

    def _composing(self, scene: CanvasScene, layers: CanvasLayers) -> Iterator[None]:
        """Lay the picture on the desk and the marks on the picture: piece by piece, or only where they have changed."""
        touched = find_painted(scene, layers.drawn)
        bounds = scene.bounds(layers.coming.size)
        if touched is not None:
            size = layers.shown.size
            for part in (_rectangle(touched, size), *around(_rectangle(layers.bounds, size), _rectangle(bounds, size))):
                self._compose(scene, layers, layers.shown, part)
        else:
            for strip in (bounds,) if self._costs.full_fits else strips(bounds, COMPOSED_PIXELS):
                self._compose(scene, layers, layers.coming, _rectangle(strip, layers.coming.size))
                yield
            layers.turn()
        layers.bounds, layers.drawn = bounds, scene

    def _compose(self, scene: CanvasScene, layers: CanvasLayers, canvas: Offscreen, part: Rectangle) -> None:
        """Compose a part of the canvas."""
        with canvas.drawing(None, part):
            layers.picture.light.texture.use(0)
            layers.cells.texture.use(1)
            look = self._look(scene, layers.picture.size[0])
            self._programs.fullscreen("compose.frag", names_of(scene.marks), light=0, cells=1, **look)

    def _look(self, scene: CanvasScene, width: int) -> dict[str, object]:
        """Return the uniforms of canvas.glsl and marks.glsl for a canvas so wide, and bind what they read."""
        marks_from = float(scene.divider(width)) if scene.marks.any else NO_MARKS
        return {"marks_from": marks_from, **desk_uniforms(scene), **self._marks.uniforms(scene)}

    def _fitting(self, held: _Sized | None, make: Callable[[moderngl.Context, Size], _Sized], size: Size) -> _Sized:
        """Return what is held for canvases of a size, (w, h), made anew for another one."""
        size = max(size[0], 1), max(size[1], 1)
        if held is not None and held.size == size:
            return held
        release(held)
        return make(self._context, size)

    def _source_of(self, name: str, scene: CanvasScene) -> Source:
        """Return what the part called `name` is drawn from."""
        return self.sources.of(scene.before or scene.image) if name == "before" else self.sources.of_result(scene)


def _shrunk(box: Box, shrink: int) -> Box:
    """Return the pixels that cover `box` in what is drawn `shrink` times smaller."""
    return box[0] // shrink, box[1] // shrink, -(-box[2] // shrink), -(-box[3] // shrink)


def _common(a: Box, b: Box) -> Box:
    """Return the part that two boxes share; its sides may be the wrong way round."""
    return max(a[0], b[0]), max(a[1], b[1]), min(a[2], b[2]), min(a[3], b[3])


def _rectangle(box: Box, size: tuple[int, int]) -> Rectangle:
    """Return the part of a target of `size` that `box` covers."""
    left, top = min(max(box[0], 0), size[0]), min(max(box[1], 0), size[1])
    return left, top, max(min(box[2], size[0]) - left, 0), max(min(box[3], size[1]) - top, 0)
