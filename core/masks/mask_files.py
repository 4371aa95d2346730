"""What a picture that is read as a mask marks, in words: whether it is what was meant shows only then."""

import numpy as np

from core.arrays import Bytes
from core.imaging.image import Image
from core.selection.sources import has_transparency, labels_in, opacity

MARKED = 127
"""Over this a pixel is marked."""


def marks_of(image: Image, mask: Bytes) -> tuple[Bytes, Bytes | None, str]:
    """Return a mask and numbers of features (H, W) for the grey levels (H, W) of a picture, and what to say of them.

    A picture of labels marks a feature for each; all else has no numbers.
    """
    labels = labels_in(mask)
    if labels is None:
        return mask, None, describe_mask(image, mask)
    count = int(labels.max())
    what = "1 label, which is a feature" if count == 1 else f"{count} labels, each of them a feature"
    return np.where(labels > 0, 255, 0).astype(np.uint8), labels, f"The mask holds {what}."


def marks_or_opacity_of(image: Image, mask: Bytes) -> tuple[Bytes, Bytes | None, str]:
    """Return what `marks_of` does, or where a picture is of one grey and transparent in parts, its opacity."""
    if mask.min() == mask.max() and has_transparency(image):
        alpha = opacity(image)
        return alpha, None, f"The mask marks {_percent(float((alpha > MARKED).mean()))} of the picture: what is opaque."
    return marks_of(image, mask)


def describe_mask(image: Image, mask: Bytes) -> str:
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
    return f"The mask marks nothing: its brightest pixel is {levels[-1]}, and only what is over {MARKED} is marked."


def _percent(share: float) -> str:
    return "less than 0.1 %" if share < 0.001 else f"{100 * share:.1f} %" if share < 0.1 else f"{100 * share:.0f} %"
