"""The window's canvas: agrees with the export, shows its marks, redraws what changed."""

from collections.abc import Iterator
from dataclasses import replace

import moderngl
import numpy as np
import pytest

from app.model.spaces import View
from app.render import gpu
from app.render.export import render_mesh
from app.render.nodes import Scaling
from app.render.passes.mesh import MeshBuffers
from app.render.renderer import Renderer
from app.render.scene import CanvasScene, MarkColours, MarkOptions
from core.arrays import Bytes, Points
from core.imaging import color
from core.imaging.images import Image
from core.rasters.raster import Raster
from tests.gpu import scenes

pytestmark = pytest.mark.gpu
WIDTH, HEIGHT = 180, 140


class Screen:
    """A framebuffer in the place of a window."""

    def __init__(self) -> None:
        context = gpu.standalone()
        self.framebuffer = context.simple_framebuffer((WIDTH, HEIGHT), 4)
        self.renderer = Renderer(context)

    def shot(self, scene: CanvasScene, viewport: tuple[int, int, int, int] = (0, 0, WIDTH, HEIGHT)) -> Bytes:
        """Draw and return what is seen, (h, w, 3), the top row first."""
        self.framebuffer.use()
        self.renderer.draw(scene, viewport)
        return np.frombuffer(self.framebuffer.read(), np.uint8).reshape(HEIGHT, WIDTH, 3)[::-1]


@pytest.fixture
def screen() -> Iterator[Screen]:
    screen = Screen()
    yield screen
    screen.renderer.release()
    screen.framebuffer.release()


def a_scene(channels: int = 3, **changes: object) -> CanvasScene:
    image = scenes.picture(150, 110, channels)
    rest = scenes.grid(150, 110, cells=30)
    view = View(1.0, (15.5, 12.5), (WIDTH, HEIGHT))
    return replace(CanvasScene(image, rest, scenes.wavy(rest), view), **changes)  # type: ignore[arg-type]


def in_light(image: Image) -> Image:
    """Return `image` as float RGB or RGBA, so that rounding to 8 bits happens once, after it lies on the desk."""
    light = color.linear_light(image.pixels, linear=False)
    colors = light if image.channels >= 3 else light[..., [0, 0, 0]]
    return Image(np.ascontiguousarray(colors), linear=True)


def over_desk(image: Image, palette: MarkColours) -> Bytes:
    """Return what float `image` looks like on the desk."""
    light = color.premultiply(image.pixels)
    desk = color.decode(np.array(palette.desk[:3], np.float32))
    alpha = light[..., 3:] if image.has_alpha else np.float32(1)
    return color.quantise(color.encode(light[..., :3] + (1 - alpha) * desk), np.uint8)


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("zoom", [1.0, 0.41, 1.7])
def test_preview_agrees_with_export(screen: Screen, channels: int, zoom: float) -> None:
    scene = a_scene(channels)
    scene = replace(scene, view=View(zoom, (15.0 + zoom / 2, 12.0 + zoom / 2), (WIDTH, HEIGHT)))
    shown = screen.shot(scene)
    origin = (-15 / zoom, -12 / zoom)
    result = render_mesh(
        in_light(scene.image), scene.rest, scene.warped, size=(WIDTH, HEIGHT), origin=origin, scale=zoom
    )
    difference = np.abs(over_desk(result, scene.palette).astype(int) - shown)
    assert difference.max() <= 1
    assert shown.std() > 20


def test_hundred_percent_shows_the_pixels_of_the_file(screen: Screen) -> None:
    scene = a_scene()
    shown = screen.shot(replace(scene, warped=scene.rest, view=View(1.0, (15.8, 12.1), (WIDTH, HEIGHT))))
    assert np.array_equal(shown[12:122, 15:165], scene.image.pixels)


def test_before_and_split(screen: Screen) -> None:
    scene = a_scene(marks=MarkOptions(grid=True, outline=True))
    result = screen.shot(scene)
    before = screen.shot(replace(scene, compare="before"))
    split = screen.shot(replace(scene, compare="split", split=0.4))
    column = round(0.4 * WIDTH)
    assert np.array_equal(before[12:122, 15:165], scene.image.pixels)
    assert np.array_equal(split[:, :column], before[:, :column])
    assert np.array_equal(split[:, column:], result[:, column:])


def test_mask_tints_where_it_is_painted_and_nowhere_else(screen: Screen) -> None:
    scene = a_scene(marks=MarkOptions(mask=True))
    values = np.zeros((110, 150), np.uint8)
    mask = Raster.from_array(values)
    plain = screen.shot(replace(scene, warped=scene.rest, mask=mask))
    painted = mask.edited((40, 30, 70, 60), lambda tile, box: painted_square(tile))
    tinted = screen.shot(replace(scene, warped=scene.rest, mask=painted))
    changed = (plain != tinted).any(axis=-1)
    assert changed[12 + 32 : 12 + 58, 15 + 42 : 15 + 68].all()
    changed[12 + 29 : 12 + 61, 15 + 39 : 15 + 71] = False
    assert not changed.any()
    share = scene.palette.mask[3]
    expected = (1 - share) * plain[60, 70] + share * 255 * np.array(scene.palette.mask[:3])
    assert np.abs(expected - tinted[60, 70]).max() <= 1


def painted_square(tile: Bytes) -> Bytes:
    tile = tile.copy()
    tile[30:60, 40:70] = 255
    return tile


def test_a_stroke_composes_only_where_it_is(screen: Screen, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = a_scene(
        marks=MarkOptions(mask=True, folds=True), image=scenes.picture(600, 440), rest=scenes.grid(600, 440)
    )
    scene = replace(scene, warped=scenes.wavy(scene.rest), view=View(0.25, (15.0, 12.0), (WIDTH, HEIGHT)))
    cells = np.zeros((scene.rest.shape[0] - 1, scene.rest.shape[1] - 1), bool)
    scene = replace(scene, mask=Raster.filled(600, 440), folded=cells)
    composed: list[gpu.Rectangle | None] = []
    drawing = gpu.Offscreen.drawing

    def noted(self: gpu.Offscreen, viewport: object = None, scissor: gpu.Rectangle | None = None) -> object:
        composed.append(scissor)
        return drawing(self, None, scissor)

    assert scene.mask is not None
    painted = replace(scene, mask=scene.mask.edited((140, 130, 170, 160), lambda tile, box: painted_square(tile)))
    cells = cells.copy()
    cells[-1, -1] = True
    for before, stroke in ((scene, painted), (painted, replace(painted, folded=cells))):
        plain = screen.shot(before)
        with monkeypatch.context() as watched:
            watched.setattr(gpu.Offscreen, "drawing", noted)
            shown = screen.shot(stroke)
        assert np.array_equal(shown, screen.shot(replace(stroke, palette=MarkColours(grid=(0.0, 0.0, 0.0, 0.0)))))
        assert (shown != plain).any()
        part = composed.pop()
        assert part is not None
        assert part[2] * part[3] < 0.3 * WIDTH * HEIGHT


def test_a_frame_that_is_dragged_is_composed_only_where_it_ends(
    screen: Screen, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = a_scene(mask=Raster.filled(150, 110), frame=(-0.5, -0.5, 119.5, 89.5))
    composed: list[gpu.Rectangle | None] = []
    drawing = gpu.Offscreen.drawing

    def noted(self: gpu.Offscreen, viewport: object = None, scissor: gpu.Rectangle | None = None) -> object:
        composed.append(scissor)
        return drawing(self, None, scissor)

    screen.shot(whole)
    for right, bottom in ((109.5, 89.5), (159.5, 89.5), (159.5, 69.5), (159.5, 125.5), (119.5, 89.5)):
        scene = replace(whole, frame=(-0.5, -0.5, right, bottom))
        with monkeypatch.context() as watched:
            watched.setattr(gpu.Offscreen, "drawing", noted)
            shown = screen.shot(scene)
        area = sum(part[2] * part[3] for part in composed if part is not None)
        assert area < 0.5 * WIDTH * HEIGHT or (right, bottom) == (119.5, 89.5)
        composed.clear()
        fresh = Screen()
        assert np.array_equal(shown, fresh.shot(scene))
        fresh.renderer.release()
        fresh.framebuffer.release()


def test_folded_cells_are_marked(screen: Screen) -> None:
    scene = a_scene(marks=MarkOptions(folds=True))
    folded = np.zeros((scene.rest.shape[0] - 1, scene.rest.shape[1] - 1), bool)
    plain = screen.shot(replace(scene, warped=scene.rest, folded=folded))
    folded = folded.copy()
    folded[4, 6] = True
    marked = screen.shot(replace(scene, warped=scene.rest, folded=folded))
    ys, xs = np.nonzero((plain != marked).any(axis=-1))
    low, high = scene.rest[4, 6] + [15, 12], scene.rest[5, 7] + [15, 12]
    assert abs(xs.min() - low[0]) <= 1
    assert abs(xs.max() - high[0]) <= 1
    assert abs(ys.min() - low[1]) <= 1
    assert abs(ys.max() - high[1]) <= 1


def test_scale_is_shown_by_colour(screen: Screen) -> None:
    scene = a_scene(marks=MarkOptions(heat="area"))
    middle = scene.rest.mean(axis=(0, 1))
    grown = screen.shot(replace(scene, warped=middle + 1.6 * (scene.rest - middle)))[70, 90].astype(int)
    shrunk = screen.shot(replace(scene, warped=middle + 0.6 * (scene.rest - middle)))[70, 90].astype(int)
    assert grown[0] - grown[2] > shrunk[0] - shrunk[2] + 60


def test_grid_lines_run_through_nodes(screen: Screen) -> None:
    scene = a_scene(marks=MarkOptions(grid=True), palette=MarkColours(grid=(0.0, 1.0, 0.0, 1.0)))
    scene = replace(scene, view=View(4.0, (-100.0, -80.0), (WIDTH, HEIGHT)))
    shown = screen.shot(scene)
    nodes = (scene.warped * 4.0 + [-100.0, -80.0]).reshape(-1, 2)
    inside = ((nodes > 3) & (nodes < [WIDTH - 3, HEIGHT - 3])).all(axis=1)
    x, y = np.floor(nodes[inside]).astype(int).T
    assert inside.sum() > 20
    assert (shown[y, x, 1].astype(int) - shown[y, x, 0] > 100).mean() > 0.9


def test_only_its_viewport_and_state_are_touched(screen: Screen) -> None:
    context = gpu.standalone()
    screen.framebuffer.use()
    screen.framebuffer.clear(0.5, 0.5, 0.5)
    assert context.error  # forgets what was noted before
    context.viewport = (3, 4, 50, 60)
    screen.renderer.draw(a_scene(), (20, 10, 100, 90))
    assert context.viewport == (3, 4, 50, 60)
    assert context.detect_framebuffer().glo == screen.framebuffer.glo
    seen = np.frombuffer(screen.framebuffer.read(), np.uint8).reshape(HEIGHT, WIDTH, 3)
    touched = (seen != seen[0, 0]).any(axis=-1)
    assert touched[10:100, 20:120].mean() > 0.9
    touched[10:100, 20:120] = False
    assert not touched.any()
    assert context.error == "GL_NO_ERROR"


def test_what_did_not_change_is_not_drawn_again(screen: Screen, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[str] = []
    render = moderngl.VertexArray.render

    def counted(self: moderngl.VertexArray, *arguments: object, **options: object) -> None:
        drawn.append("array")
        render(self, *arguments, **options)  # type: ignore[arg-type]  # passes on what it is given

    monkeypatch.setattr(moderngl.VertexArray, "render", counted)
    scene = a_scene(marks=MarkOptions(mask=True), mask=Raster.filled(150, 110))
    first = screen.shot(scene)
    full, drawn[:] = len(drawn), []
    assert np.array_equal(screen.shot(replace(scene)), first)
    again, drawn[:] = len(drawn), []
    screen.shot(replace(scene, mask=Raster.filled(150, 110, 255)))
    assert again == 1
    assert again < len(drawn) < full


def test_thumbnails_are_small_drafts_of_exports(screen: Screen) -> None:
    scene = a_scene(4)
    moved = scene.rest * [1, 0.5]
    wide, flat = screen.renderer.thumbnails(scene.image, scene.rest, [scene.rest, moved], (60, 44))
    expected = render_mesh(scene.image, scene.rest, scene.rest, size=(60, 44), scale=0.4).pixels
    assert np.abs(wide.astype(int) - expected).mean() <= 4, "the picture is noise, whose neighbours differ by far more"
    assert flat.shape == (44, 60, 4)
    assert flat[[0, -1]].max() == 0
    assert flat[12:32, 1:-1, 3].min() > 0


def test_a_moved_picture_is_placed_once_and_one_that_rests_not_at_all(
    screen: Screen, monkeypatch: pytest.MonkeyPatch
) -> None:
    placed: list[Points] = []
    place = MeshBuffers._place

    def counting(mesh: MeshBuffers, rest: Points, moved: Points, scaling: Scaling) -> None:
        placed.append(moved)
        place(mesh, rest, moved, scaling)

    monkeypatch.setattr(MeshBuffers, "_place", counting)
    scene = a_scene(marks=MarkOptions(grid=True))
    before = screen.shot(scene)
    assert len(placed) == 1
    screen.shot(scene)
    screen.shot(replace(scene, marks=MarkOptions()))
    assert len(placed) == 1
    moved = screen.shot(replace(scene, warped=scene.warped + 7))
    assert len(placed) == 2
    assert not np.array_equal(moved, before)
    screen.shot(replace(scene, view=View(1.3, (15.5, 12.5), (WIDTH, HEIGHT))))
    assert len(placed) == 3
    assert np.array_equal(screen.shot(scene), before)


@pytest.mark.parametrize("cells", [3, 16, 17, 40])
def test_a_mesh_placed_again_draws_as_one_placed_at_once(cells: int, screen: Screen) -> None:
    rest = scenes.grid(150, 110, cells=cells)
    first = a_scene(rest=rest, warped=scenes.wavy(rest) * [1.2, 0.8] + 9)
    last = replace(first, warped=scenes.wavy(rest), marks=MarkOptions(grid=True, outline=True))
    screen.shot(first)
    after = screen.shot(last)
    screen.renderer.release()
    assert np.array_equal(screen.shot(last), after)
