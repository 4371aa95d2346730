"""Where the cloth is: how well the registered texture explains the photo, and the mesh's growth to the cloth's end."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import cv2
import numpy as np
import scipy

from core.arrays import Bools, Floats, Singles
from core.linalg.factor import Factor
from core.overlay.filters.smoothing import gaussian
from core.overlay.mesh import ClothMesh, around
from core.overlay.registration.registration import ClothState, Registration, planes_of
from core.overlay.texel import Texel

F = TypeVar("F", Floats, Singles)

LIMIT = 0.6
"""Misfit from which a pixel is not cloth that the texture explains."""
UNUSUAL, LEAST_NOISE = 12.0, 2e-4
"""Times the usual unexplained variance from which a pixel is not cloth, and what that variance is at least."""
ALIKE = 0.75
"""Correlation of photo and model from which a pixel is cloth whatever its colours."""
NEAR = 4
"""Cells from which cloth is carried on."""
FLOOR = 0.2
"""Least variance that a misfit is compared with, over the texel's own: plain ground between motifs has none."""


@dataclass(frozen=True)
class Tolerance:
    """What an unexplained variance is compared with."""

    own: float
    """Variance of the texel's colours."""
    noise: float
    """Usual unexplained variance on the cloth, at a shading of one."""
    leniency: float
    """Times the limit that a misfit may have: more than 1 where the user says that all is cloth."""


def sums(photo: F, modelled: F, light: F, weight: F) -> Floats:
    """Return what `judge` needs of cells (K, 18): sums over their pixels, times the weight.

    That is: the squared error, 1, the model's three colours and their squares, ρ², the photo's colours and their
    squares, and the products of both. `photo` and `modelled` are (3, K, n), `light` and `weight` (K, n).
    """
    seen, model, missing = photo * weight, modelled * weight, photo - modelled
    own, both, squares = (
        np.einsum("ckp,ckp->kc", a, b) for a, b in ((model, modelled), (seen, modelled), (seen, photo))
    )
    # From the squares and products the error would be a small difference of large sums.
    error = (np.einsum("ckp,ckp->kp", missing, missing) * weight).sum(1)[:, None]
    count, bright = weight.sum(1)[:, None], (light**2 * weight).sum(1)[:, None]
    planes = [error, count, model.sum(2).T, own, bright, seen.sum(2).T, squares, both]
    return np.concatenate(planes, -1).astype(np.float64)


def judge(planes: Floats, tolerance: Tolerance) -> tuple[Floats, Floats]:
    """Return the misfit from smoothed `sums` (..., 18), strictly and mildly: up to 0 is right, `LIMIT` the cloth's end.

    Strictly it is the unexplained variance, less the photo's noise, over the texture's in the same neighbourhood. Noise
    is by how much the photo varies more than the model, up to what is usual on the cloth: thin lines are found on a
    noisy photo, and even ground, which varies less than a texture, is still no cloth. Nor is mere noise: it counts up
    to the texture's own variance only, and its mean over several texels varies little. Mildly it is what the
    correlation of photo and model lacks, if that is less: a brick of another colour is a brick.
    """
    return _judge_means(planes / np.maximum(planes[..., 1:2], 1e-3), tolerance)


def _judge_means(means: Floats, tolerance: Tolerance) -> tuple[Floats, Floats]:
    """Return what `judge` does from the sums over their second (..., 18)."""
    light = means[..., 8]
    variance = (means[..., 5:8] - means[..., 2:5] ** 2).sum(-1)
    seen = (means[..., 12:15] - means[..., 9:12] ** 2).sum(-1)
    common = (means[..., 15:18] - means[..., 2:5] * means[..., 9:12]).sum(-1)
    floor, usual = FLOOR * tolerance.own * light, UNUSUAL * tolerance.noise / LIMIT * light
    noise = np.clip(seen - variance, 0, min(tolerance.noise, tolerance.own) * light)
    beyond = means[..., 0] - noise
    unexplained = beyond / np.maximum(np.minimum(np.maximum(variance, floor), usual), 1e-6)
    correlation = common / np.sqrt(np.maximum(variance * (seen + LEAST_NOISE), 1e-12))
    lacking = np.where(variance > floor, LIMIT * (1 - correlation) / (1 - ALIKE), np.inf)
    mild = np.minimum(unexplained, lacking)
    return np.asarray(unexplained / tolerance.leniency, np.float64), np.asarray(mild / tolerance.leniency, np.float64)


def misfit(
    photo: Floats, modelled: Floats, light: Floats, valid: Bools, tolerance: Tolerance, sigma_px: float
) -> tuple[Floats, Floats]:
    """Return the strict and the mild misfit (H, W) of the neighbourhood of each pixel.

    `modelled` is ρ T(uv) (H, W, 3), `light` ρ (H, W), `valid` (H, W) the pixels that count.
    """
    seen, model, w = (a.astype(np.float32) for a in (photo, modelled, valid[..., None]))
    planes = np.empty((*valid.shape, 18), np.float32)
    planes[..., :1] = ((seen - model) ** 2).sum(-1, keepdims=True)
    planes[..., 1] = 1
    planes[..., 8] = light**2
    for first, of_colours in ((2, model), (5, model**2), (9, seen), (12, seen**2), (15, seen * model)):
        planes[..., first : first + 3] = of_colours
    if not valid.all():
        planes *= w
    # Of a large photo the sums are the most memory: none but their means is kept.
    del seen, model, w, first, of_colours
    planes = gaussian(planes, sigma_px)
    planes /= np.maximum(planes[..., 1:2], 1e-3)
    return _judge_means(planes, tolerance)


@dataclass(frozen=True)
class SeenCells:
    """The K cells of some pieces, of n pixels each: what the photo shows there, and where it is registered."""

    photo: Singles
    """(K, n, 3)."""
    weight: Singles
    """(K, n), 0 where a pixel says nothing."""
    at: Floats
    """(K, n, 3), coordinates, texels, and shading."""

    @property
    def light(self) -> Singles:
        """Shading (K, n)."""
        return self.at[..., 2].astype(np.float32)

    def show(self, texel: Texel) -> Singles:
        """Return ρ T(uv) (K, n, 3)."""
        return self.light[..., None] * texel.singles(self.at[..., :2])

    def sums(self, texel: Texel) -> Floats:
        """Return the `sums` (K, 18)."""
        modelled = self.light * texel.planes(self.at)[0]
        return sums(planes_of(self.photo), modelled, self.light, self.weight)


def look_at(registration: Registration, pieces: Sequence[ClothState]) -> SeenCells:
    """Return the cells of the pieces, those of one after those of another."""
    mesh, planes = registration.mesh, registration.by_cells()
    at = [mesh.weights @ piece.values.reshape(-1, 3)[mesh.corners[piece.cells]] for piece in pieces]
    photo, weight = (np.concatenate([plane[piece.cells] for piece in pieces]) for plane in planes)
    return SeenCells(photo, weight, np.concatenate(at))


def tolerance_of(found: Floats, texel: Texel, leniency: float) -> Tolerance:
    """Return the tolerance for cloth whose cells have these sums (K, 18)."""
    noise = float(np.median(found[:, 0] / np.maximum(found[:, 8], 1e-6))) if len(found) else 0.0
    return Tolerance(float(texel.pixels.var(axis=(0, 1)).sum()), max(noise, LEAST_NOISE), leniency)


def misfit_of_cells(
    mesh: ClothMesh, cells: Bools, found: Floats, tolerance: Tolerance, sigma_px: float
) -> tuple[Floats, Floats]:
    """Return the strict and the mild misfit (rows, columns) of the cells that the sums (K, 18) are of, 0 elsewhere."""
    out = np.zeros((2, *mesh.cells))
    # What is further away does not reach the cells.
    box = around(cells, 1 + round(4 * sigma_px / mesh.cell))
    planes = np.zeros((*cells[box].shape, found.shape[1]))
    planes[cells[box]] = found
    out[:, cells] = judge(gaussian(planes, sigma_px / mesh.cell)[cells[box]], tolerance)
    return out[0], out[1]


def ring(cells: Bools, allowed: Bools, width: int) -> Bools:
    """Return the allowed cells within `width` of the cells in use."""
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * width + 1, 2 * width + 1))
    return np.asarray((cv2.dilate(cells.astype(np.uint8), kernel) > 0) & allowed & ~cells, np.bool_)


def continue_on(mesh: ClothMesh, state: ClothState, cells: Bools) -> ClothState:
    """Return the state on more cells, its values carried on as a thin plate that is fixed at the nodes in use."""
    # Only nodes near the new ones matter.
    box = around(cells & ~state.cells, NEAR + 2)
    carried = extend_plate(mesh.part(box), state.part(box), cells[box])
    return replace(state.with_part(box, carried), cells=cells)


def extend_plate(mesh: ClothMesh, state: ClothState, cells: Bools) -> ClothState:
    """Return what `continue_on` does, of the nodes up to `NEAR` from those that are carried on."""
    fixed = mesh.nodes_of(state.cells).ravel()
    used = mesh.nodes_of(cells).ravel()
    new = np.flatnonzero(used & ~fixed)
    if not len(new):
        return state
    kernel = np.ones((2 * NEAR + 1, 2 * NEAR + 1), np.uint8)
    near = cv2.dilate((used & ~fixed).reshape(mesh.nodes).astype(np.uint8), kernel) > 0
    L = mesh.bending(np.asarray(used.reshape(mesh.nodes) & near, np.bool_))
    # Shading is carried on in its logarithm, so that it stays positive.
    values = np.concatenate([state.uv, np.log(np.maximum(state.rho, 1e-3))[..., None]], -1).reshape(-1, 3)
    inner, outer = L[:, new], L @ np.where(fixed[:, None], values, 0.0)
    A = inner.T @ inner + 1e-9 * scipy.sparse.eye_array(len(new))
    values[new] = -np.asarray(Factor(A).solve(inner.T @ outer), np.float64)
    grid = values.reshape(*mesh.nodes, 3)
    return ClothState(grid[..., :2], np.exp(np.clip(grid[..., 2], -4, 3)), cells)


def without_specks(cells: Bools, least: int) -> Bools:
    """Return the cells without parts smaller than `least` cells, and holes smaller than that filled."""
    out = cells.copy()
    for value in (True, False):
        _, labels, stats, _ = cv2.connectedComponentsWithStats((out == value).astype(np.uint8), connectivity=4)
        small = stats[:, cv2.CC_STAT_AREA] < least
        small[0] = False
        out[small[labels]] = not value
    return out


def clean(inside: Bools, sigma_px: float) -> Bools:
    """Return a region without specks and holes smaller than a few `sigma_px`, its outline smoothed."""
    soft = gaussian(inside.astype(np.float64), max(1.0, sigma_px / 4))
    return without_specks(soft > 0.5, max(4, round(4 * sigma_px**2)))


def feather(inside: Bools, width_px: float = 1.0) -> Singles:
    """Return the coverage (H, W): 1 inside, falling to 0 over the last pixel before the region's border."""
    padded = np.pad(inside.astype(np.uint8), 1, mode="edge")
    distance = cv2.distanceTransform(padded, cv2.DIST_L2, 3)[1:-1, 1:-1]
    return np.asarray(np.clip(distance / (width_px + 1), 0, 1), np.float32)
