"""Masks and files, and masks that are fitted to what they cover."""

from pathlib import Path

import numpy as np

from app.editor.editor import Editor
from app.editor.painting import LAYERS, layer, painted, with_layer
from app.files import filing
from app.model.requests import PICTURES, PROJECTS, OpenFile
from core.document.document import Document
from core.document.project import load_project
from core.imaging.images import Image, load, mask_of, save
from core.masks.mask_files import said_of_mask
from core.masks.object_masks import object_under
from core.notices import notice
from core.progress import Job, Progress
from core.rasters.raster import Raster

MASK_FILES = ("png", "tif", "tiff")


def ask_mask(editor: Editor) -> None:
    """Ask for a mask, as a picture or from another project, and load it."""
    editor.requests.append(OpenFile("Load mask", PICTURES + PROJECTS, lambda path: load_mask_from(editor, path)))


def load_mask_from(editor: Editor, path: Path) -> None:
    """Take the mask in a picture of the same size, or in another project, where it is resized."""
    size_px = editor.document.size_px

    def steps() -> Job[Raster]:
        yield Progress(0.0, "reading")
        image = None if filing.is_project(path) else load(path)
        mask = load_project(path).mask if image is None else Raster.from_array(mask_of(image, path, size_px))
        array = mask.array
        notice(said_of_mask(image or Image(array[..., None]), array))
        return mask

    name = painted(editor)
    apply = lambda document, mask: with_layer(document, name, mask.resized(*document.size_px))  # noqa: E731
    editor.start(f"Load {LAYERS[name]}", steps, apply)


def ask_save_mask(editor: Editor) -> None:
    """Ask where to save what is painted, as a grey picture that can be loaded as a mask, and do it."""
    editor.finish()
    name = painted(editor)
    mask = layer(editor.document, name)

    def writing(path: Path) -> Job[None]:
        yield Progress(0.0, "writing")
        save(Image(np.asarray(mask.array)[..., None]), path)

    filing.ask_save_beside(editor, f"Save {LAYERS[name]}", MASK_FILES, f"{LAYERS[name].replace(' ', '-')}.png", writing)


def fit_to_objects(editor: Editor) -> None:
    """Let what is painted roughly become the mask of the objects under it."""
    editor.finish()
    name, image = painted(editor), editor.document.image
    rough = layer(editor.document, name)

    def steps() -> Job[Raster]:
        return Raster.from_array((yield from object_under(image, rough.array)))

    def apply(document: Document, fitted: Raster) -> Document | None:
        return with_layer(document, name, fitted) if layer(document, name) is rough else None

    editor.start(f"Fit {LAYERS[name]} to objects", steps, apply)
