"""The lattice of the cloth as it is laid, pixel by pixel: where its coordinates are whole numbers."""

from typing import Any

import numpy as np

from core.arrays import Bools, Floats, Ints
from core.overlay.composition import finite
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.lattice import Lattice
from core.overlay.filters.smoothing import gaussian, mean
from core.overlay.pixels.extension import find_sound
from core.overlay.pixels.jacobian_validity import find_untorn
from core.overlay.pixels.model import PixelModel
from core.overlay.registration.multivalued_lattice import lay_apart
from core.overlay.registration.region import misfit
from core.overlay.registration.vertices import find_whole_coordinates
from core.overlay.texel import draw_sample
from core.overlay.tolerances import MOTIF, SMOOTH_PX, TYPICAL

TRIANGLES = np.array([((0, 0), (1, 0), (1, 1)), ((0, 0), (1, 1), (0, 1))])
"""Corners of two triangles between four pixels, steps to the right and down."""


def read_lattice(model: PixelModel) -> Lattice:
    """Return the vertices of a finished model, at the photo's size, scored by what is explained of the quads.

    The score is the mean share, 0 to 1, of the variance that is explained around the middle of the quad to the lower
    right, over a spread that is a texel's. Vectors are means beside a vertex. Where cloth is crushed, blown up or torn
    there is no vertex.
    """
    few = np.s_[:: model.scale, :: model.scale]
    uv, basis = model.uv[few].astype(np.float64), model.cloth.basis
    covered = finite(uv)
    whole = find_untorn(uv, basis)
    keys, points = find_vertices(uv, whole)
    x, y = np.rint(points).astype(int).T
    sigma_px = max(2 * MOTIF * model.cloth.side_px, 1.0)
    steps, inside = (planes.astype(np.float32) for planes in slopes_right_and_down(uv, whole))
    weights = np.repeat(inside[..., None], 2, -1)
    means = [mean(slope, weight, sigma_px)[y, x] for slope, weight in zip(steps, weights, strict=True)]
    slopes = np.concatenate(means, -1).astype(np.float64)
    sound = find_sound(slopes, abs(float(np.linalg.det(basis))))
    keys, points = keys[sound], points[sound]
    vectors = np.asarray(np.linalg.inv(slopes[sound].reshape(-1, 2, 2).transpose(0, 2, 1)), np.float64)
    middles = np.rint(points + vectors.sum(-1) / 2).astype(int)
    x, y = np.clip(middles, 0, np.array(covered.shape[::-1]) - 1).T
    scores = explained_shares(model, covered)[y, x]
    return lay_apart(Lattice(keys, PatchFrames(points * model.scale, vectors * model.scale, scores)))


def find_vertices(uv: Floats, whole: Bools) -> tuple[Ints, Floats]:
    """Return the whole coordinates (n, 2) that are met, and where (n, 2), pixels; only where the cloth is `whole`.

    Between four pixels coordinates (H, W, 2) are linear on two triangles, of which none is as large as a texel.
    """
    y, x = np.nonzero(whole[:-1, :-1] & whole[1:, :-1] & whole[:-1, 1:] & whole[1:, 1:])
    corners = np.stack([uv[y + down, x + right] for right in (0, 1) for down in (0, 1)])
    meets = (np.ceil(corners.min(0)) <= corners.max(0)).all(-1)
    pixels = np.stack([x, y], -1)[meets, None, None] + TRIANGLES
    keys, points, _ = find_whole_coordinates(
        uv[pixels[..., 1], pixels[..., 0]].reshape(-1, 3, 2), pixels.reshape(-1, 3, 2)
    )
    return keys.astype(np.int64), points


def measure_basis(model: PixelModel) -> Floats:
    """Return the usual vectors (2, 2) of a texel as it is laid, pixels.

    Size, shape and direction are told one by one, so that a sleeve that lies otherwise than the body changes neither
    size nor shape: by the median of the area |J| of the slopes J of the coordinates, by that of J Jᵀ / |J|, and by that
    of the angles by which pixels are turned. Where cloth is crushed, torn or turned over everywhere, the vectors are
    those of the registration.
    """
    few = np.s_[:: model.scale, :: model.scale]
    uv = model.uv[few].astype(np.float64)
    steps, inside = slopes_right_and_down(uv, find_untorn(uv, model.cloth.basis))
    drawn = draw_sample(inside[0] & inside[1], TYPICAL)
    slopes = np.moveaxis(steps[:, drawn], 0, -1)
    areas = np.linalg.det(slopes)
    slopes, areas = slopes[areas > 0], areas[areas > 0]
    if not len(slopes):
        return model.basis
    area = float(np.median(areas))
    slopes /= np.sqrt(areas)[:, None, None]
    shape = np.median(slopes @ slopes.transpose(0, 2, 1), axis=0)
    if np.linalg.det(shape) <= 0:
        return model.basis
    lying = np.linalg.cholesky(shape / np.sqrt(np.linalg.det(shape)))
    usual = np.sqrt(area) * lying @ turn_by(median_turn(np.linalg.inv(lying) @ slopes))
    if not find_sound(usual.ravel(), abs(float(np.linalg.det(model.cloth.basis)))):
        return model.basis
    return np.asarray(np.linalg.inv(usual) * model.scale, np.float64)


def median_turn(matrices: Floats) -> float:
    """Return the median of the angles by which matrices (n, 2, 2) turn most nearly, radians from x to y."""
    turns = (matrices[:, 0, 0] + matrices[:, 1, 1]) + 1j * (matrices[:, 1, 0] - matrices[:, 0, 1])
    middle = np.angle((turns / np.maximum(np.abs(turns), 1e-12)).sum())
    return float(middle + np.median(np.angle(turns * np.exp(-1j * middle))))


def turn_by(angle: float) -> Floats:
    """Return the matrix (2, 2) that turns by an angle, radians from x to y."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def slopes_right_and_down(uv: Floats, whole: Bools) -> tuple[Floats, Bools]:
    """Return how coordinates (H, W, 2) change to the next pixel, (2, H, W, 2), and where (2, H, W) that is known."""
    slopes, inside = np.zeros((2, *uv.shape)), np.zeros((2, *whole.shape), np.bool_)
    ways: list[tuple[Any, Any]] = [(np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])]
    for number, (here, there) in enumerate(ways):
        inside[number][here] = whole[here] & whole[there]
        slopes[number][here] = np.where(inside[number][here][..., None], uv[there] - uv[here], 0)
    return slopes, inside


def explained_shares(model: PixelModel, covered: Bools) -> Floats:
    """Return the mean share (h, w) of the variance of every `scale`-th pixel that is explained, over texels.

    `covered` (h, w) has coordinates.
    """
    few = np.s_[:: model.scale, :: model.scale]
    seen, modelled = (np.asarray(plane, np.float64) for plane in (model.photo[few], model.modelled_at(few)))
    light = np.nan_to_num(model.light[few].mean(-1))
    strict, _ = misfit(seen, modelled, light, covered, model.found.tolerance, SMOOTH_PX)
    share = np.where(covered, 1 - np.clip(strict, 0, 1), 0)
    total, mass = (gaussian(plane, model.cloth.side_px / np.sqrt(12)) for plane in (share, covered.astype(np.float64)))
    return np.asarray(total / np.maximum(mass, 1e-4), np.float64)
