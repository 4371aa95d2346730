"""Where coordinates are not those of cloth, which hardly stretches: they jump, are folded over, blown up or crushed."""

import numpy as np

from core.arrays import Bools, Floats
from core.overlay.composition import finite
from core.overlay.filters.smoothing import gaussian
from core.overlay.filters.texture_filter import steepness
from core.overlay.tolerances import MOTIF, STRETCH

SIZES = (0.36, 2.2)
"""Pixels of undeformed cloth to a place, over its distance from the next one, that cloth may have in any direction."""
SHARE = 0.25
"""How much of a neighbourhood is no cloth around a place that is none."""


def stretches(uv: Floats, basis: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the area of undeformed cloth to a pixel, negative where turned over, and its least and most length.

    Each is (H, W), for coordinates (H, W, 2); `basis` (2, 2) is pixels of undeformed cloth a texel.
    """
    at = uv @ basis.T
    J = np.stack([steepness(at, 1), steepness(at, 0)], -1)
    area = J[..., 0, 0] * J[..., 1, 1] - J[..., 0, 1] * J[..., 1, 0]
    # Both singular values, from their product and the sum of their squares.
    squares = np.einsum("...ij,...ij", J, J) / 2
    root = np.sqrt(np.maximum(squares**2 - area**2, 0))
    least, most = (np.sqrt(np.maximum(squares + sign * root, 0)) for sign in (-1, 1))
    return area, least, most


def no_cloth(uv: Floats, basis: Floats, side_px: float) -> Bools:
    """Return where (H, W) coordinates (H, W, 2) are folded over, blown up or crushed over a neighbourhood.

    `basis` (2, 2) is pixels of undeformed cloth a texel, `side_px` the side of a texel.
    """
    covered, (area, least, most) = finite(uv), stretches(uv, basis)
    if covered.any():
        area *= np.sign(np.median(area[covered]))
    wild = covered & ((area <= 0) | (least < SIZES[0]) | (most > SIZES[1]))
    share = gaussian(wild.astype(np.float32), 2 * MOTIF * side_px)
    return np.asarray(wild & (share > SHARE * gaussian(covered.astype(np.float32), 2 * MOTIF * side_px)), np.bool_)


def jumps(uv: Floats, basis: Floats) -> Floats:
    """Return the longest step (H, W), pixels of undeformed cloth, from each pixel to one beside it; 0 beyond."""
    out = np.zeros(uv.shape[:2])
    for here, there in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        length = np.nan_to_num(np.linalg.norm((uv[there] - uv[here]) @ basis.T, axis=-1))
        for side in (here, there):
            out[side] = np.maximum(out[side], length)
    return out


def find_untorn(uv: Floats, basis: Floats) -> Bools:
    """Return where (H, W) coordinates (H, W, 2) do not jump; `basis` (2, 2) is pixels of undeformed cloth a texel."""
    return np.asarray(finite(uv) & (jumps(uv, basis) <= STRETCH), np.bool_)
