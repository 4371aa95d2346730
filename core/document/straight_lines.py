"""Which lines of a document's picture are to stay straight."""

from weakref import WeakKeyDictionary

import numpy as np

from core.arrays import Points, readonly
from core.document.document import Document
from core.imaging.image import Image
from core.imaging.proxy import scale_for
from core.mapping.features.straight_lines import Lines
from core.selection.features import MARKED
from core.selection.long_lines import LOOKED_PX, are_long, find_lines, lengths_of, long_lines_within

_lines: WeakKeyDictionary[Image, Points] = WeakKeyDictionary()
"""All of each picture, which are looked for once."""
_found: WeakKeyDictionary[Image, tuple[tuple[object, ...], Lines | None]] = WeakKeyDictionary()
"""What was asked for last of each picture, and the answer."""


def straight_lines_of(document: Document) -> Lines | None:
    """Return the lines that are to stay straight, None for none: long ones of the picture, and those of features."""
    numbers = tuple(feature.number for feature in document.said if feature.keeps_lines)
    key = document.warp.straight, numbers, document.mask if numbers else None, document.numbers if numbers else None
    known = _found.get(document.image)
    if known is None or known[0] != key:
        _found[document.image] = known = key, _chosen(document, numbers)
    return known[1]


def _chosen(document: Document, of_features: tuple[int, ...]) -> Lines | None:
    if not document.warp.straight and not of_features:
        return None
    image = document.image
    if image not in _lines:
        _lines[image] = readonly(find_lines(image))
    lines, numbers = _lines[image], document.numbers
    long = are_long(lines, image.size_px)
    chosen = [lines[long]] if document.warp.straight else []
    if of_features and numbers is not None:
        step = max(1, int(1 / scale_for(image, LOOKED_PX)))
        own = np.where(document.mask.array[::step, ::step] > MARKED, numbers.array[::step, ::step], 0)
        others = lines[~long] if document.warp.straight else lines
        chosen += [long_lines_within(others, own == number, image.size_px) for number in of_features]
    ends = np.concatenate(chosen)
    return Lines(readonly(ends[np.argsort(-lengths_of(ends), kind="stable")]))
