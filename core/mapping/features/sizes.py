"""The size that W leaves a feature  [FAT sec. 2.1]."""

from core.arrays import Floats, Ints
from core.grid import Grid
from core.mapping.features.quad_weights import Roles
from core.mapping.jacobians import Complexes, Jacobians, corner_frames


def smaller_scales(grid: Grid, w: Complexes, roles: Roles, chosen: Ints) -> Floats:
    """Return λ (k,) of the `chosen` features (k,): the size that W leaves them in the direction that keeps least.

    The linear part of W in a feature is taken as a whole, as the feature moves: of a swirl, which shears every quad
    a different way, little is left.
    """
    inside = roles.inside_of(chosen)
    frames = corner_frames(grid, tuple(w.ravel()[grid.quads[inside].T]))
    count = int(chosen.max(initial=-1)) + 1
    parts = frames.similar.real, frames.similar.imag, frames.opposite.real, frames.opposite.imag
    means = [roles.means(part, inside, count)[chosen] for part in parts]
    return Jacobians(means[0] + 1j * means[1], means[2] + 1j * means[3]).smaller_singular_values
