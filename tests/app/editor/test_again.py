"""Done once, done again: export to the same file on one key, and one picture's warp pasted on another."""

from pathlib import Path

import numpy as np
import pytest

from app.actions.table import ActionTable
from app.files import document_io
from app.model.requests import ExportOptions, ExportPicture
from app.tools.all import TOOLS
from core.document.document import CurvePair, Document, Outline, Pin
from core.imaging.images import Image
from core.progress import Job, Progress
from tests.app.driver import EditorDriver

TABLE = ActionTable(TOOLS)


@pytest.fixture
def drive() -> EditorDriver:
    return EditorDriver()


def test_export_again_writes_the_present_result_to_the_same_file(drive: EditorDriver, tmp_path: Path) -> None:
    written: list[tuple[float, ExportOptions]] = []

    def exporter(document: Document, options: ExportOptions) -> Job[None]:
        yield Progress(0.5)
        written.append((document.warp.bend, options))

    editor = drive.editor
    editor.exporter = exporter
    again = TABLE.by_name["file.export_again"]
    assert not again.enabled(editor)
    editor.edit("Bend", editor.document.with_warp(preset="arc", bend=10.0))
    document_io.ask_export(editor)
    (request,) = editor.requests
    assert isinstance(request, ExportPicture)
    editor.requests.clear()
    width, height = editor.document.canvas_px
    request.then(ExportOptions(tmp_path / "out.jpg", (width // 2, height // 2), quality=80))
    drive.frame()
    editor.edit("Bend", editor.document.with_warp(bend=30.0, aspect=(2.0, 1.0)))
    assert again.try_run(editor)
    drive.frame()
    assert [bend for bend, _ in written] == [10.0, 30.0]
    assert written[1][1] == ExportOptions(tmp_path / "out.jpg", (width, height // 2), quality=80)
    assert not editor.requests
    editor.source_path = tmp_path / "another.png"
    assert not again.enabled(editor)


def test_a_warp_is_pasted_on_a_picture_of_another_size(drive: EditorDriver) -> None:
    editor = drive.editor
    assert not TABLE.by_name["warp.paste"].enabled(editor)
    line = np.array([[0.2, 0.5], [0.4, 0.5], [0.6, 0.5], [0.8, 0.5]])
    made = editor.document.with_warp(preset="arc", bend=40.0).changed(
        pins=(Pin((0.25, 0.5), (0.3, 0.6)),), curves=(CurvePair(line, line + [0, 0.1]),), outline=Outline.straight()
    )
    editor.edit("Make", made)
    TABLE.run("warp.copy", editor)
    other = Document.of(Image(np.zeros((31, 77, 3), np.uint8)))
    editor.edit("Open", other)
    TABLE.run("warp.paste", editor)
    found = editor.document
    assert (found.warp, found.pins, found.curves, found.outline) == (made.warp, made.pins, made.curves, made.outline)
    assert found.image is other.image
    assert found.mask is other.mask
    TABLE.run("edit.undo", editor)
    assert editor.document is other
