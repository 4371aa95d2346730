from collections import Counter
from typing import get_args

import numpy as np
import pytest

from app.actions import chord_of
from app.actions.table import ActionTable
from app.actions.view import OF_MODE
from app.model.events import Key, Modifiers
from app.model.requests import AskUnsaved, ShowPanel
from app.model.session import Heat
from app.tools.all import TOOLS
from core.document.document import CurvePair, Mode, Outline, Pin
from core.rasters.raster import Raster
from core.warps.presets import PRESETS
from tests.app.driver import EditorDriver

TABLE = ActionTable(TOOLS)


@pytest.fixture
def drive() -> EditorDriver:
    return EditorDriver()


def key(name: str, **mods: bool) -> Key:
    return Key(name, Modifiers(**mods))


def test_names_are_unique_and_everything_is_explained() -> None:
    assert len(TABLE.by_name) == len(TABLE.actions)
    for action in TABLE.actions:
        assert action.label
        assert action.tooltip
        assert action.menu


MODE_OF = {
    "look": "retexture",
    "retexture": "retexture",
    "feature": "retexture",
    "shown": "overlay",
    "overlay": "overlay",
}
"""Modes to which actions belong, by the first part of their names."""


def is_in(mode: Mode, name: str) -> bool:
    """Return whether an action can be run in a mode."""
    kind, rest = name.split(".", 1)
    return mode in TOOLS[rest].modes if kind == "tool" else MODE_OF.get(kind, mode) == mode


@pytest.mark.parametrize("mode", ["warp", "retexture", "overlay"])
def test_no_two_actions_share_a_key_in_one_mode(mode: Mode) -> None:
    chords = Counter(
        chord
        for action in TABLE.actions
        for chord in (action.chord, *action.more_chords)
        if chord and is_in(mode, action.name)
    )
    assert [chord for chord, count in chords.items() if count > 1] == []


@pytest.mark.parametrize(
    ("pressed", "chord"),
    [
        (key("z", ctrl=True, shift=True), "Ctrl+Shift+Z"),
        (key("f1"), "F1"),
        (key("k", shift=True, alt=True, ctrl=True), "Ctrl+Alt+Shift+K"),
        (key("delete"), "Delete"),
        (key("\\", shift=True), "Shift+\\"),
        (key("1", alt=True), "Alt+1"),
    ],
)
def test_chords_are_named_as_on_the_keyboard(pressed: Key, chord: str) -> None:
    assert chord_of(pressed) == chord


@pytest.mark.parametrize("name", [action.name for action in TABLE.actions])
def test_every_action_runs_and_is_undone(name: str, drive: EditorDriver) -> None:
    action = TABLE.by_name[name]
    if action.try_run(drive.editor):
        drive.frame()
        if action.checked is not None and not name.startswith(("warp.keep", "view.overlay", "view.split")):
            assert action.checked(drive.editor) or name in (
                "warp.vertical_axis",
                "handles.frame",
                "handles.snap_outline",
                "select.contiguous",
                "timeline.loop",
                "view.unwarped",
            )
    drive.editor.go_to(0)
    assert drive.document is drive.start


def test_keys_reach_actions(drive: EditorDriver) -> None:
    assert TABLE.press(key("i", ctrl=True), drive.editor)
    assert drive.mask.min() == 255
    assert TABLE.press(key("z", ctrl=True), drive.editor)
    assert drive.document is drive.start
    assert TABLE.press(key("y", ctrl=True), drive.editor)
    assert drive.mask.min() == 255
    assert not TABLE.press(key("f9"), drive.editor)


def test_before_lasts_as_long_as_its_key(drive: EditorDriver) -> None:
    before = TABLE.by_name["view.before"]
    assert before.checked is not None
    TABLE.press(key("\\"), drive.editor)
    assert before.checked(drive.editor)
    assert TABLE.release("\\", drive.editor)
    assert not before.checked(drive.editor)
    assert not TABLE.release("\\", drive.editor)


def test_fit_shows_all_of_the_picture(drive: EditorDriver) -> None:
    drive.editor.edit("Bulge", drive.document.with_warp(preset="arc", bend=100))
    drive.frame()
    TABLE.run("view.fit", drive.editor)
    view = drive.editor.session.view
    screen = drive.editor.answer.warped * view.zoom + view.pan
    assert (screen >= 0).all()
    assert (screen <= view.size).all()


def test_a_preset_bends_at_once_and_reset_takes_it_back(drive: EditorDriver) -> None:
    TABLE.run("warp.preset.arc", drive.editor)
    assert drive.document.warp.bend == 50
    TABLE.run("warp.preset.flag", drive.editor)
    assert drive.document.warp.preset == "flag"
    TABLE.run("warp.reset", drive.editor)
    assert drive.document.warp == drive.start.warp
    assert len([name for name in TABLE.by_name if name.startswith("warp.preset.")]) == len(PRESETS)


def test_handles_are_removed_together(drive: EditorDriver) -> None:
    pins = (Pin((0.5, 0.5), (0.6, 0.5)),)
    drive.editor.edit("Put", drive.document.changed(pins=pins, outline=Outline.straight()))
    TABLE.run("handles.select_all", drive.editor)
    assert drive.editor.session.selected == {0}
    TABLE.run("handles.reset", drive.editor)
    assert drive.document.pins == ()
    assert drive.document.outline is None
    assert drive.labels == ("Put", "Remove all handles")
    assert not TABLE.run("handles.reset", drive.editor)


def test_disabled_actions_do_nothing(drive: EditorDriver) -> None:
    assert not TABLE.run("edit.undo", drive.editor)
    assert not TABLE.run("file.export", drive.editor)
    assert not TABLE.run("mask.clear", drive.editor)


@pytest.mark.parametrize("mode", ["warp", "retexture", "overlay"])
def test_what_can_be_pressed_on_an_untouched_picture_does_something(mode: Mode) -> None:
    """But for what is chosen already, and what gives the view the zoom that it has."""
    idle = []
    for action in TABLE.actions:
        drive = EditorDriver()
        drive.editor.choose_mode(mode)
        drive.frame()
        editor = drive.editor
        before = editor.document, editor.session, editor.is_closing
        is_chosen = action.checked is not None and action.checked(editor)
        if action.try_run(editor) and not (is_chosen or editor.requests or editor.notices):
            drive.frame()
            if before == (editor.document, editor.session, editor.is_closing):
                idle.append(action.name)
    assert idle == ["view.actual"]


def test_what_acts_on_features_waits_for_one(drive: EditorDriver) -> None:
    for name in ("tool.split", "features.chosen", "mask.grow", "mask.save"):
        assert not TABLE.run(name, drive.editor), name
    TABLE.run("mask.fill", drive.editor)
    for name in ("tool.split", "mask.grow", "mask.save"):
        assert TABLE.run(name, drive.editor), name
    drive.editor.show(features=frozenset({1}))
    assert TABLE.run("features.chosen", drive.editor)


def test_what_is_regrown_is_not_painted_before_anybody_paints_it(drive: EditorDriver) -> None:
    drive.editor.choose_mode("retexture")
    assert not TABLE.run("mask.grow", drive.editor)
    drive.editor.edit("Paint", drive.document.changed(regrow=Raster.filled(*drive.document.size_px, 0)))
    assert TABLE.run("mask.clear", drive.editor)
    assert not TABLE.run("mask.clear", drive.editor)


def test_the_warp_is_left_alone_where_it_is_not_seen(drive: EditorDriver) -> None:
    drive.editor.choose_mode("overlay")
    for name in ("warp.preset.arc", "warp.keep.rigid", "warp.vertical_axis", "handles.frame", "warp.export"):
        assert not TABLE.run(name, drive.editor), name


def test_the_first_frame_has_none_before_it_and_the_last_none_after_it(drive: EditorDriver) -> None:
    assert not TABLE.run("timeline.first", drive.editor)
    assert not TABLE.run("timeline.previous", drive.editor)
    assert TABLE.run("timeline.last", drive.editor)
    assert not TABLE.run("timeline.next", drive.editor)
    assert TABLE.run("timeline.previous", drive.editor)


def test_sources_of_curves_wait_for_curves(drive: EditorDriver) -> None:
    drive.tool("curves")
    assert not TABLE.run("handles.edit_source", drive.editor)
    line = np.linspace((0.2, 0.2), (0.8, 0.2), 4)
    drive.editor.edit("Draw", drive.document.changed(curves=(CurvePair(line, line),)))
    assert TABLE.run("handles.edit_source", drive.editor)


def test_panels_are_asked_of_the_window(drive: EditorDriver) -> None:
    for name, panel in (("edit.history", "history"), ("help.palette", "palette"), ("help.keys", "keys")):
        TABLE.run(name, drive.editor)
        request = drive.editor.requests.pop()
        assert isinstance(request, ShowPanel)
        assert request.panel == panel


def test_quitting_with_changes_asks_first(drive: EditorDriver) -> None:
    TABLE.run("mask.invert", drive.editor)
    TABLE.run("file.quit", drive.editor)
    assert not drive.editor.is_closing
    request = drive.editor.requests.pop()
    assert isinstance(request, AskUnsaved)
    request.then("cancel")
    assert not drive.editor.is_closing
    request.then("discard")
    assert drive.editor.is_closing


def test_every_overlay_has_a_switch(drive: EditorDriver) -> None:
    for name in set(drive.editor.session.overlays.__dataclass_fields__) - {"heat"}:
        drive.editor.choose_mode(OF_MODE.get(name, "warp"))
        before = getattr(drive.editor.session.overlays, name)
        assert TABLE.run(f"view.overlay.{name}", drive.editor)
        assert getattr(drive.editor.session.overlays, name) != before


@pytest.mark.parametrize("heat", get_args(Heat))
def test_every_heat_map_has_a_switch(drive: EditorDriver, heat: Heat) -> None:
    assert TABLE.run(f"view.overlay.{heat}", drive.editor)
    assert drive.editor.session.overlays.heat == heat
    assert TABLE.run(f"view.overlay.{heat}", drive.editor)
    assert drive.editor.session.overlays.heat is None


def test_overlays_of_another_mode_cannot_be_switched(drive: EditorDriver) -> None:
    drive.editor.choose_mode("retexture")
    assert not TABLE.run("view.overlay.grid", drive.editor)
    assert TABLE.run("view.overlay.spines", drive.editor)


def test_zooming_keeps_the_middle(drive: EditorDriver) -> None:
    before = drive.picture_at(100, 75)
    drive.editor.show(view=drive.editor.session.view.__class__(size=(200.0, 150.0)))
    TABLE.run("view.zoom_in", drive.editor)
    assert np.allclose(drive.picture_at(100, 75), before)
