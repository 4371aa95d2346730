import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from app.files.typed_paths import resolve_name
from app.ui.dialogs.file_browser import FileBrowser, format_date, list_folder, places


def test_shows_the_whole_way_to_a_relative_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "pictures").mkdir()
    monkeypatch.chdir(tmp_path)
    browser = FileBrowser(("png",), Path("pictures"), name="a.png")
    assert browser.folder == tmp_path / "pictures"
    browser.enter(browser.folder.parent)
    assert browser.folder == tmp_path


def test_blanks_around_a_typed_name_count_only_where_such_a_file_exists(tmp_path: Path) -> None:
    assert resolve_name(tmp_path, " a.png ") == tmp_path / "a.png"
    assert resolve_name(tmp_path, f"{tmp_path}/b.png ") == tmp_path / "b.png"
    (tmp_path / "c.png ").touch()
    assert resolve_name(tmp_path, "c.png ") == tmp_path / "c.png "
    assert resolve_name(tmp_path, "~/d.png") == Path.home() / "d.png"
    (tmp_path / "in").mkdir()
    for name in ("../b.png", "../e.png"):
        assert resolve_name(tmp_path / "in", name) == tmp_path.resolve() / name[3:]


def test_a_name_without_its_ending_is_asked_about_by_its_whole_name(tmp_path: Path) -> None:
    (tmp_path / "horses v1.weft").write_bytes(b"another")
    (tmp_path / "horses v1.2.weft").write_bytes(b"this")
    browser = FileBrowser(("weft",), tmp_path, name="horses.weft")
    assert browser.accepted(tmp_path / "horses v1.3") == tmp_path / "horses v1.3.weft"
    assert browser.accepted(tmp_path / "horses v1.2") is True
    assert browser.accepted(tmp_path / "horses v1.2") == tmp_path / "horses v1.2.weft"
    assert FileBrowser(("png", "jpeg"), tmp_path, name="").accepted(tmp_path / "a.JPEG") == tmp_path / "a.JPEG"


NAMES = [
    "/",
    "//",
    ".",
    "..",
    "~",
    "~nobody-of-that-name",
    "~nobody-of-that-name/a",
    "a" * 5000,
    "a/" * 3000,
    "\\",
    "a\0b",
    " ",
    "\n",
]


@pytest.mark.parametrize("name", [*NAMES, "/root/../root/a", "/dev/null", "/dev/full/a", "."])
@pytest.mark.parametrize("saves", [False, True])
def test_whatever_is_typed_is_answered(tmp_path: Path, name: str, saves: bool) -> None:
    browser = FileBrowser(("png",), tmp_path, name="" if saves else None)
    browser._name = name
    answer = browser.accepted(None)
    assert answer is True or isinstance(answer, Path)


@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text(st.sampled_from("/.~ a\\é\0*\n\t\u202e名:|<>-"), max_size=12), st.booleans())
def test_random_names_are_answered(tmp_path: Path, name: str, saves: bool) -> None:
    browser = FileBrowser(("png",), tmp_path, name="" if saves else None)
    browser._name = name
    answer = browser.accepted(None)
    assert answer is True or (isinstance(answer, Path) and answer.name)


def test_a_name_that_is_not_utf_8_is_listed_and_taken(tmp_path: Path) -> None:
    file = Path(os.fsdecode(os.fsencode(tmp_path) + b"/J\xfcrgen.png"))
    file.write_bytes(b"x")
    (item,) = list_folder(tmp_path, ("png",))
    assert item.path == file
    browser = FileBrowser(("png",), tmp_path)
    browser._name, browser._picked = "Jürgen.png", file
    assert browser.accepted(None) == file


def test_places_are_listed_where_the_working_folder_is_gone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    assert "Here" not in [name for name, _, _ in places()]
    assert FileBrowser(("png",), Path("pictures")).folder


def test_a_date_beyond_the_calendar_is_left_out() -> None:
    assert format_date(1e300) == ""
    assert format_date(0.0).endswith("1970")
