"""What is smooth, worked out on a coarse grid and refined by cubic convolution  [Keys 1981]."""

import numpy as np
import scipy

from core.arrays import Ints
from core.mapping.jacobians import Complexes


class CubicConvolution:
    """From the nodes of a coarse grid to those of a finer one over the same picture, shapes (r, c) and (R, C)."""

    def __init__(self, coarse: tuple[int, int], fine: tuple[int, int]) -> None:
        self.down, self.across = (between(n, m) for n, m in zip(fine, coarse, strict=True))

    def refine(self, d: Complexes) -> Complexes:
        """Return at the fine grid's nodes (R, C) what d (r, c) is at the coarse one's."""
        rows = np.ascontiguousarray((self.across @ d.T).T)
        return np.asarray(self.down @ rows.view(np.float64)).view(np.complex128)


def between(count: int, coarse: int) -> "scipy.sparse.csr_array":
    """Return the weights (count, coarse) of cubic convolution from evenly spaced nodes to others on the same length.

    Beyond its ends what is interpolated goes on straight.
    """
    place = np.linspace(0, coarse - 1, count)
    first: Ints = np.minimum(place.astype(np.int64), coarse - 2)
    t = place - first
    weights = np.stack(
        [
            ((-0.5 * t + 1) * t - 0.5) * t,
            (1.5 * t - 2.5) * t * t + 1,
            ((-1.5 * t + 2) * t + 0.5) * t,
            (0.5 * t - 0.5) * t * t,
        ],
        axis=1,
    )
    rows = np.repeat(np.arange(count), 4)
    wide = scipy.sparse.csr_array(
        (weights.ravel(), (rows, (first[:, None] + np.arange(4)).ravel())), (count, coarse + 2)
    )
    before = scipy.sparse.csr_array(([2.0, -1.0], ([0, 0], [0, 1])), (1, coarse))
    after = scipy.sparse.csr_array(([2.0, -1.0], ([0, 0], [coarse - 1, coarse - 2])), (1, coarse))
    return scipy.sparse.csr_array(wide @ scipy.sparse.vstack([before, scipy.sparse.eye_array(coarse), after]))
