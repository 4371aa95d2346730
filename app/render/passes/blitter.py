"""Copies canvases to the window."""

from typing import Protocol

import moderngl

from app.render.gpu import Offscreen, Rectangle, around
from app.render.programs import programs_of
from app.render.sources.source import Box

Colour = tuple[float, float, float, float]


class Drawn(Protocol):
    """What can be shown."""

    @property
    def shown(self) -> Offscreen:
        """The canvas, its first row the top one."""

    @property
    def bounds(self) -> Box:
        """Its pixels outside which there is nothing but desk."""


class Blitter:
    """Copies into the bound framebuffer; a viewport is left, bottom (upwards), width and height in its pixels."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._programs = programs_of(context)

    def show(self, drawn: Drawn, desk: Colour, viewport: Rectangle, shrink: int = 1) -> None:
        """Copy what was drawn, `shrink` times smaller, to the window; around it is desk."""
        if self._programs.draws:
            for strip in around(_place_of(drawn.bounds, viewport, shrink), viewport):
                self._context.detect_framebuffer().clear(*desk, viewport=strip)
        self.copy(drawn.shown, drawn.bounds, viewport, shrink)

    def copy(self, canvas: Offscreen, box: Box, viewport: Rectangle, shrink: int = 1) -> None:
        """Copy a box of what was drawn, `shrink` times smaller, to the window."""
        context, before = self._context, self._context.viewport
        left, top, right, bottom = box
        if left < right and top < bottom:
            width, height = canvas.size
            context.viewport = _place_of(box, viewport, shrink)
            context.scissor = viewport
            canvas.texture.use(0)
            shown = left / width, top / height, right / width, bottom / height
            self._programs.fullscreen("show.frag", (), "show.vert", canvas=0, shown=shown)
            context.scissor = None
        context.viewport = before


def _place_of(box: Box, viewport: Rectangle, shrink: int) -> Rectangle:
    """Return where a box of what was drawn `shrink` times smaller lies in the window, bottom upwards."""
    left, top, right, bottom = (shrink * side for side in box)
    return viewport[0] + left, viewport[1] + viewport[3] - bottom, right - left, bottom - top
