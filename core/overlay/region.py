"""Where the cloth is: how well the registered texture explains the photo, and the mesh's growth to the cloth's end."""

import cv2
import numpy as np
from scipy import sparse

from core.arrays import Bools, Floats
from core.overlay.mesh import Mesh
from core.overlay.registration import State
from core.overlay.texel import Texel
from core.overlay.thin_plate import solve_plate

LIMIT = 0.6
"""Misfit from which a pixel is not cloth that the texture explains."""
FLOOR = 0.2
"""Least variance that a misfit is compared with, over the texel's own: plain ground between motifs has none."""


def misfit(photo: Floats, modelled: Floats, light: Floats, valid: Floats, texel: Texel, sigma_px: float) -> Floats:
    """Return the unexplained variance (H, W) of a neighbourhood over the texture's variance there.

    0 is a perfect fit; where the photo lacks the pattern it is about 1 or more. `modelled` is ρ T(uv) (H, W, 3),
    `light` ρ (H, W), `valid` (H, W) the pixels that count.
    """
    error = ((photo - modelled) ** 2).sum(-1)
    mass = np.maximum(smooth(valid, sigma_px), 1e-3)
    unexplained = smooth(error * valid, sigma_px) / mass
    mean = smooth(modelled * valid[..., None], sigma_px) / mass[..., None]
    variance = (smooth(modelled**2 * valid[..., None], sigma_px) / mass[..., None] - mean**2).sum(-1)
    own = float(texel.pixels.var(axis=(0, 1)).sum()) * light**2
    return np.asarray(unexplained / np.maximum(np.maximum(variance, FLOOR * own), 1e-6))


def smooth(values: Floats, sigma_px: float) -> Floats:
    """Return the Gaussian mean."""
    return np.asarray(cv2.GaussianBlur(values, (0, 0), sigma_px, borderType=cv2.BORDER_REFLECT), np.float64)


def model(mesh: Mesh, state: State, texel: Texel) -> tuple[Floats, Floats]:
    """Return ρ T(uv) (H, W, 3) and ρ (H, W)."""
    at = mesh.to_pixels(state.values)
    return at[..., 2:] * texel(at[..., :2]), at[..., 2]


def ring(cells: Bools, allowed: Bools, width: int) -> Bools:
    """Return the allowed cells within `width` of the cells in use."""
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * width + 1, 2 * width + 1))
    return np.asarray((cv2.dilate(cells.astype(np.uint8), kernel) > 0) & allowed & ~cells, np.bool_)


def continued(mesh: Mesh, state: State, cells: Bools) -> State:
    """Return the state on more cells, its values carried on straight from those that are in use."""
    known = np.flatnonzero(mesh.nodes_of(state.cells).ravel())
    rows = sparse.csr_array((np.ones(len(known)), (np.arange(len(known)), known)), shape=(len(known), state.rho.size))
    # Shading is carried on in its logarithm, so that it stays positive.
    targets = np.concatenate([state.uv.reshape(-1, 2)[known], np.log(state.rho.ravel()[known])[:, None]], -1)
    plate = solve_plate(mesh, rows, targets, 0.05)
    uv, rho = plate[..., :2], np.exp(np.clip(plate[..., 2], -4, 3))
    fixed = mesh.nodes_of(state.cells)
    return State(np.where(fixed[..., None], state.uv, uv), np.where(fixed, state.rho, rho), np.asarray(cells, np.bool_))


def without_specks(cells: Bools, least: int) -> Bools:
    """Return the cells without parts smaller than `least` cells, and holes smaller than that filled."""
    out = cells.copy()
    for value in (True, False):
        count, labels, stats, _ = cv2.connectedComponentsWithStats((out == value).astype(np.uint8), connectivity=4)
        small = [k for k in range(1, count) if stats[k, cv2.CC_STAT_AREA] < least]
        out[np.isin(labels, small)] = not value
    return out


def cleaned(inside: Bools, sigma_px: float) -> Bools:
    """Return a region without specks and holes smaller than a few `sigma_px`, its outline smoothed."""
    soft = smooth(inside.astype(np.float64), max(1.0, sigma_px / 4))
    return without_specks(soft > 0.5, max(4, round(4 * sigma_px**2)))


def feathered(inside: Bools, width_px: float = 2.0) -> Floats:
    """Return the coverage (H, W): 1 inside, falling to 0 over the last pixels before the region's border."""
    padded = np.pad(inside.astype(np.uint8), 1, mode="edge")
    distance = cv2.distanceTransform(padded, cv2.DIST_L2, 3)[1:-1, 1:-1]
    return np.asarray(np.clip(distance / (width_px + 1), 0, 1), np.float64)
