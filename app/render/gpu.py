"""OpenGL contexts, and the pieces that every pass uses.

A context belongs to the thread that made it. GPU objects are a cache of plain arrays: they can be dropped and made anew
at any time.
"""

import sys
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any, Protocol

import moderngl

from app.render.programs import programs_of
from core.arrays import WeftError

COMPUTE = 430
"""OpenGL 4.3, the first with compute shaders."""
_SOFTWARE = ("llvmpipe", "softpipe", "swrast", "SwiftShader", "Microsoft Basic Render")
"""In the names of drivers that draw on the processor."""
_LIBGL: dict[str, Any] = {"libgl": "libGL.so.1"} if sys.platform.startswith("linux") else {}
"""The name that OpenGL has on every Linux; moderngl would start other programs to look for it."""
_threads = threading.local()


def standalone() -> moderngl.Context:
    """Return this thread's context without a window, made at the first call, and make it current.

    Raises
    ------
    WeftError
        If the machine has no OpenGL 3.3.
    """
    context: moderngl.Context | None = getattr(_threads, "context", None)
    if context is None:
        settings: dict[str, Any] = {"backend": "egl", "libegl": "libEGL.so.1", **_LIBGL} if _LIBGL else {}
        try:
            context = moderngl.create_standalone_context(require=330, **settings)
        except Exception as fault:
            raise WeftError(f"no OpenGL 3.3 without a window: {fault}") from fault
        _threads.context = context
    _current(context).__enter__()  # another one may have been made current since
    return context


def is_software(context: moderngl.Context) -> bool:
    """Return whether the context's driver draws on the processor."""
    return any(name in context.info["GL_RENDERER"] for name in _SOFTWARE)


def let_go() -> None:
    """Leave no context current in this thread: a window's cannot take the place of one without a window."""
    context: moderngl.Context | None = getattr(_threads, "context", None)
    if context is not None:
        _current(context).__exit__(None, None, None)


def _current(context: moderngl.Context) -> AbstractContextManager[object]:
    """Return what makes `context` the current one of this thread while it is entered."""
    manager: AbstractContextManager[object] = context
    return manager


def attach() -> moderngl.Context:
    """Return a context over the window's, which must be current in this thread."""
    return moderngl.create_context(require=330, **({"libx11": "libX11.so.6", **_LIBGL} if _LIBGL else {}))


Rectangle = tuple[int, int, int, int]
"""Left, first row, width and height in pixels of a framebuffer."""


def around(inner: Rectangle, outer: Rectangle) -> list[Rectangle]:
    """Return what `inner` leaves free of `outer`: below and above it in full rows, then at its sides."""
    left, low = max(inner[0], outer[0]), max(inner[1], outer[1])
    right, high = min(inner[0] + inner[2], outer[0] + outer[2]), min(inner[1] + inner[3], outer[1] + outer[3])
    if left >= right or low >= high:
        return [outer]
    rows = [
        (outer[0], outer[1], outer[2], low - outer[1]),
        (outer[0], high, outer[2], outer[1] + outer[3] - high),
        (outer[0], low, left - outer[0], high - low),
        (right, low, outer[0] + outer[2] - right, high - low),
    ]
    return [row for row in rows if row[2] > 0 and row[3] > 0]


@contextmanager
def drawing(framebuffer: moderngl.Framebuffer, viewport: Rectangle, scissor: Rectangle | None = None) -> Iterator[None]:
    """Draw into `framebuffer` inside the block; then what was drawn into before is bound again."""
    context = framebuffer.ctx
    before, viewport_before = context.detect_framebuffer(), context.viewport
    framebuffer.use()
    context.viewport, context.scissor = viewport, scissor
    try:
        yield
    finally:
        context.scissor = None
        before.use()
        context.viewport = viewport_before


class Releasable(Protocol):
    """What holds GPU objects."""

    def release(self) -> object:
        """Free them."""


def release(*held: Releasable | None) -> None:
    """Free the GPU objects of all that there is."""
    for thing in held:
        if thing is not None:
            thing.release()


class Offscreen:
    """A texture of four channels to draw into."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int], dtype: str) -> None:
        self.size = size
        self.texture = context.texture(size, 4, dtype=dtype)
        self.texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._context = context
        self._framebuffer = context.framebuffer([self.texture])

    @contextmanager
    def drawing(self, viewport: Rectangle | None = None, scissor: Rectangle | None = None) -> Iterator[None]:
        """Draw into the texture inside the block."""
        with drawing(self._framebuffer, viewport or (0, 0, *self.size), scissor):
            yield

    def clear(self, color: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)) -> None:
        """Make every pixel of one colour, transparent black by default."""
        if programs_of(self._context).draws:
            self._framebuffer.clear(*color)

    def read(self, size: tuple[int, int]) -> bytes:
        """Return the first `size`, (w, h), of the pixels, row by row."""
        return bytes(self._framebuffer.read((0, 0, *size), 4, dtype=self.texture.dtype))

    def release(self) -> None:
        """Free the GPU objects."""
        release(self._framebuffer, self.texture)


def power_of_two(size: int) -> int:
    """Return the least power of two that is not below `size`."""
    return 1 << max(size - 1, 0).bit_length()
