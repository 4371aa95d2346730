"""Another size of the result, and a proposal of what to keep in it where nothing is painted."""

from dataclasses import replace
from weakref import WeakKeyDictionary

from app.editor.editor import Editor
from core.arrays import Singles
from core.document.document import Document
from core.imaging.image import Image
from core.progress import Job
from core.rasters.raster import Raster
from core.selection.importance import importance, propose

LEAST_PX, MOST_FACTOR = 8, 8.0
"""Sides of the result have so many pixels at least, and so many times the picture's at most."""
LABEL, PROPOSE = "Resize", "Propose what to keep"

Size = tuple[float, float]


def set_resizing(editor: Editor, **changes: object) -> None:
    """Set how results are resized."""
    editor.show(resizing=replace(editor.session.resizing, **changes))  # type: ignore[arg-type]


def limit_size(document: Document, size: Size) -> Size:
    """Return width and height within what a result may have, in pixels."""
    width, height = (
        min(max(side, LEAST_PX), MOST_FACTOR * most) for side, most in zip(size, document.size_px, strict=True)
    )
    return width, height


def with_size(document: Document, size: Size) -> Document:
    """Return the document with a result of about this width and height in pixels; the first keeps lines straight."""
    width, height = (round(side) for side in limit_size(document, size))
    straight = document.warp.straight or document.warp.aspect == (1.0, 1.0)
    return document.with_warp(aspect=(width / document.size_px[0], height / document.size_px[1]), straight=straight)


def with_ratio(size: Size, ratio: float) -> Size:
    """Return the largest size with a ratio of width to height that fits into `size`."""
    width, height = size
    return (height * ratio, height) if width > height * ratio else (width, width / ratio)


def resize(editor: Editor, size: Size) -> None:
    """Give the result another width and height, as one undo entry."""
    editor.edit(LABEL, with_size(editor.document, size))
    propose_if_bare(editor)


_found: WeakKeyDictionary[Image, Singles] = WeakKeyDictionary()
_proposed: WeakKeyDictionary[Raster, bool] = WeakKeyDictionary()


def is_proposal(document: Document) -> bool:
    """Return whether the mask is what was proposed, and nobody has painted since."""
    return document.mask in _proposed


def propose_if_bare(editor: Editor) -> None:
    """Propose what to keep where nothing is painted, the size is another one and the artist wants proposals."""
    document = editor.document
    if editor.session.resizing.proposes and document.mask.is_empty and document.warp.aspect != (1.0, 1.0):
        propose_kept(editor)


def propose_kept(editor: Editor) -> None:
    """Look for what stands out, and make it the mask if nothing else was painted meanwhile."""
    image = editor.document.image

    def steps() -> Job[Singles]:
        known = _found.get(image)
        return (yield from importance(image)) if known is None else known

    def apply(document: Document, found: Singles) -> Document | None:
        _found[image] = found
        if document.image is not image or not (document.mask.is_empty or is_proposal(document)):
            return None
        return with_proposal(document, editor.session.resizing.share)

    editor.start(PROPOSE, steps, apply)


def with_proposal(document: Document, share: float) -> Document:
    """Return the document with a proposal of about `share` of the picture, 0 to 1, as its mask."""
    found = _found.get(document.image)
    if found is None:
        return document
    mask = Raster.from_array(propose(found, share, document.size_px))
    _proposed[mask] = True
    return document.changed(mask=mask, numbers=None)
