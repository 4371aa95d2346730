"""Drafts: what a canvas that takes longer than a frame shows while something moves."""

from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np
import pytest

from app.model.spaces import View
from app.render.scene import Beneath, CanvasScene, MarkColours, MarkOptions
from core.arrays import Bytes, Ints, Points, Singles
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
        """Return what is seen of `scene` while all of it may move: it is another picture than the last."""
        self.rest(scene)
        return self.shot(replace(scene, image=Image(scene.image.pixels.copy()), draft=True))

    def rest(self, scene: CanvasScene) -> Bytes:
        """Return what is seen of `scene` at its best."""
        shot = self.shot(scene)
        while self.renderer.is_refining:
            shot = self.shot(scene)
        return shot

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


def test_a_draft_has_the_colour_of_each_feature(slow: Screen, fast: Screen) -> None:
    owners = np.ones((91, 131), np.uint8)
    owners[:, 98:] = 2
    palette = MarkColours(features=((1.0, 0.0, 0.0, 0.6), (0.0, 0.0, 1.0, 0.6)))
    scene = a_scene(marks=MarkOptions(mask=True), mask=half_mask(), owners=owners, palette=palette)
    draft, best = slow.draft(scene), fast.shot(scene)
    for colour, columns in ((0, slice(160, 200)), (2, slice(225, 260))):
        assert draft[60:160, columns, colour].mean() > draft[60:160, columns, 2 - colour].mean() + 80
    assert np.quantile(apart(draft, best), 0.9) <= 4


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


def fine(seed: int) -> Image:
    """Make a picture of blots of a few pixels, which a draft shows less sharp."""
    noise = np.random.default_rng(seed).normal(size=(180, 260, 3)).astype(np.float32)
    return Image(np.clip(128 + 500 * cv2.GaussianBlur(noise, (0, 0), 1.5), 0, 255).astype(np.uint8))


@pytest.mark.parametrize("compare", ["result", "split"])
def test_what_stands_still_stays_at_its_best_while_the_rest_moves(slow: Screen, compare: str) -> None:
    scene = a_scene(image=fine(1), compare=compare)
    best = slow.rest(scene)
    shift = np.zeros_like(scene.warped)
    shift[:, 100:, 1] = 5.0
    moved = replace(scene, warped=scene.warped + shift, draft=True)
    shot, all_draft = slow.shot(moved), slow.draft(replace(moved, draft=False))
    still = scene.warped[:, :99, 0].max() * 0.93 + 31.5 - 12
    assert np.array_equal(shot[:, : int(still)], best[:, : int(still)])
    assert (apart(best, all_draft)[:, : int(still)] > 20).mean() > 0.2
    right = np.s_[60:160, int(still) + 40 : 250]
    after = slow.rest(replace(moved, draft=False))
    assert (apart(shot, best)[right] > 20).mean() > 0.2
    assert apart(shot, after)[right].mean() < 0.3 * apart(all_draft, after)[right].mean(), "it is bent, not drawn anew"


def test_what_was_not_seen_before_is_drawn_anew(slow: Screen) -> None:
    scene = a_scene(image=fine(1), view=View(3.0, (-100.0, -80.0), (WIDTH, HEIGHT)))
    slow.rest(scene)
    moved = replace(scene, warped=scene.warped + [15.0, 0.0])
    assert np.array_equal(slow.shot(replace(moved, draft=True)), slow.draft(moved))


def test_folds_and_heat_follow_the_map_while_it_moves(slow: Screen) -> None:
    folded = np.zeros((90, 130), bool)
    folded[20:40, 20:40] = True
    for marks, folds in ((MarkOptions(folds=True), folded), (MarkOptions(heat="area"), np.zeros_like(folded))):
        scene = a_scene(marks=marks, folded=np.zeros_like(folded))
        slow.rest(scene)
        moved = replace(scene, warped=scene.warped + 9.0, folded=folds)
        assert np.array_equal(slow.shot(replace(moved, draft=True)), slow.draft(moved))


def test_what_was_regrown_is_bent_along_where_its_curve_is_dragged(slow: Screen) -> None:
    flat, source = a_scene().rest, a_scene(image=fine(1))
    y, x = np.moveaxis(flat[..., ::-1], -1, 0)
    held = np.sin(np.pi * (x + 0.5) / 260) * np.sin(np.pi * (y + 0.5) / 180)
    pulled = flat + 16 * held[..., None] * np.stack([np.sin(x / 40), np.cos(y / 50)], axis=-1)
    shown = replace(source, image=fine(2), warped=flat, beneath=Beneath(source.image, pulled))
    slow.rest(shown)
    further = flat + 1.8 * (pulled - flat)
    shot = slow.shot(replace(source, rest=further, warped=flat, draft=True))
    # The regrown picture of before is what the deformation so far takes back to places of the source.
    once = flat + cv2.remap((flat - pulled).astype(np.float32), *grid_places(further), cv2.INTER_LINEAR)
    for _ in range(30):
        there = cv2.remap((pulled - flat).astype(np.float32), *grid_places(once), cv2.INTER_LINEAR)
        once = further - there
    expected = slow.rest(replace(source, image=fine(2), rest=once, warped=flat))
    inside = np.s_[30:180, 45:255]
    assert apart(shot, expected)[inside].mean() < 0.5 * apart(shot, slow.rest(shown))[inside].mean()


def grid_places(places: Points) -> tuple[Singles, Singles]:
    """Return places of the picture as fractions of the grid's columns and rows."""
    share = ((places + 0.5) * (130 / 260, 90 / 180)).astype(np.float32)
    return share[..., 0], share[..., 1]


def test_a_draft_lies_where_the_picture_at_its_best_does(slow: Screen) -> None:
    pixels = np.repeat(np.clip(4 * np.arange(260) - 400, 0, 255)[None, :, None], 180, axis=0).repeat(3, axis=2)
    flat = a_scene().rest
    scene = a_scene(
        image=Image(pixels.astype(np.uint8)), rest=flat, warped=flat, view=View(1.0, (7.9, 5.4), (WIDTH, HEIGHT))
    )
    best, draft = slow.rest(scene)[60:120, 125:160].astype(float), slow.draft(scene)[60:120, 125:160]
    assert abs((best - draft).mean()) / 4.0 < 0.1  # px, on a slope of four levels each


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
