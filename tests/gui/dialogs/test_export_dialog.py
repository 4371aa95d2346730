"""Where the export dialog writes to."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from app.model.requests import ExportOptions, ExportPicture
from app.ui.dialogs.export import ExportDialog
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
    ],
)
def test_a_name_is_in_the_folder_of_the_picture_and_ends_in_its_format(tmp_path: Path, name: str, path: str) -> None:
    (tmp_path / "sub").mkdir()
    asked = dialog(tmp_path)
    asked.write_to(name)
    assert asked.fault == ""
    assert asked.path == tmp_path / path
    asked.write_to(str(tmp_path / "sub" / "other.tif"))
    assert asked.path == tmp_path / "sub" / "other.tif"


@pytest.mark.parametrize(
    "name", ["", " ", "/", "//", ".", "..", "~", "~nobody-of-that-name", "sub/", "none/a", "a" * 5000, "a\0"]
)
def test_a_name_that_no_file_can_have_is_said(tmp_path: Path, name: str) -> None:
    (tmp_path / "sub").mkdir()
    asked = dialog(tmp_path)
    asked.write_to(name)
    assert asked.fault
    assert asked.path == tmp_path / "horses-weft.png"
    asked.write_to("out.png")
    assert asked.fault == ""
    assert asked.path == tmp_path / "out.png"


@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text(st.sampled_from("/.~ a\\é\0*\n\t\u202e名:|<>-"), max_size=12))
def test_random_names_are_answered(tmp_path: Path, name: str) -> None:
    asked = dialog(tmp_path)
    asked.write_to(name)
    asked.choose_format("exr")
    assert asked.path.suffix == ".exr"
    assert asked.path.name


def test_a_format_changes_the_ending_alone(tmp_path: Path) -> None:
    asked = dialog(tmp_path)
    asked.write_to("horses v1.2")
    asked.choose_format("tif")
    assert asked.path == tmp_path / "horses v1.2.tif"
    asked.choose_format("jpg")
    assert asked.path == tmp_path / "horses v1.2.jpg"
    asked.write_to("herd")
    assert asked.path == tmp_path / "herd.jpg"
