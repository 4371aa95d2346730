"""The timeline in the window: keys on sliders and pins, scrubbing, dragging keys, playing, and the way to a batch."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui

from app.cli import main
from app.editor.editor import Editor
from app.files import document_io
from app.tools.pins import targets_on_screen
from app.ui.panels.timeline_chart import TimelineChart
from core.document.document import Document, Pin, pixels_from_places
from core.document.keys import KeyFrame
from core.document.project import load_project
from core.imaging.images import load, save
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui


class Timeline:
    """The pointer on the timeline of the window."""

    def __init__(self, window: WindowDriver) -> None:
        self.window = window
        self.chart: TimelineChart = window.shell.workspace.timeline_panel.chart

    def drag(self, *places: ImVec2) -> None:
        context = self.window.context
        context.mouse_move_to_pos(places[0])
        self.window.wait(2)
        context.mouse_down(0)
        for place in places[1:]:
            self.window.wait(2)
            context.mouse_move_to_pos(place)
        self.window.wait(2)
        context.mouse_up(0)
        self.window.wait(2)

    def scrub(self, *frames: float) -> None:
        self.drag(*(self.chart.ruler_place(frame) for frame in frames))


def keys(document: Document) -> list[tuple[float, tuple[float, ...], str]]:
    return [(key.frame, tuple(np.round(key.value, 6).tolist()), key.easing) for key in document.tracks.get("bend", ())]


def test_a_slider_gets_keys_and_scrubbing_shows_the_way_between(editor: Editor) -> None:
    bends: list[float] = []
    moved: list[float] = []

    def script(window: WindowDriver) -> None:
        editor.edit("Preset", editor.document.with_warp(preset="arc"))
        window.key(imgui.Key.mod_shift, imgui.Key.t).wait(8)
        assert editor.session.timeline
        timeline = Timeline(window)
        window.item("//Warp/key bend").wait(2)
        timeline.scrub(20, 41)
        assert editor.session.frame == 41
        window.context.item_input_value("//Warp/Bend/##number", 80.0)
        window.wait(4)
        at_key = editor.map.warped
        for frame in (1, 11, 21, 31, 41):
            timeline.scrub(frame)
            bends.append(editor.document.warp.bend)
            moved.append(float(np.abs(editor.map.warped - editor.map.rest).max()))
        np.testing.assert_allclose(editor.map.warped, at_key, atol=1e-3)

    drive(editor, script)
    assert keys(editor.document) == [(1, (0,), "ease"), (41, (80,), "ease")]
    assert bends == pytest.approx([0, 80 * 0.15625, 40, 80 * 0.84375, 80])
    assert moved[0] < 1e-6
    assert all(np.diff(moved) > 3)
    assert editor.history.labels[-2:] == ("Set key", "Bend")


def test_a_pin_is_animated_by_dragging_it_at_another_frame(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        editor.show(timeline=True)
        editor.choose_tool("pins")
        window.wait(8).click(300, 200)
        window.key(imgui.Key.mod_shift, imgui.Key.k).wait(2)
        Timeline(window).scrub(50)
        x, y = targets_on_screen(editor)[0]
        window.drag((x, y), (x + 20, y), (x + 40, y - 30)).wait(2)

    drive(editor, script)
    first, last = editor.document.pins[0].keys
    assert (first.frame, last.frame) == (1, 50)
    shift = np.subtract(last.value, first.value) * editor.canvas_px * editor.session.view.zoom
    assert shift == pytest.approx((40, -30), abs=1)


def with_keys(editor: Editor) -> None:
    tracks = {"bend": (KeyFrame(1, (0.0,)), KeyFrame(31, (60.0,)), KeyFrame(61, (0.0,)))}
    pins = (Pin((0.5, 0.5), (0.5, 0.5), keys=(KeyFrame(1, (0.5, 0.5)), KeyFrame(61, (0.5, 0.6)))),)
    editor.edit("Keys", editor.document.with_warp(preset="arc").changed(tracks=tracks, pins=pins))
    editor.show(timeline=True)


def test_keys_are_added_moved_eased_removed_and_brought_back(editor: Editor) -> None:
    seen: list[list[tuple[float, tuple[float, ...], str]]] = []

    def script(window: WindowDriver) -> None:
        with_keys(editor)
        timeline = Timeline(window.wait(8))
        place = timeline.chart.place

        def look() -> None:
            window.wait(2)
            seen.append(keys(editor.document))

        timeline.drag(place("bend", 31), place("bend", 25), place("bend", 41))
        look()
        window.context.mouse_move_to_pos(place("bend", 41))
        window.context.mouse_click(1)
        window.wait(2).item("//$FOCUSED/Hold")
        look()
        window.context.mouse_move_to_pos(place("bend", 51))
        window.context.mouse_double_click(0)
        look()
        corner = place("bend", 45)
        timeline.drag(ImVec2(corner.x, corner.y - 4), place(0, 70))
        assert editor.session.selected_keys == {("bend", 51), ("bend", 61), (0, 61)}
        window.key(imgui.Key.delete)
        look()
        assert len(editor.document.pins[0].keys) == 1
        for _ in range(4):
            window.key(imgui.Key.mod_ctrl, imgui.Key.z)
        look()

    drive(editor, script)
    start = [(1, (0,), "linear"), (31, (60,), "linear"), (61, (0,), "linear")]
    moved = [start[0], (41, (60,), "linear"), start[2]]
    held = [start[0], (41, (60,), "hold"), start[2]]
    assert seen == [moved, held, [*held[:2], (51, (60,), "hold"), held[2]], held[:2], start]
    assert len(editor.document.pins[0].keys) == 2


def test_escape_puts_back_the_keys_that_are_dragged(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        with_keys(editor)
        timeline = Timeline(window.wait(8))
        window.context.mouse_move_to_pos(timeline.chart.place("bend", 31))
        window.wait(2).context.mouse_down(0)
        window.wait(2).context.mouse_move_to_pos(timeline.chart.place("bend", 50))
        window.wait(2)
        assert [frame for frame, _, _ in keys(editor.document)] == [1, 50, 61]
        window.key(imgui.Key.escape).wait(2).context.mouse_up(0)
        window.wait(2)

    drive(editor, script)
    assert [frame for frame, _, _ in keys(editor.document)] == [1, 31, 61]
    assert editor.history.labels[-1] == "Keys"


def test_it_plays_in_a_loop_until_it_is_told_to_stop(editor: Editor) -> None:
    seen: list[int] = []

    def script(window: WindowDriver) -> None:
        with_keys(editor)
        window.wait(8).context.item_input_value("//Timeline/##to", 12)
        window.wait(2).context.item_input_value("//Timeline/##fps", 200)
        window.wait(2).key(imgui.Key.mod_shift, imgui.Key.space)
        assert editor.animation.is_playing

        def is_round() -> bool:
            seen.append(editor.session.frame)
            return any(b < a for a, b in pairwise(seen))

        window.wait_until(is_round)
        window.key(imgui.Key.mod_shift, imgui.Key.space).wait(2)
        assert not editor.animation.is_playing

    drive(editor, script)
    assert set(seen) <= set(range(1, 13))
    assert editor.document.span.last == 12
    assert editor.history.is_saved is False


def test_a_project_keeps_its_keys_and_batch_makes_its_frames_as_the_window_shows_them(
    editor: Editor, tmp_path: Path
) -> None:
    project = tmp_path / "a.weft"
    shown = []

    def script(window: WindowDriver) -> None:
        with_keys(editor)
        window.wait(4)
        editor.project_path = project
        document_io.save(editor)
        window.wait_until(lambda: editor.history.is_saved)
        document_io.open_path(editor, project)
        window.wait_until(lambda: not editor.jobs.long_jobs).wait(8)
        assert editor.session.timeline
        Timeline(window).scrub(31)
        window.wait_until(lambda: editor.live.is_settled)
        shown.append(editor.map.warped)

    drive(editor, script)
    assert keys(load_project(project)) == keys(editor.document) != []
    assert main(["batch", str(project), "--frames", "1,31", "-o", str(tmp_path / "f.##.png")]) == 0
    still = [load(tmp_path / f"f.{frame}.png").pixels for frame in ("01", "31")]
    assert (still[0] != still[1]).any()
    assert editor.document.warp.bend == 60
    words = ["--preset", "arc", "--bend", "60", "--cell", "20", "--handles", str(tmp_path / "h.json")]
    (pin,) = editor.document.pins
    at, to = (pixels_from_places(editor.document.size_px, np.array(place)) for place in (pin.at, pin.to))
    (tmp_path / "h.json").write_text(f'{{"pins": [{{"at": {at.tolist()}, "to": {to.tolist()}}}]}}')
    source = tmp_path / "p.png"
    save(editor.document.image, source)
    output, found = tmp_path / "one.png", tmp_path / "m.npz"
    assert main(["warp", str(source), *words, "--frame", "picture", "-o", str(output), "--map", str(found)]) == 0
    np.testing.assert_allclose(np.load(found)["warped"], shown[0], atol=1e-6)
    np.testing.assert_array_equal(load(output).pixels, still[1])
