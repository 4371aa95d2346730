"""Where the export dialog writes to."""

from pathlib import Path

import numpy as np
import pytest

from app.requests import ExportOptions, ExportPicture
from app.ui.export_dialog import ExportDialog
from tests.app.driver import document


def dialog(folder: Path) -> ExportDialog:
    request = ExportPicture(document(), ExportOptions(folder / "horses-weft.png", (200, 150)), lambda _: None)
    return ExportDialog(request, np.zeros((2, 2, 2)) + [[[0, 0], [199, 0]], [[0, 149], [199, 149]]])


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("out.png", "out.png"),
        ("out", "out.png"),
        ("horses v1.2", "horses v1.2.png"),
        ("sub/out.JPEG", "sub/out.JPEG"),
        ("/elsewhere/out.tif", "/elsewhere/out.tif"),
    ],
)
def test_a_name_is_in_the_folder_of_the_picture_and_ends_in_its_format(tmp_path: Path, name: str, path: str) -> None:
    asked = dialog(tmp_path)
    asked.write_to(name)
    assert asked.path == tmp_path / path


def test_a_format_changes_the_ending_alone(tmp_path: Path) -> None:
    asked = dialog(tmp_path)
    asked.write_to("horses v1.2")
    asked.choose_format("tif")
    assert asked.path == tmp_path / "horses v1.2.tif"
    asked.choose_format("jpg")
    assert asked.path == tmp_path / "horses v1.2.jpg"
    asked.write_to("herd")
    assert asked.path == tmp_path / "herd.jpg"
