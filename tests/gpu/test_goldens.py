"""Whole pictures, as somebody looked at them; `--regenerate-goldens` keeps new ones."""

from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np
import pytest

from app.model.spaces import View
from app.render import gpu
from app.render.renderer import Renderer
from app.render.scene import CanvasScene, MarkOptions
from core.arrays import Bytes
from core.imaging.images import Image
from core.rasters.raster import Raster
from tests.gpu import scenes

pytestmark = pytest.mark.gpu
WIDTH, HEIGHT = 300, 220
Compare = Callable[[str, Bytes], None]


def poster() -> Image:
    """Make a picture with lettering, thin lines and a transparent corner."""
    pixels = np.full((160, 220, 4), (236, 228, 208, 255), np.uint8)
    pixels[..., 2] = np.linspace(150, 230, 220)
    for x in range(6, 220, 12):
        cv2.line(pixels, (x, 0), (x, 159), (160, 60, 40, 255), 1, cv2.LINE_AA)
    cv2.circle(pixels, (110, 84), 46, (24, 70, 110, 255), -1, cv2.LINE_AA)
    cv2.putText(pixels, "WEFT", (66, 98), cv2.FONT_HERSHEY_DUPLEX, 1.1, (255, 240, 190, 255), 2, cv2.LINE_AA)
    corner = np.hypot(*np.indices((160, 220)))
    pixels[..., 3] = np.clip(corner * 6 - 160, 0, 255)
    return Image(pixels)


def the_scene() -> CanvasScene:
    image, rest = poster(), scenes.grid(220, 160, cells=28)
    x, y = np.moveaxis(rest, -1, 0)
    warped = rest + np.stack([14 * np.sin(y / 40), 16 * np.sin(x / 45)], axis=-1)
    mask = Raster.from_array(np.asarray(cv2.circle(np.zeros((160, 220), np.uint8), (110, 84), 48, 255, -1), np.uint8))
    view = View(1.15, (24.0, 18.0), (WIDTH, HEIGHT))
    return CanvasScene(image, rest, warped, view, frame=(-0.5, -0.5, 219.5, 159.5), mask=mask)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("canvas", {}),
        ("canvas_marks", {"marks": MarkOptions(grid=True, mask=True, outline=True)}),
        ("canvas_scale_split", {"marks": MarkOptions(heat="area", outline=True), "compare": "split"}),
        ("canvas_zoomed", {"view": View(4.0, (-240.0, -200.0), (WIDTH, HEIGHT)), "marks": MarkOptions(grid=True)}),
        ("canvas_small", {"view": View(0.31, (100.0, 80.0), (WIDTH, HEIGHT)), "marks": MarkOptions(outline=True)}),
    ],
)
def test_canvas_looks_as_it_did(name: str, changes: dict[str, object], golden: Compare) -> None:
    context = gpu.standalone()
    framebuffer = context.simple_framebuffer((WIDTH, HEIGHT), 4)
    framebuffer.use()
    renderer = Renderer(context)
    renderer.draw(replace(the_scene(), **changes), (0, 0, WIDTH, HEIGHT))  # type: ignore[arg-type]
    pixels = np.frombuffer(framebuffer.read(), np.uint8).reshape(HEIGHT, WIDTH, 3)[::-1]
    renderer.release()
    framebuffer.release()
    golden(name, pixels)
