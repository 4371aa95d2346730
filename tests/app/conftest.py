"""An editor whose pattern is found, for all stories of Overlay mode."""

import pytest

from core.document.document import Document
from tests.app.overlay.driver import PHOTO, OverlayDriver


@pytest.fixture(scope="session")
def found() -> Document:
    """Return a document whose pattern is found; all editors share what was found."""
    return OverlayDriver(Document.of(PHOTO)).run("overlay.find").document


@pytest.fixture
def drive(found: Document) -> OverlayDriver:
    drive = OverlayDriver(found)
    assert drive.editor.overlay.is_final
    return drive
