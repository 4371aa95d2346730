"""Motifs where the model has none, or none where it has one: beside a fold that is not followed, or drawn in some.

There the photo has a colour of the texel, but another one than the model. Something darker than the model in all
channels alike is no motif but a shadow, or may be one.
"""

import numpy as np

from core.arrays import Bools, Singles
from core.overlay.palette import palette
from core.overlay.texel import Texel

NEARER = 0.3
"""Squared distance of the photo from another colour, over that of the model from it."""
NOTICED = 10.0
"""Distance of two colours that are told apart, over the usual detail."""
SHADE = 0.08
"""Squared distance of the photo from a shade of the model, over that from the model itself."""
DARKEST = 0.3
"""Brightness of a shadow, over that of the model."""


def find_misplaced(detail: Singles, model: Singles, light: Singles, texel: Texel, noise: float) -> Bools:
    """Return where (H, W) the photo, `model` + `detail` (H, W, 3), has a colour of the pattern that is not the model's.

    `light` (H, W, 1 or 3) is ρ, `noise` how large a detail usually is.
    """
    photo, found = model + detail, np.zeros(model.shape[:2], bool)
    for colour in palette(texel):
        other = light * colour
        apart = squares(other - model)
        found |= (squares(photo - other) < NEARER * apart) & (apart > (NOTICED * noise) ** 2)
    share = np.einsum("...c,...c", photo, model) / np.maximum(squares(model), 1e-9)
    shadow = (share > DARKEST) & (share < 1) & (squares(photo - share[..., None] * model) < SHADE * squares(detail))
    return np.asarray(found & ~shadow, np.bool_)


def squares(difference: Singles) -> Singles:
    """Return the sums (H, W) of squares of the channels (H, W, 3)."""
    return np.asarray(np.einsum("...c,...c", difference, difference), np.float32)
