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
