"""Another size of the result, and a proposal of what to keep in it where nothing is painted."""

from dataclasses import replace
from weakref import WeakKeyDictionary

from app.editor.editor import Editor
from core.arrays import Bytes, Singles
from core.document.document import Document
from core.imaging.image import Image
from core.progress import Job
from core.rasters.raster import Raster
from core.selection.importance import importance, propose, propose_objects

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
    """Look for the objects that stand out, and make them the mask if nothing else was painted meanwhile."""
    image, share = editor.document.image, editor.session.resizing.share

    def steps() -> Job[tuple[Singles, Bytes]]:
        known = _found.get(image)
        found = (yield from importance(image)) if known is None else known
        return found, (yield from propose_objects(image, found, share))

    def apply(document: Document, result: tuple[Singles, Bytes]) -> Document | None:
        _found[image], objects = result
        if document.image is not image or not (document.mask.is_empty or is_proposal(document)):
            return None
        now = editor.session.resizing.share
        return _proposing(document, objects) if share == now else with_proposal(document, now)

    editor.start(PROPOSE, steps, apply)


def with_proposal(document: Document, share: float) -> Document:
    """Return the document with a quick proposal of about `share` of the picture, 0 to 1, as its mask."""
    found = _found.get(document.image)
    return document if found is None else _proposing(document, propose(found, share, document.size_px))


def _proposing(document: Document, proposed: Bytes) -> Document:
    mask = Raster.from_array(proposed)
    _proposed[mask] = True
    return document.changed(mask=mask, numbers=None)
