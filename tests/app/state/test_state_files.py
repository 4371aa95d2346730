"""What the program keeps for itself never stops it from starting, however it is damaged."""

from pathlib import Path

import pytest

from app.commands.edit import editor_on
from app.files.document_io import recent_files
from app.model.jobs import Jobs
from app.state.preferences import Preferences, load_preferences
from core.notices import hear_notices
from tests.app.driver import document

DAMAGED = ["", "{", "[" * 200_000, "\0", "5", '"text"', "\ud800".encode("utf-8", "surrogatepass"), "1" * 10_000]


@pytest.mark.parametrize("text", DAMAGED)
def test_a_damaged_file_is_set_aside_and_said_once(tmp_path: Path, text: str | bytes) -> None:
    file = tmp_path / "preferences.json"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with hear_notices() as heard:
        assert load_preferences(file) == Preferences()
        assert load_preferences(file) == Preferences()
    assert heard == [f"{file} was damaged: it is set aside, and Weft begins without it"]
    assert not file.exists()
    assert (tmp_path / "preferences.json.damaged").exists()


def test_values_out_of_range_are_taken_into_it_or_left_out(tmp_path: Path) -> None:
    file = tmp_path / "preferences.json"
    file.write_text('{"undo_mb": 1e400, "scale": NaN, "keep_every_s": -7, "drafts": 3, "unknown": [[[]]]}')
    assert load_preferences(file) == Preferences(undo_mb=16384.0, keep_every_s=2.0)


def test_a_list_of_files_holds_names_only(tmp_path: Path) -> None:
    file = tmp_path / "recent.json"
    file.write_text('["/a.png", 5, null, ["/b.png"], "/c\\u0000.png", "/d.png"]')
    assert recent_files(file) == ("/a.png", "/d.png")


def test_the_editor_starts_on_damaged_files_and_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for variable in ("XDG_CONFIG_HOME", "XDG_STATE_HOME"):
        monkeypatch.setenv(variable, str(tmp_path))
    (tmp_path / "weft" / "recovery").mkdir(parents=True)
    for name in ("preferences.json", "recent.json", "recovery/a.json", "recovery/a.weft"):
        (tmp_path / "weft" / name).write_text("[" * 100_000)
    editor = editor_on(document(), None, Jobs.inline())
    assert len(editor.notices) == 2
    assert editor.requests


def test_the_editor_starts_where_no_folder_can_be_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "weft").write_text("in the way")
    for variable in ("XDG_CONFIG_HOME", "XDG_STATE_HOME"):
        monkeypatch.setenv(variable, str(tmp_path))
    editor = editor_on(document(), tmp_path / "a.png", Jobs.inline())
    assert editor.preferences == Preferences()
    assert editor.requests == []
