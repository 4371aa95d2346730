"""What work leaves out goes on as a line beside it, on the command line and in the window."""

from pathlib import Path

import pytest

from app.__main__ import main
from app.editor.errands import Notice
from app.files.document_io import export
from app.model.requests import ExportOptions
from app.render.picture_file import exporting
from core.document.document import Document
from core.document.project import save_project
from core.imaging.images import Attribute, Image, load
from tests.app.driver import EditorDriver
from tests.core.pictures import picture

pytestmark = pytest.mark.gpu


def document() -> Document:
    return Document.of(Image(picture().pixels, metadata=(Attribute("Artist", "float", "nobody"),)))


def test_the_command_line_says_what_was_left_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    project, out = tmp_path / "a.weft", tmp_path / "out.png"
    save_project(document(), project)
    assert main(["render", str(project), "-o", str(out)]) == 0
    assert capsys.readouterr().err == f"weft: note: {out}: written without metadata that it cannot hold: Artist\n"
    assert load(out).size_px == (7, 5)


def test_the_window_says_what_was_left_out(tmp_path: Path) -> None:
    drive, out = EditorDriver(document()), tmp_path / "out.png"
    drive.editor.exporter = exporting
    export(drive.editor, ExportOptions(out, (7, 5)))
    drive.frame()
    said = f"{out}: written without metadata that it cannot hold: Artist"
    assert drive.editor.notices == [Notice("Exported out.png"), Notice(said)]
