"""On a surface in space features come out undistorted (FAT fig. 5)."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.arrays import Floats, InputError, Points
from core.document.document import Document, Pin
from core.document.feature import Feature
from core.document.map import lay_on_surface
from core.document.map_solver import settle_map
from core.document.project import load_project, save_project
from core.imaging.image import Image
from core.mapping.result import Warped
from core.progress import run
from core.rasters.raster import Raster
from core.surfaces.shapes import SHAPES, Shape, make_shape
from core.surfaces.surface import Surface

SIZE = 480, 240
RADIUS = 8.0
DISCS = ((120.0, 62.0), (330.0, 60.0), (240.0, 130.0), (90.0, 185.0), (370.0, 180.0))


def discs() -> Document:
    """Return a picture with five discs painted as features."""
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    mask = np.zeros(SIZE[::-1], np.uint8)
    for cx, cy in DISCS:
        mask[np.hypot(x - cx, y - cy) < RADIUS + 3] = 255
    document = Document.of(Image(np.full((*SIZE[::-1], 3), 128, np.uint8)))
    return replace(document, mask=Raster.from_array(mask))


def circle(centre: tuple[float, float]) -> Points:
    turn = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    return np.array(centre) + RADIUS * np.stack([np.cos(turn), np.sin(turn)], axis=-1)


def on_shape(shape: Shape, texture_px: Points) -> Floats:
    """Return where places of the texture, in pixels of it, are in space."""
    share = (texture_px + 0.5) / SIZE
    return np.stack(shape.place(share[:, 0], share[:, 1], shape.usual), axis=-1)


def ovalness(places: Floats) -> float:
    """Return by how much the longest half axis of a ring of places (n, 3) is longer than the one across it."""
    long, across, _ = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    return float(long / across - 1)


def texture_of(document: Document, found: Warped, points: Points) -> Points:
    nodes, weights = found.grid.weights_at(points)
    laid = lay_on_surface(document, found).reshape(-1, 2)
    return np.asarray((laid[nodes] * weights[..., None]).sum(axis=1))


@pytest.mark.parametrize(("name", "off"), [("sphere", 0.3), ("torus", 0.3), ("cylinder", 0.3)])
def test_painted_circles_stay_circles_on_a_surface_that_the_plain_texture_makes_oval(name: str, off: float) -> None:
    document = replace(discs(), surface=make_shape(name))
    found = run(settle_map(document))
    assert not found.folded.any()
    shape = SHAPES[name]
    plain = [ovalness(on_shape(shape, circle(disc))) for disc in DISCS]
    kept = [ovalness(on_shape(shape, texture_of(document, found, circle(disc)))) for disc in DISCS]
    assert max(plain) > off
    assert max(kept) < 0.02


def test_near_a_pole_circles_stay_circles_and_a_least_size_keeps_them_large() -> None:
    near = 240.0, 28.0  # 69 degrees of latitude
    mask = np.zeros(SIZE[::-1], np.uint8)
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    mask[np.hypot(x - near[0], y - near[1]) < RADIUS + 3] = 255
    start = replace(discs(), mask=Raster.from_array(mask), surface=make_shape("sphere"))
    numbered = replace(start, numbers=Raster.from_array(np.minimum(mask, 1)), features=(Feature(1, least=1.0),))
    rings = [on_shape(SHAPES["sphere"], circle(near))]
    for document in (start, numbered):
        texture = texture_of(document, run(settle_map(document)), circle(near))
        rings.append(on_shape(SHAPES["sphere"], texture))
    plain, shrunk, held = (np.ptp(ring, axis=0).max() for ring in rings)
    assert ovalness(rings[0]) > 1.5
    assert max(ovalness(ring) for ring in rings[1:]) < 0.02
    assert shrunk < 0.5 * plain < held


def test_the_texture_stays_filled_to_its_edge() -> None:
    document = replace(discs(), surface=make_shape("sphere"))
    laid = lay_on_surface(document, run(settle_map(document)))
    width, height = SIZE
    np.testing.assert_allclose(laid[0, :, 1], -0.5, atol=1e-9)
    np.testing.assert_allclose(laid[-1, :, 1], height - 0.5, atol=1e-9)
    np.testing.assert_allclose(laid[:, 0, 0], -0.5, atol=1e-9)
    np.testing.assert_allclose(laid[:, -1, 0], width - 0.5, atol=1e-9)


def test_without_features_the_texture_is_the_picture() -> None:
    document = replace(discs(), mask=Raster.filled(*SIZE), surface=make_shape("torus"))
    found = run(settle_map(document))
    np.testing.assert_allclose(lay_on_surface(document, found), found.rest, atol=1e-5)


def test_pins_hold_on_the_canvas_of_the_chart() -> None:
    document = replace(discs(), surface=make_shape("sphere"))
    moved = replace(document, pins=(Pin((0.25, 0.25), (0.35, 0.3)),))
    found = run(settle_map(moved))
    assert moved.canvas_px == document.canvas_px != document.size_px
    assert found.pin_reports[0].error_px < 0.1


def test_a_project_keeps_its_surface(tmp_path: Path) -> None:
    document = replace(discs(), surface=make_shape("flag", 0.2))
    save_project(document, tmp_path / "flag.weft")
    found = load_project(tmp_path / "flag.weft").surface
    assert found is not None
    assert document.surface is not None
    assert found.name == "flag"
    for name in ("vertices", "texture", "triangles"):
        np.testing.assert_array_equal(getattr(found, name), getattr(document.surface, name))


def test_a_project_with_a_surface_that_is_none_is_damaged(tmp_path: Path) -> None:
    flat = Surface("flat", np.zeros((3, 3)), np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), np.array([[0, 1, 2]]))
    path = tmp_path / "flat.weft"
    save_project(replace(discs(), surface=flat), path)
    with pytest.raises(InputError, match=r"flat\.weft: damaged project: surface: has no area"):
        load_project(path)
