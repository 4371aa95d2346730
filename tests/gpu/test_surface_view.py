"""The view of a surface: what it draws anew, and what not."""

from dataclasses import replace

import numpy as np
import pytest

from app.model.orbit import Orbit
from app.render import gpu
from app.render.sources.source import Source
from app.render.surface_view import Laid, SurfaceView
from core.grid import Grid
from core.imaging.images import Image
from core.surfaces.shapes import make_shape

pytestmark = pytest.mark.gpu


def test_only_what_has_changed_is_drawn_anew() -> None:
    context = gpu.standalone()
    rest = Grid(60, 40, cell_px=4).nodes
    laid = Laid(make_shape("sphere"), rest, rest, (60, 40))
    source = Source(context, Image(np.random.default_rng(1).integers(0, 256, (40, 60, 3), np.uint8)))
    view, orbit = SurfaceView(context, (64, 64)), Orbit()

    def triangles_drawn(laid: Laid, orbit: Orbit) -> int:
        with context.query(primitives=True) as query:
            view.draw(laid, source, orbit)
        return int(query.primitives)

    picture_and_surface = triangles_drawn(laid, orbit)
    assert triangles_drawn(replace(laid), orbit) == 0
    surface = triangles_drawn(laid, replace(orbit, turn_deg=orbit.turn_deg + 30))
    assert 0 < surface < picture_and_surface
    before = view.read()
    assert triangles_drawn(replace(laid, moved=rest + [20, 0]), replace(orbit, turn_deg=orbit.turn_deg + 30)) > surface
    assert np.abs(view.read().astype(int) - before).max() > 50
    assert triangles_drawn(replace(laid, surface=make_shape("cube")), orbit) > 0
    gpu.release(view, source)


def test_what_takes_longer_than_a_frame_gets_better_over_several() -> None:
    context = gpu.standalone()
    rest = Grid(600, 400, cell_px=10).nodes
    laid = Laid(make_shape("sphere"), rest, rest, (600, 400))
    pixels = np.random.default_rng(1).integers(0, 256, (40, 60, 3), np.uint8)
    source = Source(context, Image(pixels.repeat(10, axis=0).repeat(10, axis=1)))
    view, whole = SurfaceView(context, (200, 200)), SurfaceView(context, (200, 200))
    whole.draw(laid, source, Orbit())
    best = whole.read().astype(int)
    assert not whole.is_refining

    view.draw(laid, source, Orbit(), frame_s=1e-9)
    assert view.is_refining, "the surface alone takes the first frame"
    assert np.ptp(view.read(), axis=(0, 1)).max() == 0
    view.draw(laid, source, Orbit(), frame_s=1e-9)
    draft = view.read().astype(int)
    assert view.is_refining
    assert 0.1 < np.abs(draft - best).mean() < 10
    frames = 1
    while view.is_refining:
        view.draw(laid, source, Orbit(), frame_s=1e-9)
        frames += 1
    assert frames > 5
    np.testing.assert_array_equal(view.read(), best)

    moved = replace(laid, moved=rest + [50, 0])
    view.draw(moved, source, Orbit(), frame_s=1e-9, waits=True)
    np.testing.assert_array_equal(view.read(), best)
    assert view.is_refining
    assert not view.has_drawn
    view.draw(moved, source, Orbit(turn_deg=50.0), frame_s=1e-9, waits=True)
    assert np.abs(view.read().astype(int) - best).mean() > 3, "the camera turns nevertheless"
    view.draw(moved, source, Orbit(), draft=True, frame_s=1e-9, waits=True)
    assert np.abs(view.read().astype(int) - best).mean() > 20
    assert not view.is_refining
    gpu.release(view, whole, source)


def test_a_draft_of_a_fine_grid_has_few_triangles_and_shows_the_same() -> None:
    context = gpu.standalone()
    rest = Grid(600, 400, cell_px=3).nodes
    moved = rest + 12 * np.sin(rest[..., ::-1] / 60)
    laid = Laid(make_shape("plane"), rest, moved, (600, 400))
    pixels = np.random.default_rng(1).integers(0, 256, (10, 15, 3), np.uint8)
    source = Source(context, Image(pixels.repeat(40, axis=0).repeat(40, axis=1)))

    def draw(*, draft: bool) -> tuple[int, np.ndarray]:
        """Return how many triangles are drawn, and the pixels."""
        view = SurfaceView(context, (200, 200))
        with context.query(primitives=True) as query:
            view.draw(laid, source, Orbit(), draft=draft)
        shown = view.read().astype(int)
        gpu.release(view)
        return int(query.primitives), shown

    (fine, best), (coarse, shown) = draw(draft=False), draw(draft=True)
    assert coarse < 0.5 * fine
    assert np.abs(shown - best).mean() < 4
    gpu.release(source)


def test_the_surface_shows_where_the_picture_is_clear() -> None:
    context = gpu.standalone()
    rest = Grid(60, 40, cell_px=4).nodes
    laid = Laid(make_shape("plane"), rest, rest, (60, 40))
    view = SurfaceView(context, (64, 64))

    def middle_seen(alpha: int) -> np.ndarray:
        source = Source(context, Image(np.full((40, 60, 4), (200, 0, 0, alpha), np.uint8)))
        view.draw(laid, source, Orbit())
        gpu.release(source)
        return np.asarray(view.read()[32, 32], int)

    clear, half, whole = middle_seen(0), middle_seen(128), middle_seen(255)
    assert clear[3] == half[3] == whole[3] == 255
    assert np.ptp(clear[:3]) <= 1, "it is grey"
    assert clear[0] > 120
    assert whole[1] == 0 < half[1] < clear[1]
    gpu.release(view)
