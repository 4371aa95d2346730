"""Which lines of a document's picture are to stay straight."""

import numpy as np

from core.arrays import Points, readonly
from core.document.document import Document
from core.imaging.image import Image
from core.imaging.proxy import scale_for
from core.mapping.features.limits import FREE, Limits
from core.mapping.features.straight_lines import Lines
from core.rasters.raster import Raster
from core.selection.features import MARKED
from core.selection.long_lines import LOOKED_PX, are_long, find_lines, lengths_of, long_lines_within


class PictureLines:
    """All straight lines of the picture that was looked at last. Threads may share one."""

    def __init__(self) -> None:
        self._found: tuple[Image, Points] | None = None

    def are_known(self, document: Document) -> bool:
        """Return whether what is to stay straight in a document can be said without a look at its picture."""
        return not any(asked_lines(document)[:2]) or (self._found is not None and self._found[0] is document.image)

    def choose(self, document: Document) -> Lines | None:
        """Return the lines that are to stay straight, None for none: long ones of the picture, those of features."""
        of_all, of_features, mask, numbers = asked_lines(document)
        if not of_all and not of_features:
            return None
        image = document.image
        found = self._found
        if found is None or found[0] is not image:
            self._found = found = image, readonly(find_lines(image))
        lines = found[1]
        long = are_long(lines, image.size_px)
        chosen = [(lines[long], FREE)] if of_all else []
        if mask is not None and numbers is not None:
            step = max(1, int(1 / scale_for(image, LOOKED_PX)))
            own = np.where(mask.array[::step, ::step] > MARKED, numbers.array[::step, ::step], 0)
            for number, limit in of_features:
                others = lines[~long] if of_all and limit == FREE else lines
                chosen.append((long_lines_within(others, own == number, image.size_px), limit))
        ends, limits = np.concatenate([part for part, _ in chosen]), [limit for part, limit in chosen for _ in part]
        order = np.argsort(-lengths_of(ends), kind="stable")
        return Lines(readonly(ends[order]), tuple(limits[i] for i in order))


def asked_lines(document: Document) -> tuple[bool, tuple[tuple[int, Limits], ...], Raster | None, Raster | None]:
    """Return all that the choice of lines of a picture depends on.

    That is whether long ones of all of it stay straight, of which features, within which limits, and the mask and its
    numbers for these.
    """
    of_features = tuple((f.number, f.limits(rigid=False)) for f in document.said if f.keeps_lines)
    masks = (document.mask, document.numbers) if of_features else (None, None)
    return document.warp.straight, of_features, *masks
