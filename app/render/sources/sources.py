"""The pictures that the canvas is drawn from, kept on the GPU from frame to frame."""

import moderngl

from app.render.gpu import release
from app.render.scene import CanvasScene
from app.render.sources.cloth import DressedSource
from app.render.sources.source import Source
from core.imaging.images import Image

MARGIN = 0.25
MOST_KEPT = 2
"""A picture and what was made of it can be looked at in turn, or side by side."""


class Sources:
    """A source for each of the pictures drawn last, and one for the cloth that has a texture laid on."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._plain: list[Source] = []
        """The newest first."""
        self._cloth: DressedSource | None = None

    def of(self, image: Image) -> Source:
        """Return the source of `image`."""
        held = next((source for source in self._plain if source.image is image), None)
        held = held or Source(self._context, image, margin=MARGIN)
        sources = [held, *(source for source in self._plain if source is not held)]
        release(*sources[MOST_KEPT:])
        self._plain = sources[:MOST_KEPT]
        return held

    def of_result(self, scene: CanvasScene) -> Source:
        """Return what the result is drawn from: the picture, with the texture laid on if there is one."""
        overlay = scene.overlay
        if overlay is None:
            return self.of(scene.image)
        if self._cloth is None or self._cloth.image is not scene.image or self._cloth.parts is not overlay.parts:
            release(self._cloth)
            self._cloth = DressedSource(self._context, scene.image, overlay.parts)
        self._cloth.dress(overlay, draft=scene.draft)
        return self._cloth

    def release(self) -> None:
        """Free the GPU objects."""
        release(*self._plain, self._cloth)
        self._plain, self._cloth = [], None
