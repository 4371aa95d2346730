"""Whether the driver has lost the window's OpenGL context: after a reset of the card, a suspended laptop, a new driver.

What was on the card is gone then, and every call does nothing. A context made with the hint below can be asked.
"""

import ctypes
from collections.abc import Callable

import glfw

NO_ERROR = 0
Status = Callable[[], int]


def ask_to_be_told() -> None:
    """Let the next window's context say when it is lost; a driver that cannot ignores it."""
    glfw.window_hint(glfw.CONTEXT_ROBUSTNESS, glfw.LOSE_CONTEXT_ON_RESET)


def reset_status() -> Status:
    """Return the current context's glGetGraphicsResetStatus; without it, a function that returns `NO_ERROR`."""
    for name in ("glGetGraphicsResetStatus", "glGetGraphicsResetStatusARB"):
        address = glfw.get_proc_address(name)
        if address:
            return ctypes.CFUNCTYPE(ctypes.c_uint)(ctypes.cast(address, ctypes.c_void_p).value or 0)
    return lambda: NO_ERROR
