from pathlib import Path

import pytest

from app.actions.keys import PRESETS, with_own
from app.actions.table import ActionTable
from app.model.events import Key, Modifiers
from app.state.preferences import Preferences, load_preferences, save_preferences
from app.tools.all import TOOLS
from core.document.document import Mode
from tests.app.driver import EditorDriver
from tests.app.editor.test_actions import is_in


def table(preset: str = "weft", own: tuple[tuple[str, str], ...] = ()) -> ActionTable:
    made = ActionTable(TOOLS)
    made.set_keys(preset, own)
    return made


@pytest.mark.parametrize("preset", list(PRESETS))
@pytest.mark.parametrize("mode", ["warp", "retexture", "overlay"])
def test_no_preset_gives_two_actions_of_a_mode_one_key(preset: str, mode: Mode) -> None:
    made = table(preset)
    assert set(PRESETS[preset]) <= set(made.by_name)
    chords = [
        chord
        for action in made.actions
        for chord in (action.chord, *action.more_chords)
        if chord and is_in(mode, action.name)
    ]
    assert len(chords) == len(set(chords))


def test_a_preset_changes_keys_and_another_takes_them_back() -> None:
    made, drive = table("photoshop"), EditorDriver()
    assert made.press(Key("l"), drive.editor)
    assert drive.editor.session.tool == "lasso"
    assert made.press(Key("m"), drive.editor)
    assert drive.editor.session.tool == "rectangle"
    made.set_keys("weft")
    assert made.press(Key("m"), drive.editor)
    assert not drive.editor.session.overlays.mask


def test_a_key_that_is_set_leaves_the_action_that_had_it() -> None:
    own = with_own((), "tool.pins", "B")
    made = table(own=own)
    assert made.by_name["tool.pins"].chord == "B"
    assert made.by_name["tool.brush"].chord == ""
    own = with_own(own, "tool.hand", "B")
    made.set_keys("weft", own)
    assert made.by_name["tool.hand"].chord == "B"
    assert made.by_name["tool.pins"].chord == "P"
    made.set_keys("weft", with_own(own, "edit.undo", ""))
    drive = EditorDriver()
    assert not made.press(Key("z", Modifiers(ctrl=True)), drive.editor)


def test_keys_are_kept_and_nonsense_is_left_out(tmp_path: Path) -> None:
    file = tmp_path / "preferences.json"
    wished = Preferences(key_preset="krita", keys=(("tool.pins", "B"),))
    save_preferences(file, wished)
    assert load_preferences(file) == wished
    file.write_text('{"keys": [["a", 3], "b", ["tool.hand", "Y"]], "key_preset": 7}')
    assert load_preferences(file) == Preferences(keys=(("tool.hand", "Y"),))
    file.write_text('{"keys": 4, "mask_color": 1e9}')
    assert load_preferences(file).keys == ()
