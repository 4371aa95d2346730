"""Masks and files, and masks that are fitted to what they cover."""

from pathlib import Path

import numpy as np

from app.editor.editor import Editor
from app.editor.painting import LAYERS, choose_raster, layer, with_layer
from app.files import document_io
from app.marking.applying import with_grown
from app.marking.feature_list import orders_of
from app.model.requests import PICTURES, PROJECTS, OpenFile
from core.arrays import InputError
from core.document.document import Document
from core.document.project import load_project
from core.imaging.images import Image, load, mask_of, save
from core.masks.mask_files import describe_mask, marks_or_opacity_of
from core.masks.object_masks import object_under
from core.notices import notice
from core.progress import Job, Progress, in_one_step
from core.rasters.raster import Raster
from core.selection.features import number_joined
from core.selection.sources import has_transparency, opacity, opaque_under

MASK_FILES = ("png", "tif", "tiff")


def ask_mask(editor: Editor) -> None:
    """Ask for a mask, as a picture or from another project, and load it."""
    editor.requests.append(OpenFile("Load mask", PICTURES + PROJECTS, lambda path: load_mask_from(editor, path)))


def load_mask_from(editor: Editor, path: Path) -> None:
    """Take the mask in a picture of the same size, or in another project, where it is resized."""
    size_px = editor.document.size_px

    def steps() -> Job[tuple[Raster, Raster | None]]:
        yield Progress(0.0, "reading")
        if document_io.is_project(path):
            other = load_project(path)
            array = other.mask.array
            notice(describe_mask(Image(array[..., None]), array))
            return other.mask, other.numbers
        image = load(path)
        mask, numbers, said = marks_or_opacity_of(image, mask_of(image, path, size_px))
        notice(said)
        return Raster.from_array(mask), None if numbers is None else Raster.from_array(numbers)

    name = choose_raster(editor)

    def apply(document: Document, found: tuple[Raster, Raster | None]) -> Document:
        mask, numbers = found
        if name == "mask":
            numbers = None if numbers is None else numbers.resized(*document.size_px, blends=False)
            return document.changed(mask=mask.resized(*document.size_px), numbers=numbers, features=())
        return with_layer(document, name, mask.resized(*document.size_px))

    editor.start(f"Load {LAYERS[name]}", steps, apply)


def mark_opaque(editor: Editor) -> None:
    """Mark what is not transparent; in Warp mode each part of it that hangs together is a feature."""
    editor.finish()
    try:
        mask = Raster.from_array(opacity(editor.document.image))
    except InputError as fault:
        editor.fail(fault)
        return
    name = choose_raster(editor)
    document = editor.document.changed(numbers=None, features=()) if name == "mask" else editor.document
    editor.edit(f"{LAYERS[name].capitalize()} from transparency", with_layer(document, name, mask))


def ask_save_mask(editor: Editor) -> None:
    """Ask where to save what is painted, as a grey picture that can be loaded as a mask, and do it."""
    editor.finish()
    name = choose_raster(editor)
    mask = layer(editor.document, name)
    write = lambda path: save(Image(np.asarray(mask.array)[..., None]), path)  # noqa: E731
    writing = lambda path: in_one_step("writing", write, path)  # noqa: E731
    document_io.ask_save_beside(
        editor, f"Save {LAYERS[name]}", MASK_FILES, f"{LAYERS[name].replace(' ', '-')}.png", writing
    )


def fit_to_objects(editor: Editor) -> None:
    """Let what is painted roughly become the mask of the objects under it."""
    editor.finish()
    name, image = choose_raster(editor), editor.document.image
    rough = layer(editor.document, name)

    def steps() -> Job[Raster]:
        if has_transparency(image):
            return Raster.from_array(opaque_under(image, rough.array))
        return Raster.from_array((yield from object_under(image, rough.array)))

    def apply(document: Document, fitted: Raster) -> Document | None:
        if layer(document, name) is not rough:
            return None
        if name == "mask":
            document = _apart(editor, document, fitted)
        return with_grown(document, name, fitted)

    is_same = lambda: layer(editor.document, name) is rough  # noqa: E731
    editor.start(f"Fit {LAYERS[name]} to objects", steps, apply, holds=is_same)


def _apart(editor: Editor, document: Document, fitted: Raster) -> Document:
    """Return the document with numbers for its features where a fitted mask joins what was painted apart."""
    numbers = number_joined(document.numbers, document.mask, fitted, orders_of(editor))
    if numbers is document.numbers:
        return document
    editor.notify("What was painted apart stays apart: Make one feature joins what is chosen in the list")
    return document.changed(numbers=numbers)
