"""Cloth whose pattern was lost, found again: carried straight on, it lies beside the photo's by a part of a texel.

By which part is one of a few shifts at every place: the same or the next one at the places beside it, and another one
where a fold hides some of the pattern. Minimised is, along paths from four sides that are added up (semi-global
matching, Hirschmüller 2008),

    Σ C(x, s_x) + Σ (P1 where a shift is next to the one beside it, P2 where it is another),

with C how far the photo is from any shade of the texture so shifted, over a neighbourhood, and a little more for any
shift than for none. Cloth that has been followed is not shifted, and holds the rest. Where the shifts are cut into
small pieces they are dropped.
"""

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.palette import from_shades
from core.overlay.smoothing import gaussian
from core.overlay.texel import Texel

STEP_PX, FEWEST, MOST = 1.75, 3, 10
"""Pixels between two shifts, and how many there are along a side of the texel."""
SHADES = (0.6, 1.4)
"""Light, over that which the cloth is taken to have."""
NEAR = 0.12
"""Width of the neighbourhood of a place, over the side of a texel."""
FURTHEST = 1.5
"""Most that a pixel counts, over the spread of the texel's colours, as P1 and P2 are."""
NEXT, OTHER = 0.3, 4.0
"""P1 and P2."""
HABIT = 0.12
"""What any shift costs at every place: the cloth lies as it is carried on unless the photo says otherwise."""
STRAIN, MOST_CUTS, AROUND = 1.2, 6.0, 0.3
"""Change of a shift, over the distance of two places, that is a cut; length of the cuts, in sides of a texel, over the
area in texels, from which the cloth is in pieces; width of the neighbourhood, over the side of a texel."""
SMOOTH, ALIKE = 1.5, 0.9
"""Width, in pixels, over which shifts are evened where they are that much alike."""


def shifts_where_lost(
    photo: Singles, uv: Singles, shading: Singles, texel: Texel, basis: Floats, lost: Bools
) -> Floats:
    """Return by how many texels (H, W, 2) the coordinates `uv` (H, W, 2) move where the pattern is `lost` (H, W).

    `uv` and `shading` (H, W) are NaN outside the cloth, `photo` is (H, W, 3), `basis` (2, 2) pixels of undeformed cloth
    a texel.
    """
    covered = np.isfinite(shading)
    columns, rows = (int(np.clip(round(float(n) / STEP_PX), FEWEST, MOST)) for n in np.linalg.norm(basis, axis=0))
    v, u = np.divmod(np.arange(rows * columns), columns)
    steps = np.stack([u / columns, v / rows], -1)
    costs = np.zeros((len(steps), *lost.shape), np.float32)
    costs[1:, covered & ~lost] = FURTHEST
    sigma = NEAR * float(np.sqrt(abs(np.linalg.det(basis))))
    mass = np.maximum(gaussian(lost.astype(np.float32), sigma), 1e-3)
    for plane, step in zip(costs, steps, strict=True):
        wrong = np.zeros(lost.shape, np.float32)
        wrong[lost] = unlike(photo[lost], uv[lost] + step, shading[lost], texel)
        plane[lost] = (gaussian(wrong, sigma) / mass)[lost]
    costs[1:] += HABIT
    sums = summed_along_paths(costs.reshape(rows, columns, *lost.shape), covered)
    shift = np.where(lost[..., None], evened(best_shift(sums)), 0.0)
    return shift * ~torn(shift, covered, basis)[..., None]


def unlike(photo: Singles, uv: Floats, shading: Singles, texel: Texel) -> Singles:
    """Return how far pixels (n, 3) are from any shade of the texture at uv (n, 2), over its spread of colours."""
    light = shading.astype(np.float64)[:, None]
    spread = float(np.sqrt(texel.pixels.var(axis=(0, 1)).sum()))
    off = from_shades(photo.astype(np.float64), light * texel.at(uv), SHADES) / np.maximum(light[:, 0] * spread, 1e-3)
    return np.minimum(off, FURTHEST).astype(np.float32)


def summed_along_paths(costs: Singles, covered: Bools) -> Singles:
    """Return the least costs (rows, columns, H, W) of paths to each place, one from every side, added up.

    A path begins anew where the cloth is not `covered` (H, W).
    """
    total = np.zeros_like(costs)
    for axis in (0, 1):
        own, sums, inside = (
            np.moveaxis(costs, axis + 2, 0),
            np.moveaxis(total, axis + 2, 0),
            np.moveaxis(covered, axis, 0),
        )
        for order in (range(len(own)), range(len(own) - 1, -1, -1)):
            path = np.zeros_like(own[0])
            for k in order:
                path = np.where(inside[k], own[k] + best_before(path), 0.0)
                sums[k] += path
    return total


def best_before(path: Singles) -> Singles:
    """Return what the cheapest shift (rows, columns, n) at the place before adds, over the least there."""
    near = np.minimum.reduce([np.roll(path, step, axis) for axis in (0, 1) for step in (1, -1)])
    least = path.min((0, 1))
    return np.asarray(np.minimum(np.minimum(path, near + NEXT), least + OTHER) - least, np.float32)


def best_shift(sums: Singles) -> Floats:
    """Return the shift (H, W, 2), texels, of the least sum (rows, columns, H, W), between the steps by a parabola."""
    rows, columns = sums.shape[:2]
    v, u = np.divmod(sums.reshape(rows * columns, *sums.shape[2:]).argmin(0), columns)
    y, x = np.indices(v.shape)
    here = sums[v, u, y, x]
    out = []
    for at, count, beside in (
        (u, columns, [sums[v, (u + k) % columns, y, x] for k in (-1, 1)]),
        (v, rows, [sums[(v + k) % rows, u, y, x] for k in (-1, 1)]),
    ):
        bend = np.maximum(beside[0] - 2 * here + beside[1], 1e-6)
        out.append((at + np.clip((beside[0] - beside[1]) / (2 * bend), -0.5, 0.5)) / count)
    return np.stack(out, -1)


def evened(shift: Floats) -> Floats:
    """Return shifts (H, W, 2) that are means of those around, where these agree; each from -0.5 to 0.5."""
    turns = np.exp(2j * np.pi * shift)
    soft = gaussian(turns.real, SMOOTH) + 1j * gaussian(turns.imag, SMOOTH)
    alike = np.abs(soft).min(-1, keepdims=True) > ALIKE
    return np.asarray(np.angle(np.where(alike, soft, turns)) / (2 * np.pi), np.float64)


def torn(shift: Floats, covered: Bools, basis: Floats) -> Bools:
    """Return where (H, W) shifts (H, W, 2), of `covered` places, lie in pieces: it is by chance that each of them fits.

    `basis` (2, 2) is pixels of undeformed cloth a texel.
    """
    side, cuts = float(np.sqrt(abs(np.linalg.det(basis)))), np.zeros(covered.shape)
    for here, there in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        apart = ((shift[there] - shift[here] + 0.5) % 1 - 0.5) @ basis.T
        cuts[here] += (np.linalg.norm(apart, axis=-1) > STRAIN) & covered[here] & covered[there]
    mass = np.maximum(gaussian(covered.astype(np.float64), AROUND * side), 1e-3)
    return np.asarray(gaussian(cuts, AROUND * side) / mass * side > MOST_CUTS, np.bool_)
