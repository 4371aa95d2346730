"""What a test sees in place of a window."""

import numpy as np

from app.render import gpu
from app.render.renderer import Renderer
from app.render.scene import CanvasScene
from core.arrays import Bytes


class Surface:
    """A framebuffer of a size, (w, h), and a renderer that may take `frame_s` of a frame."""

    def __init__(self, size: tuple[int, int], frame_s: float) -> None:
        self._size = size
        context = gpu.standalone()
        self.framebuffer = context.simple_framebuffer(size, 4)
        self.renderer = Renderer(context, frame_s=frame_s)

    def shot(self, scene: CanvasScene) -> Bytes:
        """Draw one frame and return what is seen, (h, w, 3), the lowest row first."""
        self.framebuffer.use()
        self.renderer.draw(scene, (0, 0, *self._size))
        return np.frombuffer(self.framebuffer.read(), np.uint8).reshape(*self._size[::-1], 3)
