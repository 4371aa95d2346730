"""The mesh that carries coordinates and shading, and what is measured on it."""

import numpy as np
import pytest

from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.mesh import ClothMesh, boxes_of
from core.overlay.registration.region import LIMIT, Tolerance, judge, misfit, sums
from core.overlay.registration.thin_plate import spread
from core.overlay.texel import draw_sample, estimate_texel
from tests.core.overlay.overlay_scenes import make_scene, motif

RNG = np.random.default_rng(0)


def test_a_box_of_pixels_has_the_values_of_the_whole() -> None:
    mesh = ClothMesh((53, 71), 6)
    values = RNG.random((*mesh.nodes, 3))
    cells = np.zeros(mesh.cells, bool)
    cells[7:, 3:5] = True
    box = mesh.box_of(cells, 1)
    whole = mesh.smooth_to_pixels(values, (slice(0, 53), slice(0, 71)))
    assert box == (slice(36, 53), slice(12, 36))
    assert np.allclose(mesh.smooth_to_pixels(values, box), whole[box])


def test_boxes_are_of_parts_that_lie_apart() -> None:
    used = np.zeros((60, 90), bool)
    used[5:8, 10:12] = used[9, 20] = used[40:45, 70:80] = True
    assert boxes_of(used, 5) == [(slice(0, 15), slice(5, 26)), (slice(35, 50), slice(65, 85))]
    assert boxes_of(used, 60) == [(slice(0, 105), slice(0, 140))]
    assert boxes_of(np.zeros((60, 90), bool), 5) == []


def test_areas_are_those_of_the_marked_cells_triangles() -> None:
    mesh = ClothMesh((30, 40), 10)
    turn = np.array([[0.0, -2.0], [3.0, 1.0]])
    cells = RNG.random(mesh.cells) < 0.5
    areas = mesh.areas(mesh.positions() @ turn.T, cells)
    assert areas.shape == (cells.sum(), 2)
    assert np.allclose(areas, 100 * 6)
    assert (mesh.areas(mesh.positions() @ np.diag([1, -1]), cells) < 0).all()


def test_coordinates_are_spread_around_the_lattice_and_no_further() -> None:
    basis = np.array([[20.0, 2.0], [-3.0, 18.0]])
    keys = np.stack(np.meshgrid(np.arange(3), np.arange(3)), -1).reshape(-1, 2)
    points = keys @ basis.T + 100
    mesh = ClothMesh((300, 400), 8)
    uv = spread(mesh, Lattice(keys, PatchFrames(points, np.tile(basis, (9, 1, 1)), np.ones(9))))
    known = np.isfinite(uv[..., 0])
    away = np.linalg.norm(mesh.positions()[:, :, None] - points, axis=-1).min(-1)
    assert known[away < 30].all()
    assert not known[away > 80].any()
    assert np.allclose(uv[known], (mesh.positions()[known] - 100) @ np.linalg.inv(basis).T, atol=0.02)


def test_cells_and_neighbourhoods_of_pixels_are_judged_alike() -> None:
    photo, light = RNG.random((24, 24, 3)), 0.5 + RNG.random((24, 24))
    model, valid = photo + RNG.normal(0, 0.1, photo.shape), RNG.random((24, 24)) < 0.8
    tolerance = Tolerance(0.1, 0.002, 1.25)
    one = [np.moveaxis(a.reshape(1, 576, -1), -1, 0) for a in (photo, model)]
    cell = judge(sums(one[0], one[1], light.reshape(1, 576), valid.reshape(1, 576).astype(float)), tolerance)
    wide = misfit(photo, model, light, valid, tolerance, 400.0)
    for of_cell, of_pixels in zip(cell, wide, strict=True):
        assert np.ptp(of_pixels) < 0.02 * of_cell[0]
        assert of_pixels.mean() == pytest.approx(of_cell[0], rel=0.02)


def test_noise_is_no_misfit_and_even_ground_and_another_phase_are() -> None:
    model, light = 0.5 + RNG.normal(0, 0.1, (24, 24, 3)), np.ones((24, 24))
    noise = RNG.normal(0, 0.085, model.shape)
    tolerance = Tolerance(0.03, 3 * 0.085**2, 1.0)
    for photo, is_cloth in ((model + noise, True), (0 * model + 0.5, False), (model[::-1] + noise, False)):
        strict, _ = misfit(photo, model, light, light > 0, tolerance, 400.0)
        assert (strict.mean() < LIMIT) == is_cloth
        assert abs(strict.mean() - LIMIT) > 0.3


def test_mere_noise_is_no_cloth_of_the_little_texture_that_its_mean_has() -> None:
    noise, light = RNG.normal(0, 0.1, (24, 24, 3)), np.ones((24, 24))
    model = 0.5 + RNG.normal(0, 0.03, noise.shape)
    strict, _ = misfit(0.5 + noise, model, light, light > 0, Tolerance(0.0027, 0.03, 1.0), 400.0)
    assert strict.mean() > 5 * LIMIT


def test_a_share_of_a_large_photo_shows_the_texel_as_well() -> None:
    scene = make_scene(motif(), size=(400, 420))
    weight = np.ones((400, 420))
    coarse = estimate_texel(scene.photo, scene.uv, scene.shading, weight, (20, 20)).pixels
    assert draw_sample(weight > 0, 32 * 400).mean() == pytest.approx(32 * 400 / weight.size, rel=0.05)
    assert draw_sample(weight > 0, 10**6).all()
    assert not (draw_sample(scene.shading > 1, 500) & (scene.shading <= 1)).any()
    truth = motif(20).pixels
    assert np.sqrt(((coarse - truth) ** 2).mean()) < 0.06


def test_a_texel_is_looked_up_plane_by_plane_as_it_is_pixel_by_pixel() -> None:
    texel, uv = motif(20), RNG.uniform(-3, 3, (7, 11, 2))
    for planes, pixels in zip(texel.planes(uv, 3), texel.singles_with_gradient(uv), strict=True):
        assert np.array_equal(np.moveaxis(planes, 0, -1), pixels)
