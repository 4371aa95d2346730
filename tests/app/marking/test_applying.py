"""What is painted or selected shows, also where it was hidden before."""

from dataclasses import replace

import pytest

from app.model.session import Overlays
from tests.app.driver import EditorDriver


@pytest.mark.parametrize("tool", ["brush", "rectangle", "wand", "object"])
def test_what_is_painted_or_selected_shows_again(tool: str) -> None:
    drive = EditorDriver()
    drive.editor.show(overlays=replace(Overlays(), mask=False, grid=True))
    drive.tool(tool).click(20, 20) if tool == "wand" else drive.tool(tool).drag((20, 20), (60, 50), (90, 90))
    assert drive.editor.session.overlays == replace(Overlays(), grid=True)
    drive.editor.undo()
    assert drive.editor.session.overlays.mask
