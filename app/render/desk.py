"""The desk that the picture lies on, and the checks that show through it (canvas.glsl)."""

from functools import cache

import numpy as np

from app.render.scene import CanvasScene, Color
from core.imaging import color

CHECK_PX = 8.0
NO_FRAME = (0.0, 0.0, 0.0, 0.0)


def desk_uniforms(scene: CanvasScene) -> dict[str, object]:
    """Return the uniforms of canvas.glsl."""
    frame = NO_FRAME
    if scene.frame is not None:
        left, top, right, bottom = (scene.in_framebuffer(np.reshape(scene.frame, (2, 2))) + 0.5).ravel()
        frame = float(left), float(top), float(right), float(bottom)
    dark, light = scene.palette.checks
    return {
        "frame": frame,
        "check_px": CHECK_PX * scene.pixel_ratio / scene.shrink,
        "desk": _linear(scene.palette.desk),
        "check_dark": _linear(dark),
        "check_light": _linear(light),
    }


@cache
def _linear(shade: Color) -> tuple[float, float, float]:
    red, green, blue = color.decode(np.asarray(shade[:3], np.float32)).tolist()
    return red, green, blue
