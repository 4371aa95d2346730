"""What a picture that is read as a mask marks, in words: whether it is what was meant shows only then."""

import numpy as np

from core.arrays import Bytes
from core.imaging.image import Image

MARKED = 127
"""Over this a pixel is marked."""
FEW = 32
"""So many grey levels at most make a picture of labels, if none of them is bright."""


def said_of_mask(image: Image, mask: Bytes) -> str:
    """Return one sentence or two on the mask (H, W) that was made of `image`: how much it marks, what it left out."""
    share = float((mask > MARKED).mean())
    if share == 0.0:
        said = _said_of_nothing(mask)
    elif share == 1.0:
        said = "The mask marks the whole picture."
    else:
        said = f"The mask marks {_percent(share)} of the picture."
    if image.has_alpha and not (image.pixels[..., -1] == image.pixels[..., -1].flat[0]).all():
        said += " Its transparency does not count, only how bright it is."
    return said


def _said_of_nothing(mask: Bytes) -> str:
    """Say why a mask marks nothing."""
    levels = np.unique(mask)
    if len(levels) == 1:
        return f"The mask marks nothing: all of it is {levels[0]}, and only what is over {MARKED} is marked."
    if len(levels) <= FEW:
        return (
            f"The mask marks nothing: it holds {len(levels)} labels from {levels[0]} to {levels[-1]}, "
            f"and only what is over {MARKED} is marked."
        )
    return f"The mask marks nothing: its brightest pixel is {levels[-1]}, and only what is over {MARKED} is marked."


def _percent(share: float) -> str:
    return "less than 0.1 %" if share < 0.001 else f"{100 * share:.1f} %" if share < 0.1 else f"{100 * share:.0f} %"
