"""Retexture mode on a small woven picture, driven by events."""

import numpy as np

from app.model.jobs import Jobs
from core.arrays import Points
from core.document.document import Document, pixels_from_places
from core.imaging.image import Image
from tests.app.driver import EditorDriver

WIDTH, HEIGHT = 200, 150


def woven() -> Image:
    """Return a picture of fine texture: noise that runs along x."""
    random = np.random.default_rng(1)
    noise = random.random((HEIGHT, WIDTH + 8, 3))
    smooth = np.mean([noise[:, i : i + WIDTH] for i in range(8)], axis=0)
    return Image((255 * smooth).astype(np.uint8))


def start() -> Document:
    return Document.of(woven()).with_warp(cell_px=2.0).with_retexture(along_px=21, across_px=15, search_along_px=9)


def driver(jobs: Jobs | None = None, document: Document | None = None) -> EditorDriver:
    drive = EditorDriver(document or start(), jobs=jobs)
    drive.editor.choose_mode("retexture")
    return drive.tool("feature-curves").frame()


def drawn(drive: EditorDriver) -> EditorDriver:
    """Draw a curve across the picture."""
    return drive.drag((50, 70), (60, 70)).drag((100, 70), (110, 70)).drag((150, 70), (160, 70)).key("enter")


def moved(drive: EditorDriver) -> EditorDriver:
    return drawn(drive).drag((100, 70), (100, 90))


def target(drive: EditorDriver) -> Points:
    return pixels_from_places(drive.document.size_px, drive.document.feature_curves[0].target)


def source(drive: EditorDriver) -> Points:
    return pixels_from_places(drive.document.size_px, drive.document.feature_curves[0].source)


def shown(drive: EditorDriver) -> Image:
    return drive.editor.regrowth.choose_picture(drive.document, drive.editor.session.look).image
