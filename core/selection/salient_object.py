"""The object that stands out in a picture, where nobody has said anything about it.

Two guesses are made of where it is: what hangs together with the picture's border is ground (`importance`), and what is
in the middle is the object. GrabCut learns the colours of both from either, and cuts the object out. That of the two
is kept which has less of its ground's colours and of the picture's border.
"""

from contextlib import suppress

import cv2
import numpy as np

from core.arrays import Bools, Bytes, InputError
from core.imaging.image import Image
from core.imaging.proxy import proxy, scale_for
from core.masks.object_masks import object_under
from core.progress import Job, part
from core.selection.features import MARKED
from core.selection.importance import importance, propose

PIXELS = 100_000
"""Objects are cut out in pictures of so many pixels."""
IMPORTANT = 0.4
"""Share of a picture that is taken for important: garments fill about so much."""
MIDDLE = 0.25
"""Share of a picture that is its middle, an ellipse: a larger one holds more ground."""
BIN = 16
"""Levels of each of the channels of CIELAB, of 256, that are one colour."""


def find_salient_object(image: Image) -> Job[Bools]:
    """Return where (H, W) the object is that stands out in a picture; raise `InputError` where none does."""
    small = Image(proxy(image, scale_for(image, PIXELS)))
    important = propose((yield from part(importance(small), 0.0, 0.3)), IMPORTANT, small.size_px)
    found: list[Bools] = []
    for number, guess in enumerate((important, middle(small.size_px))):
        job = object_under(small, guess, may_be_far=True)
        with suppress(InputError):
            mask = yield from part(job, 0.3 + 0.35 * number, 0.65 + 0.35 * number)
            found.append(np.asarray(mask > MARKED, np.bool_))
    found = [inside for inside in found if inside.any() and not inside.all()]
    if not found:
        raise InputError("no object stands out from its ground")
    likeliest = min(found, key=lambda inside: common_colours(small.pixels, inside) + share_of_border(inside))
    return cv2.resize(likeliest.astype(np.uint8), image.size_px, interpolation=cv2.INTER_LINEAR) > 0


def middle(size_px: tuple[int, int]) -> Bytes:
    """Return the mask (H, W) of the ellipse in the middle of a picture."""
    width, height = size_px
    y, x = ((np.arange(length) + 0.5) / length - 0.5 for length in (height, width))
    return np.where(x**2 + y[:, None] ** 2 < MIDDLE / np.pi, 255, 0).astype(np.uint8)


def common_colours(picture: Bytes, inside: Bools) -> float:
    """Return the intersection, 0 to 1, of the histograms of colours (h, w, 3) inside (h, w) and outside of an object.

    Of M. J. Swain and D. H. Ballard, "Color indexing", 1991.
    """
    bins = cv2.cvtColor(picture, cv2.COLOR_RGB2LAB).astype(np.int64) // BIN
    colour = np.ravel_multi_index((*np.moveaxis(bins, 2, 0),), (256 // BIN,) * 3)
    shares = [np.bincount(colour[side], minlength=(256 // BIN) ** 3) / side.sum() for side in (inside, ~inside)]
    return float(np.minimum(*shares).sum())


def share_of_border(inside: Bools) -> float:
    """Return the share of a picture's border that lies inside (h, w) of an object."""
    return float(np.concatenate([inside[0], inside[-1], inside[:, 0], inside[:, -1]]).mean())
