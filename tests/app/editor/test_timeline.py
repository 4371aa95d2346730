"""The timeline without a window: frames, keys that edits make, playing, undo, saving."""

from pathlib import Path

import numpy as np
import pytest

from app.actions.table import ActionTable
from app.files import document_io
from app.marking import keying
from app.tools.all import TOOLS
from core.arrays import Points
from core.document.document import Pin, pixels_from_places
from core.document.keys import KeyFrame
from core.document.map_solver import settle_map
from core.document.project import load_project
from core.progress import run
from tests.app.driver import EditorDriver, document

TABLE = ActionTable(TOOLS)


@pytest.fixture
def drive() -> EditorDriver:
    """Return an editor whose bend is 0 at frame 1 and 60 at frame 61, evenly, and that shows frame 61."""
    made = EditorDriver(document().with_warp(preset="arc", bend=0.0))
    keying.set_keys(made.editor, ("bend",))
    made.editor.animation.go_to(61)
    made.editor.edit("Bend", made.document.with_warp(bend=60.0))
    keying.ease_keys(made.editor, {"bend": (1, 61)}, "linear")
    return made.frame()


def keys(drive: EditorDriver) -> list[tuple[float, float]]:
    return [(key.frame, key.value[0]) for key in drive.document.tracks.get("bend", ())]


def warped(drive: EditorDriver) -> Points:
    return drive.frame().editor.answer.warped


def test_what_has_keys_gets_one_where_it_is_changed(drive: EditorDriver) -> None:
    assert keys(drive) == [(1, 0), (61, 60)]
    drive.editor.animation.go_to(31)
    assert drive.document.warp.bend == 30
    assert keys(drive) == [(1, 0), (61, 60)], "to go to a frame changes nothing"
    for bend in (10.0, 20.0):
        drive.editor.slide("Bend", drive.document.with_warp(bend=bend))
    drive.editor.finish()
    drive.editor.edit("Horizontal", drive.document.with_warp(horizontal=5.0))
    assert keys(drive) == [(1, 0), (31, 20), (61, 60)]
    assert set(drive.document.tracks) == {"bend"}, "what has no keys is changed at all frames"
    drive.editor.animation.go_to(1)
    assert (drive.document.warp.bend, drive.document.warp.horizontal) == (0, 5)
    drive.undo().undo()
    assert keys(drive) == [(1, 0), (61, 60)]
    assert drive.document.warp.bend == 0, "undo keeps the frame"


def test_a_pin_that_has_keys_gets_one_where_it_is_dragged(drive: EditorDriver) -> None:
    drive.tool("pins").click(100, 75)
    drive.editor.animation.go_to(1)
    TABLE.run("timeline.set_keys", drive.editor)
    (first,) = drive.document.pins[0].keys
    drive.editor.animation.go_to(11)
    x, y = pixels_from_places(drive.editor.canvas_px, np.array(first.value)).tolist()
    drive.drag((x, y), (x + 10, y), (x + 20, y + 15))
    before, now = drive.document.pins[0].keys
    assert before == first
    assert now.frame == 11
    assert np.subtract(now.value, first.value) * drive.editor.canvas_px == pytest.approx((20, 15))
    drive.editor.animation.go_to(1)
    assert drive.document.pins[0].to == first.value
    drive.editor.animation.go_to(11)
    assert drive.document.pins[0].to == now.value


def test_every_frame_is_answered_live_and_is_what_a_batch_makes_of_it(drive: EditorDriver) -> None:
    drive.editor.animation.go_to(21)
    live = warped(drive)
    drive.editor.animation.go_to(51)
    assert np.abs(warped(drive) - live).max() > 5
    drive.editor.animation.go_to(21)
    np.testing.assert_allclose(warped(drive), live, atol=1e-6)
    still = drive.start.with_warp(preset="arc", bend=20.0)
    np.testing.assert_array_equal(drive.rest().editor.answer.warped, run(settle_map(still)).warped)


def test_keys_are_moved_eased_and_removed_and_all_of_it_is_undone(drive: EditorDriver) -> None:
    start = drive.document
    for by in (5, -10, -30):
        keying.move_keys(drive.editor, start, {"bend": (61.0,)}, by)
    drive.editor.finish()
    assert keys(drive) == [(1, 0), (31, 60)]
    assert drive.document.warp.bend == 60
    assert drive.labels[-1] == "Move key"
    assert keying.find_chosen_keys(drive.editor) == {"bend": {31}}
    assert TABLE.by_name["timeline.easing.hold"].enabled(drive.editor)
    keying.select_keys(drive.editor, [("bend", 1)])
    TABLE.run("timeline.easing.hold", drive.editor)
    drive.editor.animation.go_to(30)
    assert drive.document.warp.bend == 0
    keying.select_keys(drive.editor, [("bend", 1), ("bend", 31)])
    TABLE.run("timeline.remove_keys", drive.editor)
    assert not drive.document.tracks
    assert drive.document.warp.bend == 0
    assert drive.labels[-3:] == ("Move key", "Easing", "Remove keys")
    drive.undo().undo().undo()
    assert keys(drive) == [(1, 0), (61, 60)]
    assert drive.document.warp.bend == 29


def test_keys_that_are_moved_onto_others_replace_them(drive: EditorDriver) -> None:
    keying.move_keys(drive.editor, drive.document, {"bend": (1.0,)}, 60)
    drive.editor.finish()
    assert keys(drive) == [(61, 0)]


def test_to_go_through_frames_is_no_change_of_the_project(drive: EditorDriver, tmp_path: Path) -> None:
    drive.editor.project_path = tmp_path / "a.weft"
    document_io.save(drive.editor)
    drive.frame()
    assert drive.editor.history.is_saved
    drive.editor.animation.go_to(17)
    drive.frame()
    assert drive.editor.history.is_saved
    assert len(drive.labels) == len(drive.editor.history.labels) - 1
    back = load_project(tmp_path / "a.weft")
    assert back.tracks["bend"] == (KeyFrame(1, (0.0,)), KeyFrame(61, (60.0,)))
    other = EditorDriver(back).editor
    assert (other.session.frame, other.session.timeline, other.document.warp.bend) == (1, True, 0)


def test_playing_follows_the_clock_loops_and_stops_at_the_end(drive: EditorDriver) -> None:
    editor = drive.editor
    keying.set_span(editor, last=64)
    keying.set_span(editor, rate=10)
    assert TABLE.run("timeline.play", editor)
    assert editor.session.frame == 61
    assert editor.wait_s is not None
    for seconds, frame in ((0.05, 61), (0.1, 62), (0.2, 64), (0.1, 1), (0.5, 6)):
        drive.clock.now += seconds
        drive.frame()
        assert editor.session.frame == frame
    editor.edit("Bend", drive.document.with_warp(bend=3.0))
    assert not editor.animation.is_playing
    assert (6, 3) in keys(drive)
    TABLE.run("timeline.loop", editor)
    TABLE.run("timeline.play", editor)
    drive.clock.now += 99
    drive.frame()
    assert (editor.session.frame, editor.animation.is_playing) == (64, False)
    TABLE.run("timeline.play", editor)
    assert editor.session.frame == 1, "from the end it begins anew"


def test_the_hand_on_the_picture_ends_playing(drive: EditorDriver) -> None:
    drive.tool("pins")
    TABLE.run("timeline.play", drive.editor)
    drive.clock.now += 0.2
    frame = drive.frame().editor.session.frame
    drive.press(100, 75)
    drive.clock.now += 1
    drive.move(110, 80).release(110, 80)
    assert not drive.editor.animation.is_playing
    assert drive.editor.session.frame == frame
    assert len(drive.document.pins) == 1


def test_steps_go_from_frame_to_frame_and_from_key_to_key(drive: EditorDriver) -> None:
    seen = []
    for name in ("first", "next", "next_key", "next_key", "previous", "previous_key", "last", "next"):
        TABLE.run(f"timeline.{name}", drive.editor)
        seen.append(drive.editor.session.frame)
    assert seen == [1, 2, 61, 61, 60, 1, 100, 100]


def test_frames_out_of_order_are_refused_with_a_notice(drive: EditorDriver) -> None:
    keying.set_span(drive.editor, last=0)
    assert drive.document.span.last == 100
    assert drive.editor.notices[-1].text == "Timeline: frames 1 to 0 are out of order, or too many"


def test_another_preset_keeps_the_keys_it_can_have(drive: EditorDriver) -> None:
    TABLE.run("warp.preset.flag", drive.editor)
    keying.set_keys(drive.editor, ("waves",))
    assert set(drive.document.tracks) == {"bend", "waves"}
    TABLE.run("warp.preset.bulge", drive.editor)
    assert set(drive.document.tracks) == {"bend"}
    assert drive.frame().editor.fault is None
    TABLE.run("warp.reset", drive.editor)
    assert not drive.document.tracks
    assert drive.document.warp == drive.start.with_warp(preset=None, bend=0.0).warp


def test_a_pasted_warp_brings_its_keys_and_makes_none(drive: EditorDriver) -> None:
    drive.editor.animation.go_to(31)
    TABLE.run("warp.copy", drive.editor)
    drive.editor.animation.go_to(41)
    drive.editor.edit("Pins", drive.document.changed(pins=(Pin((0.5, 0.5), (0.6, 0.5)),)))
    TABLE.run("warp.paste", drive.editor)
    assert keys(drive) == [(1, 0), (61, 60)]
    assert (drive.document.warp.bend, drive.document.pins) == (40, ())
