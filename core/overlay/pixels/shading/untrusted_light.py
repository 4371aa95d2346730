"""The light on cloth where the model's cannot be trusted.

Where the model lies beside the photo, its shading and what the detail misses of the photo are the pattern's, not the
light's. The photo's mean brightness over a texel, over the texel's own, is the light whatever lies where. Nearer to a
place it is told by those pixels that show the colour which the model has there, whatever their shade.
"""

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.filters.smoothing import gaussian
from core.overlay.palette import from_shades, palette
from core.overlay.texel import Texel
from core.overlay.tolerances import MOTIF, MOTIF_PX, SHADES

WIDTH = 0.8
"""Width of a neighbourhood that has every colour of a texel in its share, over the texel's longer side."""
USUAL = 0.1
"""Weight of the light around a place, over that of a neighbourhood in which the model's colours are all seen."""


def local_light(photo: Singles, covered: Bools, texel: Texel, basis: Floats) -> Singles:
    """Return the light (H, W) in which the texel has the brightness that the photo (H, W, 3) has around each pixel.

    Only `covered` pixels (H, W) count; `basis` (2, 2) is pixels of undeformed cloth a texel.
    """
    width = WIDTH * float(np.linalg.norm(basis, axis=0).max())
    mass = np.maximum(gaussian(covered.astype(np.float32), width), 1e-3)
    seen = gaussian(photo.mean(-1) * covered, width) / mass
    return np.asarray(seen / max(float(texel.pixels.mean()), 1e-3), np.float32)


def nearer_light(photo: Singles, uv: Singles, around: Singles, texel: Texel, basis: Floats) -> Singles:
    """Return the light (H, W) near each pixel, where the light `around` it (H, W) is known.

    `photo` is (H, W, 3), `uv` (H, W, 2), NaN outside the cloth; `basis` (2, 2) is pixels of undeformed cloth a texel.
    """
    covered, light, colours = np.isfinite(uv[..., 0]), np.nan_to_num(around), palette(texel)
    model = texel(np.nan_to_num(uv).astype(np.float64)).astype(np.float32) * covered[..., None]
    seen = np.argmin(
        [from_shades(photo.astype(np.float64), light[..., None] * colour, SHADES) for colour in colours], axis=0
    )
    drawn = np.argmin([np.linalg.norm(model - colour, axis=-1) for colour in colours], axis=0)
    power, agree = np.einsum("...c,...c", model, model), (seen == drawn).astype(np.float32)
    both = np.einsum("...c,...c", photo, model) * agree
    sigma = max(MOTIF_PX, MOTIF * float(np.sqrt(abs(np.linalg.det(basis)))))
    usual = USUAL * gaussian(power, sigma)
    found = (gaussian(both, sigma) + usual * light) / np.maximum(gaussian(power * agree, sigma) + usual, 1e-6)
    return np.asarray(np.where(covered, found, around), np.float32)
