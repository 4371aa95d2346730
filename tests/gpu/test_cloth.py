"""A texture laid on cloth by the shader, against core.overlay.composition."""

from dataclasses import dataclass

import numpy as np
import pytest

from app.model.spaces import View
from app.render import gpu
from app.render.renderer import Renderer
from app.render.scene import CanvasScene
from app.render.sources.cloth import DressedSource
from app.render.sources.overlay_parameters import OverlayParameters
from core.arrays import Floats, Singles
from core.imaging import color
from core.imaging.images import Image
from core.overlay.composition import Placement, compose, middle_of
from core.overlay.laying.compositing import encode
from tests.gpu import scenes

pytestmark = pytest.mark.gpu
WIDTH, HEIGHT = 150, 120


@dataclass(frozen=True, eq=False)
class Cloth:
    uv: Singles
    shading: Singles
    detail: Singles
    coverage: Singles
    basis: Floats

    @property
    def middle(self) -> Floats:
        return middle_of(self.uv)


def cloth() -> Cloth:
    """Fold a cloth of texels of 20 x 16 pixels, with a hole and a soft edge."""
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(float)
    u = x / 20 + 0.6 * np.sin(y / 17) + 0.35 * np.sin(x / 6)
    v = y / 16 + 0.3 * np.cos(x / 13)
    uv = np.stack([u, v], axis=-1).astype(np.float32)
    shading = (0.7 + 0.3 * np.sin(x / 11 + y / 15)).astype(np.float32)
    detail = np.random.default_rng(1).normal(0, 0.02, (HEIGHT, WIDTH, 3)).astype(np.float32)
    coverage = np.clip((x - 10) / 8, 0, 1).astype(np.float32)
    outside = (x < 10) | (np.hypot(x - 90, y - 60) < 14)
    coverage[outside] = 0
    for part in (uv, shading, detail):
        part[outside] = np.nan
    return Cloth(uv, shading, detail, coverage, np.diag([20.0, 16.0]))


def on_processor(photo: Image, overlay: OverlayParameters) -> Floats:
    """Return the colours (H, W, 3) that the processor's composition gives, encoded."""
    parts, texture = overlay.parts, overlay.texture
    colours = encode(texture).astype(np.float64)
    if texture.has_alpha:
        colours = np.concatenate([colours, color.unit(texture.pixels[..., -1:])], axis=-1)
    new, opacity = compose(
        colours,
        parts.uv.astype(float),
        parts.shading.astype(float),
        parts.detail.astype(float),
        parts.basis,
        placement=overlay.placement,
        alpha=overlay.detail,
        strength=overlay.shading,
    )
    share = (opacity * parts.coverage)[..., None]
    return np.clip(share * new + (1 - share) * encode(photo), 0, 1)


def on_gpu(photo: Image, overlay: OverlayParameters) -> Floats:
    source = DressedSource(gpu.standalone(), photo, overlay.parts)
    source.dress(overlay)
    window = source.window(source.whole, 0)
    data = np.frombuffer(window.texture.read(), np.float16).reshape(window.texture.height, window.texture.width, 4)
    light = data[:HEIGHT, :WIDTH].astype(np.float32)
    source.release()
    return color.encode(light[..., :3]).astype(float)


@pytest.mark.parametrize(
    ("channels", "overlay"),
    [
        (3, {}),
        (3, {"detail": 0.4, "shading": 1.6}),
        (4, {"placement": Placement((0.5, 0.7), 30.0, (0.2, -0.4))}),
        (3, {"placement": Placement((1.3, 0.8), mirror=True)}),
        (4, {"placement": Placement((0.2, 0.2), -12.0, tile=False)}),
        (3, {"placement": Placement((0.4, 0.6), 20.0, upright=True)}),
    ],
)
def test_shader_and_processor_agree(channels: int, overlay: dict[str, object]) -> None:
    photo = scenes.picture(WIDTH, HEIGHT, 3, seed=5)
    texture = scenes.picture(40, 34, channels, seed=6)
    worn = OverlayParameters(cloth(), texture, **overlay)  # type: ignore[arg-type]  # the parameters above
    seen, expected = on_gpu(photo, worn), on_processor(photo, worn)
    assert np.abs(expected - encode(photo)).max() > 0.3
    difference = np.abs(seen - expected).max(axis=-1)
    assert difference.max() < 0.5 / 255


def test_canvas_shows_the_dressed_photo_and_follows_the_slider() -> None:
    photo, texture, parts = scenes.picture(WIDTH, HEIGHT, 3, seed=5), scenes.picture(40, 34, 3, seed=6), cloth()
    rest = scenes.grid(WIDTH, HEIGHT)
    context = gpu.standalone()
    framebuffer = context.simple_framebuffer((WIDTH, HEIGHT), 4)
    framebuffer.use()
    renderer = Renderer(context)
    view = View(1.0, (0.5, 0.5), (WIDTH, HEIGHT))
    shots = []
    for detail in (1.0, 0.0):
        worn = OverlayParameters(parts, texture, detail=detail)
        renderer.draw(CanvasScene(photo, rest, rest, view, overlay=worn), (0, 0, WIDTH, HEIGHT))
        shot = np.frombuffer(framebuffer.read(), np.uint8).reshape(HEIGHT, WIDTH, 3)[::-1]
        assert np.abs(shot / 255 - on_gpu(photo, worn)).max() <= 1.1 / 255
        shots.append(shot)
    assert (shots[0] != shots[1]).any()
    renderer.release()
    framebuffer.release()


def test_window_grows_with_the_view() -> None:
    photo, worn = (
        scenes.picture(WIDTH, HEIGHT, 3, seed=5),
        OverlayParameters(cloth(), scenes.picture(40, 34, 3, seed=6)),
    )
    source = DressedSource(gpu.standalone(), photo, worn.parts)
    source.dress(worn)
    small = source.window((40, 40, 60, 60), 0)
    width = small.texture.width
    whole = source.window(source.whole, 0)
    assert whole.texture.width > width
    data = np.frombuffer(whole.texture.read(), np.float16).reshape(whole.texture.height, whole.texture.width, 4)
    shown = color.encode(data[:HEIGHT, :WIDTH, :3].astype(np.float32))
    assert np.abs(shown - on_gpu(photo, worn)).max() < 1 / 255
    source.release()
