"""How much better a texel that repeats explains a photo than a smooth picture: finished finds are compared by it alone.

A pixel is explained by the mean of the photo around it, which needs no pattern, or on the cloth by texel and light.
With n samples of the photo, E0 the squares of what the mean leaves of them, and E those of what the cloth leaves where
it is, and the mean elsewhere, the logarithm of the ratio of the likelihoods is

    n / 2 log(E0 / E).

Changes so slow that light alone gives them count neither for the one nor for the other. Texels need no penalty by their
area here: that a pattern repeats was told by texels that foretell others (`Evidence`).
"""

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.detection.seeding import LIGHT_PX
from core.overlay.filters.smoothing import gaussian, mean


def count_explained(photo: Floats | Singles, modelled: Singles, covered: Bools, scale: int = 1) -> float:
    """Return that logarithm, in nats, for the model (H, W, 3) of a photo (H, W, 3) where it is `covered` (H, W).

    Every `scale`-th pixel is looked at.
    """
    few = slice(None, None, scale), slice(None, None, scale)
    seen, inside = np.asarray(photo[few], np.float32), covered[few][..., None]
    uneven = seen - gaussian(seen, LIGHT_PX)
    missed = np.where(inside, seen - modelled[few], np.float32(0))
    missed -= mean(missed, inside.astype(np.float32), LIGHT_PX)
    before = float(np.square(uneven, dtype=np.float64).sum())
    after = float(np.square(np.where(inside, missed, uneven), dtype=np.float64).sum())
    return 0.5 * seen.size * float(np.log((before + 1e-9) / (after + 1e-9)))
