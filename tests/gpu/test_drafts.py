"""Drafts: what a canvas that takes longer than a frame shows while something moves."""

from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np
import pytest

from app.model.spaces import View
from app.render.scene import CanvasScene, MarkOptions
from core.arrays import Bytes, Ints
from core.imaging.images import Image
from core.rasters.raster import Raster
from tests.gpu import scenes
from tests.gpu.surface import Surface

pytestmark = pytest.mark.gpu
WIDTH, HEIGHT = 300, 220


class Screen(Surface):
    """A framebuffer in the place of a window, and a renderer that is given so many seconds a frame."""

    def __init__(self, frame_s: float) -> None:
        super().__init__((WIDTH, HEIGHT), frame_s)

    def shot(self, scene: CanvasScene) -> Bytes:
        """Draw one frame and return what is seen, (h, w, 3), the top row first."""
        return super().shot(scene)[::-1]

    def draft(self, scene: CanvasScene) -> Bytes:
        """Return what is seen of `scene` while it moves."""
        self.shot(scene)
        while self.renderer.is_refining:
            self.shot(scene)
        return self.shot(replace(scene, warped=scene.warped + 0.0, draft=True))

    def close(self) -> None:
        self.renderer.release()
        self.framebuffer.release()


@pytest.fixture
def slow() -> Iterator[Screen]:
    screen = Screen(0.0)
    yield screen
    screen.close()


@pytest.fixture
def fast() -> Iterator[Screen]:
    screen = Screen(1e9)
    yield screen
    screen.close()


def a_scene(**changes: object) -> CanvasScene:
    rest = scenes.grid(260, 180, cells=130)
    view = View(0.93, (31.5, 22.5), (WIDTH, HEIGHT))
    frame = (-0.5, -0.5, 259.5, 179.5)
    scene = CanvasScene(Image(smooth(3)), rest, scenes.wavy(rest), view, frame=frame)
    return replace(scene, **changes)  # type: ignore[arg-type]


def smooth(channels: int) -> Bytes:
    """Make pixels (180, 260, channels) without details that a draft would lose."""
    y, x = np.mgrid[:180, :260] / 40.0
    waves = [0.5 + 0.4 * np.sin(x + c) * np.cos(y - c) for c in range(channels)]
    return (255 * np.stack(waves, axis=-1)).astype(np.uint8)


def apart(a: Bytes, b: Bytes) -> Ints:
    """Return by how many levels two pictures differ, (h, w)."""
    return np.asarray(np.abs(a.astype(int) - b).max(axis=-1))


def half_mask() -> Raster:
    mask = np.zeros((180, 260), np.uint8)
    mask[:, 130:] = 255
    return Raster.from_array(mask)


@pytest.mark.parametrize("compare", ["result", "before", "split"])
def test_a_draft_looks_like_the_picture_with_its_marks(slow: Screen, fast: Screen, compare: str) -> None:
    folded = np.zeros((90, 130), bool)
    folded[20:40, 20:40] = True
    scene = a_scene(marks=MarkOptions(mask=True, folds=True), mask=half_mask(), folded=folded, compare=compare)
    draft, best = slow.draft(scene), fast.shot(scene)
    assert np.quantile(apart(draft, best), 0.9) <= 4
    unmarked = fast.shot(replace(scene, marks=MarkOptions()))
    marked = apart(best, unmarked) > 30
    if compare != "before":
        assert marked.sum() > 3000
        assert (apart(draft, unmarked) > 30)[marked].mean() > 0.95


def test_a_draft_lets_what_is_behind_a_transparent_picture_through(slow: Screen, fast: Screen) -> None:
    pixels = np.concatenate([smooth(3), np.full((180, 260, 1), 90, np.uint8)], axis=-1)
    pixels[:, :130, 3] = 255
    scene = a_scene(image=Image(pixels))
    draft, best = slow.draft(scene), fast.shot(scene)
    assert np.median(apart(draft, best)) <= 4
    opaque = fast.shot(a_scene(image=Image(pixels[..., :3])))
    assert np.median(apart(best, opaque)[60:160, 170:250]) > 30


def test_a_draft_has_the_grid_and_the_scale_that_are_switched_on(slow: Screen) -> None:
    scene = a_scene(warped=1.3 * a_scene().warped)
    plain = slow.draft(scene)
    for marks in (MarkOptions(grid=True), MarkOptions(heat="area"), MarkOptions(outline=True)):
        assert (apart(slow.draft(replace(scene, marks=marks)), plain) > 20).sum() > 300


def test_nothing_of_an_earlier_place_is_left(slow: Screen, fast: Screen) -> None:
    scene = a_scene(frame=None)
    slow.draft(scene)
    for x in (60.0, -60.0, 0.0):
        moved = replace(scene, warped=0.5 * scene.warped + [x + 60.0, 40.0], draft=True)
        draft, best = slow.shot(moved), fast.shot(replace(moved, draft=False))
        desk = (best == best[0, 0]).all(axis=-1)
        away = cv2.erode(desk.astype(np.uint8), np.ones((17, 17))) > 0
        assert away.sum() > WIDTH * HEIGHT / 3
        assert not apart(draft, best)[away].any()
        assert apart(draft, best).mean() < 6


def test_what_leaves_the_frame_and_the_window_is_drawn(slow: Screen, fast: Screen) -> None:
    scene = a_scene()
    far = replace(scene, warped=2.0 * scene.warped - [200.0, 120.0])
    best = fast.shot(far)
    assert np.quantile(apart(slow.draft(far), best), 0.9) <= 8
    assert not (best == best[0, 0]).all(axis=-1)[:, :20].all()


@pytest.mark.parametrize("zoom", [0.4, 1.0])
def test_bounds_hold_all_but_desk(fast: Screen, zoom: float) -> None:
    scene = a_scene(marks=MarkOptions(outline=True), view=View(zoom, (40.0, 30.0), (WIDTH, HEIGHT)))
    left, top, right, bottom = scene.bounds((WIDTH, HEIGHT))
    shot = fast.shot(scene)
    desk = (255 * np.asarray(scene.palette.desk[:3]) + 0.5).astype(np.uint8)
    outside = np.ones((HEIGHT, WIDTH), bool)
    outside[top:bottom, left:right] = False
    assert (shot[outside] == desk).all()
    rows, columns = np.nonzero((shot != desk).any(axis=-1))
    assert top <= rows.min() <= top + 5
    assert left <= columns.min() <= left + 5
