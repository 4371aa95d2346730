from pathlib import Path

import pytest

from app.ui.file_browser import FileBrowser, typed


def test_shows_the_whole_way_to_a_relative_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "pictures").mkdir()
    monkeypatch.chdir(tmp_path)
    browser = FileBrowser(("png",), Path("pictures"), name="a.png")
    assert browser.folder == tmp_path / "pictures"
    browser.enter(browser.folder.parent)
    assert browser.folder == tmp_path


def test_blanks_around_a_typed_name_count_only_where_such_a_file_exists(tmp_path: Path) -> None:
    assert typed(tmp_path, " a.png ") == tmp_path / "a.png"
    assert typed(tmp_path, f"{tmp_path}/b.png ") == tmp_path / "b.png"
    (tmp_path / "c.png ").touch()
    assert typed(tmp_path, "c.png ") == tmp_path / "c.png "
    assert typed(tmp_path, "~/d.png") == Path.home() / "d.png"


def test_a_name_without_its_ending_is_asked_about_by_its_whole_name(tmp_path: Path) -> None:
    (tmp_path / "horses v1.weft").write_bytes(b"another")
    (tmp_path / "horses v1.2.weft").write_bytes(b"this")
    browser = FileBrowser(("weft",), tmp_path, name="horses.weft")
    assert browser.accepted(tmp_path / "horses v1.3") == tmp_path / "horses v1.3.weft"
    assert browser.accepted(tmp_path / "horses v1.2") is True
    assert browser.accepted(tmp_path / "horses v1.2") == tmp_path / "horses v1.2.weft"
    assert FileBrowser(("png", "jpeg"), tmp_path, name="").accepted(tmp_path / "a.JPEG") == tmp_path / "a.JPEG"
