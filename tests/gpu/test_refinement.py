"""A canvas that takes longer than a frame: drafts while it moves, the best picture by and by when it rests."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import moderngl
import numpy as np
import pytest

from app.model.spaces import View
from app.render.scene import CanvasScene, MarkOptions
from core import tracing
from core.arrays import Bytes
from core.imaging.images import Image
from core.rasters.raster import Raster
from tests.gpu import scenes
from tests.gpu.surface import Surface

pytestmark = pytest.mark.gpu
WIDTH, HEIGHT = 300, 220
MOST_FRAMES = 100


class Screen(Surface):
    """A framebuffer in the place of a window, whose renderer may take `frame_s` of a frame."""

    def __init__(self, frame_s: float) -> None:
        super().__init__((WIDTH, HEIGHT), frame_s)

    def rest(self, scene: CanvasScene) -> list[Bytes]:
        """Draw frames until nothing gets better."""
        shots = [self.shot(scene)]
        while self.renderer.is_refining:
            shots.append(self.shot(scene))
            assert len(shots) < MOST_FRAMES
        return shots

    def close(self) -> None:
        self.renderer.release()
        self.framebuffer.release()


@pytest.fixture
def screen() -> Iterator[Callable[[float], Screen]]:
    opened: list[Screen] = []

    def open_one(frame_s: float) -> Screen:
        opened.append(Screen(frame_s))
        return opened[-1]

    yield open_one
    for one in opened:
        one.close()


@pytest.fixture
def slow(screen: Callable[[float], Screen]) -> Screen:
    return screen(0.0)


@pytest.fixture
def fast(screen: Callable[[float], Screen]) -> Screen:
    return screen(1e9)


def a_scene(**changes: object) -> CanvasScene:
    rest = scenes.grid(260, 180, cells=130)
    view = View(1.07, (11.5, 12.5), (WIDTH, HEIGHT))
    frame = (-0.5, -0.5, 259.5, 179.5)
    scene = CanvasScene(
        scenes.picture(260, 180), rest, scenes.wavy(rest), view, frame=frame, marks=MarkOptions(outline=True)
    )
    return replace(scene, **changes)  # type: ignore[arg-type]


def moved(scene: CanvasScene, x: float) -> CanvasScene:
    return replace(scene, warped=scene.warped + [x, 0.0])


def drawn_vertices(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return a list that the numbers of vertices of everything that is rendered from now on are added to."""
    counts: list[int] = []
    render = moderngl.VertexArray.render

    def counted(self: moderngl.VertexArray, *arguments: object, **options: int) -> None:
        counts.append(options["vertices"])
        render(self, *arguments, **options)  # type: ignore[arg-type]  # passes on what it is given

    monkeypatch.setattr(moderngl.VertexArray, "render", counted)
    return counts


def test_a_slow_canvas_gets_better_over_several_frames_to_the_very_picture(slow: Screen, fast: Screen) -> None:
    scene = a_scene()
    shots, best = slow.rest(scene), fast.shot(scene)
    assert len(shots) > 4
    assert np.array_equal(shots[-1], best)
    assert (shots[0] != best).any()
    assert not fast.renderer.is_refining


def test_the_first_picture_is_a_draft_before_there_is_room_for_the_best(
    slow: Screen, fast: Screen, monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes: list[tuple[int, int]] = []
    make = moderngl.Context.texture

    def noted(self: moderngl.Context, size: tuple[int, int], *arguments: object, **options: object) -> moderngl.Texture:
        sizes.append(size)
        return make(self, size, *arguments, **options)  # type: ignore[arg-type]  # passes on what it is given

    monkeypatch.setattr(moderngl.Context, "texture", noted)
    scene = a_scene()
    first = slow.shot(scene)
    assert (WIDTH, HEIGHT) not in sizes
    assert slow.renderer.is_refining
    best = slow.rest(scene)[-1]
    assert (WIDTH, HEIGHT) in sizes
    assert 0 < np.abs(first.astype(int) - best).mean() < 12
    assert np.array_equal(fast.shot(scene), best)


def test_no_piece_of_the_picture_is_left_out(slow: Screen) -> None:
    scene = a_scene(marks=MarkOptions())
    view = View(1.0, (20.5, 20.5), (WIDTH, HEIGHT))
    shown = slow.rest(replace(scene, warped=scene.rest, view=view))[-1][::-1]
    assert np.array_equal(shown[20:200, 20:280], scene.image.pixels)


def test_a_draft_has_fewer_vertices_and_the_same_shape(
    slow: Screen, fast: Screen, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = a_scene()
    slow.rest(scene)
    counts = drawn_vertices(monkeypatch)
    draft = slow.shot(replace(moved(scene, 9.0), image=Image(scene.image.pixels.copy()), draft=True))
    of_draft, counts[:] = sum(counts), []
    best = fast.shot(moved(scene, 9.0))
    assert of_draft < sum(counts) / 4
    apart = np.abs(draft.astype(int) - best).mean()
    assert apart < np.abs(draft.astype(int) - slow.shot(replace(moved(scene, 6.0), draft=True))).mean()
    assert apart < 12


def test_a_fast_canvas_has_no_drafts(fast: Screen) -> None:
    scene = a_scene()
    best = fast.shot(scene)
    assert np.array_equal(fast.shot(replace(moved(scene, 9.0), draft=True)), fast.shot(moved(scene, 9.0)))
    assert not fast.renderer.is_refining
    assert np.array_equal(fast.shot(scene), best)


def test_a_canvas_that_fits_into_a_frame_is_drawn_in_few_passes_and_just_the_same(
    fast: Screen, slow: Screen, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, counts = a_scene(), drawn_vertices(monkeypatch)
    fast.shot(scene)
    in_pieces, counts[:] = len(counts), []
    shown = fast.shot(moved(scene, 9))
    assert len(counts) < 0.6 * in_pieces
    assert np.array_equal(shown, slow.rest(moved(scene, 9))[-1])


def test_motion_drops_what_is_not_finished(slow: Screen, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = a_scene()
    slow.rest(moved(scene, 4.0))
    frames = len(slow.rest(scene))
    slow.shot(moved(scene, 5.0))
    assert slow.renderer.is_refining
    there = moved(scene, 6.0)
    slow.shot(replace(there, draft=True))
    assert not slow.renderer.is_refining
    counts = drawn_vertices(monkeypatch)
    slow.shot(replace(there, draft=True))
    assert len(counts) == 2  # what is there is copied to the window: what stands still and what moves
    assert len(slow.rest(there)) == frames


def test_the_same_picture_is_not_drawn_twice_after_a_draft(slow: Screen) -> None:
    scene = a_scene()
    best = slow.rest(scene)[-1]
    slow.shot(replace(moved(scene, 5.0), draft=True))
    slow.shot(moved(scene, 5.0))
    again = slow.rest(scene)
    assert len(again) == 1
    assert np.array_equal(again[0], best)


def test_the_last_picture_stays_until_its_successor_is_whole(slow: Screen, fast: Screen) -> None:
    scene = a_scene()
    before = slow.rest(scene)[-1]
    shots = slow.rest(moved(scene, 0.7))
    assert len(shots) > 4
    assert all(np.array_equal(shot, before) for shot in shots[:-1])
    assert np.array_equal(shots[-1], fast.shot(moved(scene, 0.7)))


def test_what_moves_is_shown_before_time_goes_into_making_it_better(slow: Screen) -> None:
    slow.rest(a_scene())
    tracing.start()
    slow.shot(moved(a_scene(), 9.0))
    assert [event["name"] for event in tracing.events() if event["name"] in ("bend", "draft", "refine")] in (
        ["bend", "refine"],
        ["draft", "refine"],
    )


def test_another_view_does_not_wait_for_its_best(slow: Screen) -> None:
    scene = a_scene()
    before = slow.rest(scene)[-1]
    first, *_, best = slow.rest(replace(scene, view=View(1.6, (-40.0, -30.0), (WIDTH, HEIGHT))))
    assert np.abs(first.astype(int) - best).mean() < np.abs(first.astype(int) - before).mean() / 2


def test_what_is_painted_meanwhile_shows_at_once_and_at_the_end(slow: Screen, fast: Screen) -> None:
    scene = a_scene(marks=MarkOptions(mask=True), mask=Raster.filled(260, 180))
    slow.rest(scene)
    scene = moved(scene, 5.0)
    plain = slow.shot(replace(scene, draft=True))
    slow.shot(scene)
    painted = replace(scene, mask=Raster.filled(260, 180, 255))
    shots = slow.rest(painted)
    assert (shots[0][40:-40, 40:-40, 0].astype(int) - plain[40:-40, 40:-40, 0]).mean() > 20
    assert len(shots) > 2
    assert np.array_equal(shots[-1], fast.shot(painted))


def test_a_draft_does_not_mix_in_the_opposite_edge(slow: Screen) -> None:
    half = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    half[:, : WIDTH // 2] = 255
    rest = scenes.grid(WIDTH, HEIGHT, cells=20)
    view = View(1.2, (-30.0, -22.0), (WIDTH, HEIGHT))
    scene = CanvasScene(Image(half), rest, rest, view)
    slow.rest(scene)
    shot = slow.shot(replace(scene, view=replace(view, pan=(-31.0, -22.0)), draft=True))
    assert (shot[:, 0] == 255).all()
    assert not shot[:, -1].any()
