"""The mask in a file, as a part of a document, and what is said of the features in it."""

from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np

from core.arrays import InputError
from core.document.document import Document
from core.document.feature import Feature
from core.imaging.reading import load, mask_of
from core.masks.mask_files import marks_of
from core.notices import notice
from core.rasters.raster import Raster
from core.selection.features import MARKED, MOST


def with_mask_file(document: Document, path: Path) -> Document:
    """Return `document` with the features that the picture `path` marks and no others; of labels, one for each.

    Raises `InputError` that names the file, for another size than the picture's too; labels are a notice.
    """
    found = load(path)
    mask, numbers, said = marks_of(found, mask_of(found, path, document.size_px))
    if numbers is not None:
        notice(f"{path}: {said}")
    labels = None if numbers is None else Raster.from_array(numbers)
    return document.changed(mask=Raster.from_array(mask), numbers=labels, features=())


def with_said(document: Document, said: Iterable[Feature], *, only_there: bool = False) -> Document:
    """Return `document` with something else said of features, by the numbers that they have in a report.

    With `only_there`, what is said of a feature that is not there is left out. Raises `InputError` for one that is not
    there, and for more features than can have numbers.
    """
    said = tuple(said)
    if not said:
        return document
    numbers = document.numbers
    if numbers is None:
        count, parts = cv2.connectedComponents((document.mask.array > MARKED).astype(np.uint8), connectivity=8)
        if count - 1 > MOST:
            raise InputError(f"the mask has {count - 1} features: something can be said of {MOST} at most")
        numbers = Raster.from_array(parts.astype(np.uint8))
    there = set(np.unique(numbers.array).tolist())
    by_number = {feature.number: feature for feature in document.said}
    for feature in said:
        if feature.number in there:
            by_number[feature.number] = feature
        elif not only_there:
            raise InputError(f"feature {feature.number}: the mask has none of that number")
    return document.changed(numbers=numbers, features=tuple(by_number[n] for n in sorted(by_number)))
