"""Modifiers of the pointer: what tools get for what is held, what hints say, and setting others."""

import pytest

from app.model.events import Modifiers
from app.model.pointer_keys import PAN, POINTER_KEYS, assigned, translate, with_own_pointer, word
from app.tools.all import TOOLS

WEFT = assigned("weft", ())


def held(*names: str) -> Modifiers:
    return Modifiers(**dict.fromkeys(names, True))


def test_every_tool_that_is_named_is_there_and_says_its_modifiers() -> None:
    assert {tool for key in POINTER_KEYS for tool in key.tools} <= set(TOOLS)
    assert len({key.name for key in POINTER_KEYS}) == len(POINTER_KEYS)


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("mods", [held(), held("shift"), held("alt"), held("shift", "alt"), held("ctrl")])
def test_wefts_own_modifiers_are_left_as_they_are(tool: str, mods: Modifiers) -> None:
    assert translate(mods, tool, WEFT) == mods
    assert word(TOOLS[tool].hint, tool, WEFT) == TOOLS[tool].hint


def test_others_stand_for_those_that_a_tool_asks_for() -> None:
    keys = with_own_pointer((), "weft", "pointer.select.add", "Ctrl+Shift")
    chords = assigned("weft", keys)
    assert translate(held("ctrl", "shift"), "wand", chords).shift
    assert not translate(held("shift"), "wand", chords).shift
    assert translate(held("shift"), "pins", chords).shift
    assert translate(held("ctrl", "shift", "alt"), "wand", chords) == held("shift", "alt", "ctrl")
    assert word("Shift adds · Alt cuts out", "wand", chords) == "Ctrl+Shift adds · Alt cuts out"
    assert word("Shift+[ ] hardness · Shift-click a line", "brush", assigned("krita", ())) == (
        "Shift+[ ] hardness · Alt-click a line"
    )


def test_one_that_another_of_the_group_has_is_exchanged_and_none_means_never() -> None:
    keys = with_own_pointer((("tool.pins", "Y"),), "weft", "pointer.brush.line", "Alt")
    assert keys == (("pointer.brush.line", "Alt"), ("pointer.brush.size", "Shift"), ("tool.pins", "Y"))
    never = assigned("weft", with_own_pointer(keys, "weft", "pointer.brush.line", ""))
    assert not translate(held("shift", "ctrl", "alt"), "brush", never).shift
    assert translate(held("shift"), "brush", never).alt
    assert never[PAN] == "Space"


def test_kritas_users_zoom_out_and_size_brushes_as_there() -> None:
    krita, photoshop = assigned("krita", ()), assigned("photoshop", ())
    assert translate(held("ctrl"), "zoom", krita).alt
    assert not translate(held("alt"), "zoom", krita).alt
    assert translate(held("shift"), "brush", krita) == held("alt")
    assert photoshop == WEFT
