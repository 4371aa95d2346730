"""The mask in a file, as a part of a document."""

from pathlib import Path

from core.document.document import Document
from core.imaging.reading import load, mask_of
from core.masks.mask_files import marks_of
from core.notices import notice
from core.rasters.raster import Raster


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
