"""What a selection does to what is painted: the mask of Warp mode, or a mask of another mode."""

from collections.abc import Callable

import numpy as np

from app.editor.editor import Editor
from app.editor.painting import BLANK, LAYERS, Layer, choose_raster, layer, show_painted, with_layer
from app.marking.feature_list import rows_of
from app.model.events import Modifiers
from core.arrays import Bytes
from core.document.document import Document
from core.progress import Job
from core.rasters.raster import Raster
from core.selection.combining import Combining, combine
from core.selection.features import MARKED, MOST, extend_numbers, free_number, number_area

LABELS: dict[Combining, str] = {"replace": "Select", "add": "Add", "subtract": "Cut out", "intersect": "Intersect"}


def choose_combining(editor: Editor, mods: Modifiers) -> Combining:
    """Return how a selection meets what is painted: as chosen, or Shift adds, Alt cuts out and both intersect."""
    if mods.shift or mods.alt:
        return "intersect" if mods.shift and mods.alt else "add" if mods.shift else "subtract"
    return editor.session.selecting.how


def take_selection(document: Document, name: Layer, found: Bytes, how: Combining, part: int | None) -> Document:
    """Return the document with a selection (H, W) taken into what is called `name`.

    Of the mask, what is added gets the number `part`; None leaves it without.
    """
    before = layer(document, name)
    blank = BLANK.get(name, 0)
    if blank and how == "replace":
        values = combine(np.full_like(found, blank), found, "add")
    elif blank and how == "intersect":
        values = np.where(found > MARKED, before.array, np.uint8(blank))
    else:
        values = combine(before.array, found, how)
    mask = Raster.from_array(values).sharing(before)
    if name != "mask":
        return with_layer(document, name, mask)
    if how == "replace":
        document = document.changed(numbers=None, features=())
    if part is None or how not in ("replace", "add"):
        return with_grown(document, name, mask, touching=True)
    document = with_layer(document, name, mask)
    return document.changed(numbers=number_area(document.numbers, found > MARKED, part))


def with_grown(document: Document, name: Layer, raster: Raster, *, touching: bool = False) -> Document:
    """Return the document with a raster exchanged; what it marks anew belongs to the features beside it.

    With `touching` only to those that it touches.
    """
    if name == "mask" and document.numbers is not None:
        numbers = extend_numbers(document.numbers, document.mask, raster, touching=touching)
        document = document.changed(numbers=numbers)
    return with_layer(document, name, raster)


def number_for(editor: Editor) -> int | None:
    """Return the number that what is painted or selected next gets: a new one, the chosen one, or None."""
    if choose_raster(editor) != "mask" or editor.session.part == "joined":
        return None
    if editor.session.part == "new":
        document = editor.document
        taken = {feature.number for feature in document.features}
        first = 1 + max((row.order for row in rows_of(editor)), default=0)  # it comes last in the list
        return free_number(document.numbers, taken=taken, first=first)
    chosen = [number for number in editor.session.features if number <= MOST]
    return chosen[0] if editor.document.numbers is not None and len(chosen) == 1 else None


def select(editor: Editor, what: str, found: Bytes, how: Combining) -> None:
    """Take a selection (H, W) as one undo entry."""
    show_painted(editor)
    name = choose_raster(editor)
    label = f"{LABELS[how]} {what}"
    editor.edit(label, take_selection(editor.document, name, found, how, number_for(editor)))


def select_later(editor: Editor, what: str, how: Combining, find: Callable[[], Job[Bytes]]) -> None:
    """Look for a selection beside the window, and take it if nothing was painted meanwhile."""
    show_painted(editor)
    name, image = choose_raster(editor), editor.document.image
    before, part = layer(editor.document, name), number_for(editor)

    def apply(document: Document, found: Bytes) -> Document | None:
        fits = document.image is image and np.shape(found) == (document.size_px[1], document.size_px[0])
        is_same = layer(document, name).is_empty if before.is_empty else layer(document, name) is before
        return take_selection(document, name, found, how, part) if fits and is_same else None

    editor.start(f"{LABELS[how]} {what}", find, apply)


def refine(editor: Editor, label: str, change: Callable[[Bytes], Bytes]) -> None:
    """Change what is painted by a function of all of it, as one undo entry."""
    name = choose_raster(editor)
    before = layer(editor.document, name)
    after = Raster.from_array(change(before.array)).sharing(before)
    editor.edit(f"{label} {LAYERS[name]}", with_grown(editor.document, name, after))
