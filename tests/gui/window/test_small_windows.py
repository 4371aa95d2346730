"""Small windows and large text: whatever does not fit stands in a menu, nothing lies beyond the window's edge."""

import glfw
import numpy as np
import pytest
from imgui_bundle import glfw_utils, imgui

from app.actions.view import whole
from app.editor.editor import Editor
from app.model.jobs import Jobs
from app.tools.all import TOOLS
from app.ui.options_bar import SWITCHES, TOOL_ACTIONS
from core.document.document import Mode
from core.progress import Job
from tests.app.driver import document
from tests.gui.conftest import endless
from tests.gui.panels.test_ids import ids_in, windows_shown
from tests.gui.window_driver import WindowDriver, drive, inside

pytestmark = pytest.mark.gui

MODES: tuple[Mode, ...] = ("warp", "retexture", "overlay")
SIZES = pytest.mark.parametrize(("size", "scale"), [((800, 500), 2.0), ((900, 600), 1.0), ((1024, 700), 1.5)])
NO_FAULT = int(imgui.test_engine.TestOpFlags_.no_error)


def bar(beginning: str) -> str:
    """Return the name of the bar at a side of the window: "##Top" or "##Left"."""
    return next(name for name in windows_shown() if name.startswith(beginning) and "/" not in name)


def item(window: WindowDriver, path: str) -> imgui.test_engine.TestItemInfo | None:
    """Return what is known of a widget; None where there is none."""
    found = window.context.item_info(path, NO_FAULT)
    return found if found.id_ else None


def lies_in_window(found: imgui.test_engine.TestItemInfo) -> bool:
    """Return whether all of a widget is in the window."""
    low, high, room = found.rect_full.min, found.rect_full.max, imgui.get_io().display_size
    return 0 <= low.x < high.x <= room.x and 0 <= low.y < high.y <= room.y


@SIZES
def test_everything_is_within_reach(editor: Editor, size: tuple[int, int], scale: float) -> None:
    editor.prefer(editor.preferences.changed(scale=scale))

    def script(window: WindowDriver) -> None:
        window.wait(4)
        for mode in MODES:
            choose_mode(window, mode)
            assert editor.session.mode == mode
            first, *_, last = [tool for tool in editor.tools.values() if mode in tool.modes]
            for tool in (first, last):
                choose_tool(window, tool.label)
                assert editor.session.tool == tool.name
                check_options(window)

    drive(editor, script, size=size)


def choose_mode(window: WindowDriver, mode: Mode) -> None:
    """Press the button of a mode, or choose it from the menu that stands in its place."""
    path = f"//##MainMenuBar/##MenuBar/{mode.capitalize()}##mode.{mode}"
    button = item(window, path)
    if button is not None:
        assert lies_in_window(button)
        window.item(path)
    else:
        window.context.set_ref("##MainMenuBar")
        window.context.menu_click(f"Mode/###mode.{mode}")
    window.wait(4)


def choose_tool(window: WindowDriver, label: str) -> None:
    """Press a tool's button, or its row in the menu of the tools that have no room."""
    left = bar("##Left")
    button = item(window, f"//{left}/###{label}")
    if button is not None:
        assert lies_in_window(button)
        window.item(f"//{left}/###{label}")
    else:
        window.item(f"//{left}/###More tools").wait(2)
        window.item(f"//$FOCUSED/{label}")
    window.wait(2)


def check_options(window: WindowDriver) -> None:
    """Check that every action of the bar over the canvas stands there, or in its menu."""
    editor, by_name, top = window.editor, window.shell.workspace.table.by_name, bar("##Top")
    tool = editor.tool.name
    wanted = set(TOOL_ACTIONS.get(f"{tool} in {editor.session.mode}", TOOL_ACTIONS.get(tool, ())))
    wanted |= {name for name in SWITCHES if name and by_name[name].enabled(editor)}
    shown = {name: item(window, f"//{top}/###{name}") for name in wanted}
    assert all(lies_in_window(found) for found in shown.values() if found is not None)
    missing = {name for name, found in shown.items() if found is None}
    if missing:
        window.item(f"//{top}/###More options").wait(2)
        assert missing == {name for name in wanted if item(window, f"//$FOCUSED/###{name}") is not None}
        window.key(imgui.Key.escape).wait(2)


def test_what_has_no_room_in_the_bar_is_done_from_its_menu(editor: Editor) -> None:
    editor.prefer(editor.preferences.changed(scale=2.0))

    def script(window: WindowDriver) -> None:
        editor.choose_tool("brush")
        window.wait(4).item(f"//{bar('##Top')}/###More options").wait(2)
        window.context.item_input_value("//$FOCUSED/Hardness/##number", 35.0)
        window.wait(2).item("//$FOCUSED/###Erase").item("//$FOCUSED/###view.overlay.grid").wait(2)

    drive(editor, script, size=(900, 600))
    assert editor.session.brush.hardness == pytest.approx(0.35)
    assert editor.session.brush.erase
    assert editor.session.overlays.grid


def test_panels_come_back_to_their_width_when_a_small_window_grows_again(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        def column_px() -> float:
            area = window.shell.workspace.canvas.area
            return float(imgui.get_io().display_size.x - area.x - area.width)

        window.wait(6)
        before = column_px()
        resize(window, 640, 420)
        assert column_px() < before - 20
        resize(window, 1440, 900)
        assert column_px() == pytest.approx(before, abs=1)

    drive(editor, script, size=(1440, 900))


@SIZES
def test_panels_keep_room_for_their_controls(editor: Editor, size: tuple[int, int], scale: float) -> None:
    editor.prefer(editor.preferences.changed(scale=scale))
    editor.edit("Preset", editor.document.with_warp(preset="arch", bend=20.0))

    def script(window: WindowDriver) -> None:
        window.wait(4)
        panel = inside("Warp")
        room, em = imgui.get_io().display_size.x, imgui.get_font_size()
        assert min(18.5 * em, 0.44 * room) <= panel.size.x <= max(0.46 * room, 340)
        for control in ("##track", "##number"):
            found = item(window, f"//Warp/Bend/{control}")
            assert found is not None
            assert panel.pos.x <= found.rect_full.min.x
            assert found.rect_full.max.x <= panel.pos.x + panel.size.x
        assert panel.content_size.x <= panel.size.x

    drive(editor, script, size=size)


@pytest.mark.parametrize(("size", "scale"), [((640, 400), 2.0), ((800, 500), 2.0), ((1024, 700), 1.5)])
def test_sliders_have_a_track_to_drag_in_the_narrowest_panel(
    editor: Editor, size: tuple[int, int], scale: float
) -> None:
    editor.prefer(editor.preferences.changed(scale=scale))
    editor.edit("Preset", editor.document.with_warp(preset="arch", bend=20.0))

    def script(window: WindowDriver) -> None:
        for mode, slider in zip(MODES, ("//Warp/Bend", "//Retexture/Length", "//Overlay/Detail"), strict=True):
            editor.choose_mode(mode)
            window.wait(6)
            track, number = item(window, f"{slider}/##track"), item(window, f"{slider}/##number")
            assert track is not None
            assert number is not None
            assert track.rect_full.max.x - track.rect_full.min.x > 2.4 * imgui.get_font_size(), mode
            assert track.rect_full.max.x < number.rect_full.min.x
            assert lies_in_window(number) or number.rect_full.max.y > size[1]

    drive(editor, script, size=size)


@SIZES
def test_dialogs_and_sheets_are_no_larger_than_the_window(editor: Editor, size: tuple[int, int], scale: float) -> None:
    editor.prefer(editor.preferences.changed(scale=scale))

    def script(window: WindowDriver) -> None:
        behind = windows_shown()
        for action in ("file.export", "file.open", "edit.preferences", "help.keys", "help.palette"):
            window.shell.workspace.table.run(action, editor)
            window.wait(4)
            for name in windows_shown() - behind:
                dialog = imgui.internal.find_window_by_name(name)
                low, high = dialog.pos, (dialog.pos.x + dialog.size.x, dialog.pos.y + dialog.size.y)
                assert (low.x, low.y) >= (0, 0), action
                assert np.less_equal(high, size).all(), action
                assert dialog.scroll_max.x < 1, action
                assert "/" in name or ids_in(window, [name]), action
            window.key(imgui.Key.escape).wait(3)
            assert windows_shown() - behind == set(), action

    drive(editor, script, size=size)


def test_the_export_is_said_and_cancelled_in_a_narrow_status_bar() -> None:
    def export(*_: object) -> Job[None]:
        return endless()

    jobs = Jobs()
    editor = Editor(document(600, 400, cell_px=20.0), TOOLS, jobs=jobs, exporter=export)
    editor.prefer(editor.preferences.changed(scale=2.0))

    def script(window: WindowDriver) -> None:
        editor.background("Export " + "a rather " * 20 + "long name.png", endless, lambda _: None)
        window.wait(4)
        cross = item(window, "//StatusBar/###Cancel job")
        assert cross is not None
        assert lies_in_window(cross)
        window.item("//StatusBar/###Cancel job").wait_until(lambda: not editor.jobs.long_jobs)

    drive(editor, script, size=(900, 600))
    jobs.close()


def test_a_picture_seen_whole_stays_whole_in_a_smaller_window(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.wait(6)
        resize(window, 700, 500)
        view = editor.session.view
        assert view == whole(editor)
        assert view.zoom * 600 < view.size[0] < 400
        window.shell.workspace.table.run("view.actual", editor)
        resize(window, 900, 600)
        assert editor.session.view.zoom == 1.0

    drive(editor, script)


def resize(window: WindowDriver, width: int, height: int) -> None:
    """Give the window another size."""
    glfw.set_window_size(glfw_utils.glfw_window_hello_imgui(), width, height)
    window.wait_until(lambda: imgui.get_io().display_size.x == width).wait(4)


def test_a_chord_that_is_let_go_within_a_frame_is_the_chord(editor: Editor) -> None:
    from app.model.events import Modifiers

    def script(window: WindowDriver) -> None:
        editor.edit("Invert", editor.document.with_warp(bend=3.0))
        window.shell.workspace.canvas.hear_key(Modifiers(ctrl=True))
        window.key(imgui.Key.z).wait()

    drive(editor, script)
    assert editor.history.index == 0
    assert editor.session.tool == "brush"


def test_a_dialog_that_is_dragged_or_grows_stays_in_the_window(editor: Editor) -> None:
    places: list[tuple[float, float]] = []

    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("edit.preferences", editor)
        window.wait(4)
        sheet = imgui.internal.find_window_by_name("Preferences")
        for place in ((60, 50), (5000, 5000)):
            window.context.window_move("//Preferences", imgui.ImVec2(*place))
            window.wait(3)
            places.append((sheet.pos.x, sheet.pos.y))
        editor.prefer(editor.preferences.changed(scale=1.5))
        window.wait(4)
        assert sheet.pos.x + sheet.size.x <= 900
        assert sheet.pos.y + sheet.size.y <= 600

    drive(editor, script, size=(900, 600))
    assert places[0] == (60, 50)
    assert max(places[1]) < 600
