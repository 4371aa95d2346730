import json
from pathlib import Path

import numpy as np
import pytest

from app.editor.editor import Editor
from app.model.jobs import Jobs
from app.state.preferences import Preferences, load_preferences, save_preferences
from app.state.recovery import Recovery
from app.tools.all import TOOLS
from core.rasters.raster import Raster
from tests.app.driver import document


def test_preferences_come_back(tmp_path: Path) -> None:
    wished = Preferences(undo_mb=100.0, scale=1.5, keep_every_s=30.0, drafts=False)
    save_preferences(tmp_path / "new" / "preferences.json", wished)
    assert load_preferences(tmp_path / "new" / "preferences.json") == wished
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["preferences.json"]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("no json", Preferences()),
        ("[1, 2]", Preferences()),
        ('{"scale": "large", "drafts": 1, "undo_mb": true}', Preferences()),
        ('{"scale": NaN, "colour": "red"}', Preferences()),
        ('{"scale": 99, "undo_mb": -5, "drafts": false}', Preferences(undo_mb=64.0, scale=3.0, drafts=False)),
    ],
)
def test_what_makes_no_sense_is_the_default(tmp_path: Path, text: str, found: Preferences) -> None:
    (tmp_path / "preferences.json").write_text(text)
    assert load_preferences(tmp_path / "preferences.json") == found


def test_no_file_is_the_default(tmp_path: Path) -> None:
    assert load_preferences(tmp_path / "preferences.json") == Preferences()


def test_the_budget_of_undo_is_heard_now_and_for_later_documents() -> None:
    editor = Editor(document(1500, 1200), TOOLS, jobs=Jobs.inline(), preferences=Preferences(undo_mb=64.0))
    assert editor.history.budget_bytes == 64 * 2**20
    editor.prefer(Preferences(undo_mb=128.0))
    assert editor.history.budget_bytes == 128 * 2**20
    editor.replace_document(document(), project=None, source=Path("a.png"))
    assert editor.history.budget_bytes == 128 * 2**20


def test_a_smaller_budget_forgets_the_oldest_with_the_next_edit() -> None:
    editor = Editor(document(4000, 4200), TOOLS, jobs=Jobs.inline())
    noise = np.random.default_rng(0).integers(0, 255, (4200, 4000), dtype=np.uint8)
    for number in range(6):
        editor.edit(f"Mask {number}", editor.document.changed(mask=Raster.from_array(noise + np.uint8(number))))
    assert len(editor.history.labels) == 7
    editor.prefer(Preferences(undo_mb=64.0))
    editor.edit("Last", editor.document.with_warp(bend=3.0))
    assert editor.history.labels[-1] == "Last"
    assert len(editor.history.labels) < 7


def test_kept_preferences_reach_the_file_and_the_recovery(tmp_path: Path) -> None:
    jobs = Jobs.inline()
    editor = Editor(document(), TOOLS, jobs=jobs, recovery=Recovery(jobs, folder=tmp_path / "recovery"))
    editor.preferences_file = tmp_path / "preferences.json"
    editor.prefer(Preferences(keep_every_s=60.0), keep=False)
    assert not editor.preferences_file.exists()
    editor.prefer(editor.preferences.changed(scale=2.0))
    assert json.loads(editor.preferences_file.read_text()) == {
        "undo_mb": 512.0,
        "scale": 2.0,
        "keep_every_s": 60.0,
        "backups": True,
        "drafts": True,
        "solver": "auto",
        "mask_color": 0xF53B57,
        "mask_opacity": 0.4,
        "feature_colors": True,
        "key_preset": "weft",
        "keys": [],
    }
    assert editor.recovery is not None
    assert editor.recovery.every_s == 60.0


def test_a_place_that_cannot_be_written_is_said_and_the_wish_holds(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    editor = Editor(document(), TOOLS, jobs=Jobs.inline())
    editor.preferences_file = tmp_path / "file" / "preferences.json"
    editor.prefer(Preferences(scale=1.5))
    assert editor.preferences.scale == 1.5
    assert editor.notices[-1].level == "error"
    assert "file" in editor.notices[-1].text
