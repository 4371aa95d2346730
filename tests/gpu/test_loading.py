"""A picture that takes a while to be sent to the GPU: shown by few texels at once, whole by and by."""

from collections.abc import Iterator
from dataclasses import replace

import moderngl
import numpy as np
import pytest
from numpy.typing import NDArray

from app.model.spaces import View
from app.render import gpu
from app.render.passes import draft
from app.render.scene import CanvasScene
from app.render.sources import source
from app.render.sources.source import Source, TextureLimits
from core.imaging.images import Image
from tests.gpu import scenes
from tests.gpu.surface import Surface

pytestmark = pytest.mark.gpu
WIDTH, HEIGHT = 240, 180


class Screen(Surface):
    """A framebuffer in the place of a window."""

    def __init__(self, frame_s: float) -> None:
        super().__init__((WIDTH, HEIGHT), frame_s)


@pytest.fixture
def screens() -> Iterator[tuple[Screen, Screen]]:
    opened = Screen(0.0), Screen(1e9)
    yield opened
    for one in opened:
        one.renderer.release()
        one.framebuffer.release()


@pytest.fixture
def writes(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return a list that the bytes sent to textures of four channels are added to."""
    sent: list[int] = []
    write = moderngl.Texture.write

    def counted(self: moderngl.Texture, data: np.ndarray, **options: object) -> None:
        if self.dtype == "f2":
            sent.append(data.nbytes)
        write(self, data, **options)  # type: ignore[arg-type]  # passes on what it is given

    monkeypatch.setattr(moderngl.Texture, "write", counted)
    return sent


def a_scene(image_size: tuple[int, int]) -> CanvasScene:
    rest = scenes.grid(*image_size, cells=20)
    zoom = 0.9 * min(WIDTH / image_size[0], HEIGHT / image_size[1])
    y, x = np.mgrid[: image_size[1], : image_size[0]] / 60.0
    waves = np.stack([np.sin(x + y), np.cos(x - y), np.sin(x) * np.cos(y)], axis=-1)
    image = Image((127 + 100 * waves).astype(np.uint8))
    return CanvasScene(image, rest, rest + 0.0, View(zoom, (4.0, 4.0), (WIDTH, HEIGHT)))


def test_a_large_picture_is_sent_over_several_frames(
    screens: tuple[Screen, Screen], writes: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(source, "PART_PIXELS", 1 << 14)
    monkeypatch.setattr(draft, "LOADING_S", 0.0)
    slow, fast = screens
    scene = a_scene((700, 500))
    best = fast.shot(scene)
    whole, writes[:] = sum(writes), []
    shots = []
    while True:
        sent = sum(writes)
        shots.append(slow.shot(scene))
        assert sum(writes) - sent < whole / 8
        if not slow.renderer.is_refining:
            break
        assert len(shots) < 200
    assert sum(writes) == whole
    assert len(shots) > 15
    assert np.array_equal(shots[-1], best)
    assert np.abs(shots[0].astype(int) - best).mean() < 8
    assert (best != best[0, 0]).any(axis=-1).mean() > 0.5


def test_motion_shows_few_texels_until_the_picture_is_there(
    screens: tuple[Screen, Screen], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(source, "PART_PIXELS", 1 << 14)
    monkeypatch.setattr(draft, "LOADING_S", 0.0)
    monkeypatch.setattr(source, "GLIMPSE_TEXELS", 1 << 8)
    slow, fast = screens
    scene = a_scene((700, 500))
    slow.shot(scene)
    best, off = fast.shot(scene), []
    for step in range(60):
        there = replace(scene, warped=scene.warped + 0.0001 * step, draft=True)
        off.append(np.abs(slow.shot(there).astype(int) - best).mean())
    assert off[0] > 2 * off[-1]
    assert off[-1] < 8


@pytest.mark.parametrize("size", [(700, 500), (3, 900), (900, 2)])
def test_few_texels_show_the_whole_picture_in_its_place(size: tuple[int, int], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(source, "GLIMPSE_TEXELS", 300)
    monkeypatch.setattr(source, "GLIMPSE_SIDE_PX", 100)
    image = scenes.picture(*size)
    held = Source(gpu.standalone(), image)
    window = held.glimpse(held.whole, 0)
    shown = np.frombuffer(window.texture.read(), np.float16).reshape(window.texture.height, window.texture.width, 4)
    assert shown.shape[0] * shown.shape[1] <= 300
    assert max(shown.shape) <= 100
    assert window.base_size == (shown.shape[1], shown.shape[0])
    assert window.box[2] >= size[0] - (1 << window.base)
    assert np.isfinite(shown).all()
    held.window(held.whole, 0)
    assert held.glimpse(held.whole, 0).base == 0
    held.release()


def test_a_window_that_cannot_be_had_is_loaded_once(writes: list[int]) -> None:
    image = scenes.picture(700, 500)
    held = Source(gpu.standalone(), image, limits=TextureLimits(budget_bytes=1_000_000))
    first = held.window((0, 0, 690, 490), 0)
    assert first.base > 0
    sent = sum(writes)
    assert held.window((0, 0, 690, 490), 0) is first
    assert sum(writes) == sent
    held.release()


def test_two_that_load_the_same_share_the_work(writes: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(source, "PART_PIXELS", 1 << 14)
    held = Source(gpu.standalone(), scenes.picture(700, 500))
    first, second = held.loading(held.whole, 0), held.loading((0, 0, 10, 10), 0)
    next(first)
    assert len(list(second)) > 10
    whole = sum(writes)
    assert not list(first)
    assert sum(writes) == whole
    assert held.glimpse(held.whole, 0).base == 0
    held.release()


def test_what_another_place_has_replaced_is_given_up() -> None:
    image = scenes.picture(900, 600)
    held = Source(gpu.standalone(), image, limits=TextureLimits(budget_bytes=1_000_000))
    first = held.loading((0, 0, 100, 100), 0)
    next(first)
    window = held.window((800, 500, 900, 600), 0)
    assert not list(first)
    assert held.glimpse((800, 500, 900, 600), 0) is window
    assert held.window((0, 0, 100, 100), 0).holds((0, 0, 100, 100), 0, 0)
    held.release()


def test_a_window_has_the_levels_that_are_asked_for() -> None:
    image = scenes.picture(900, 600)
    held = Source(gpu.standalone(), image, limits=TextureLimits(side_px=400))
    box = (102, 130, 302, 290)
    few = held.window(box, 0, 1)
    assert (few.box, few.top) == (box, 1)
    texels = base_level(few)
    assert held.window(box, 0, 0) is few
    assert held.holds(box, 0, 1)
    assert not held.holds(box, 0, 2)
    many = held.window(box, 0)
    assert many.top == held.levels
    left, top = box[0] - many.box[0], box[1] - many.box[1]
    assert np.array_equal(texels, base_level(many)[top : top + 160, left : left + 200])
    held.release()


def base_level(window: source.Window) -> NDArray[np.float16]:
    """Return the texels of the finest level of a window."""
    texture, (width, height) = window.texture, window.base_size
    return np.frombuffer(texture.read(), np.float16).reshape(texture.height, texture.width, 4)[:height, :width]
