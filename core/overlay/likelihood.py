"""How much better a texel that repeats explains a photo than a smooth picture: finished finds are compared by it alone.

A pixel is explained by the mean of the photo around it, which needs no pattern, or on the cloth by texel and light.
With n samples of the photo, E0 the squares of what the mean leaves of them, and G how much less of them the cloth
leaves where it is than its own mean, the logarithm of the ratio of the likelihoods is

    n / 2 log(E0 / (E0 - G)).

Changes so slow that light alone gives them count neither for the one nor for the other; nor does it count how the cloth
stands out from what is beside it, which any outline tells. Texels need no penalty by their area here: that a pattern
repeats was told by texels that foretell others (`Evidence`).
"""

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.filters.smoothing import LIGHT_PX, gaussian, mean


def count_explained(photo: Floats | Singles, modelled: Singles, covered: Bools, scale: int = 1) -> float:
    """Return that logarithm, in nats, for the model (H, W, 3) of a photo (H, W, 3) where it is `covered` (H, W).

    Every `scale`-th pixel is looked at.
    """
    few = slice(None, None, scale), slice(None, None, scale)
    seen, inside = np.asarray(photo[few], np.float32), covered[few][..., None]
    before = energy(seen - gaussian(seen, LIGHT_PX))
    own, left = (np.where(inside, plane, np.float32(0)) for plane in (seen, seen - modelled[few]))
    own, left = (plane - mean(plane, inside.astype(np.float32), LIGHT_PX) for plane in (own, left))
    gained = energy(np.where(inside, own, 0)) - energy(np.where(inside, left, 0))
    return 0.5 * seen.size * float(np.log((before + 1e-9) / (max(before - gained, 0) + 1e-9)))


def energy(plane: Singles) -> float:
    """Return the sum of the squares of a plane (H, W, C)."""
    return float(np.square(plane, dtype=np.float64).sum())
