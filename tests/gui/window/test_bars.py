"""What the bars do beside a press on their buttons: tools of one group, a double click, the zoom in the status bar."""

from pathlib import Path

import pytest
from imgui_bundle import imgui

from app.actions.view import whole
from app.editor.editor import Editor
from app.tools.all import SELECTING
from tests.gui.window.test_small_windows import bar
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui


@pytest.mark.parametrize("way", ["right button", "held"])
def test_a_button_that_stands_for_several_tools_lists_them(editor: Editor, tmp_path: Path, way: str) -> None:
    def script(window: WindowDriver) -> None:
        window.wait(4).context.mouse_move(f"//{bar('##Left')}/###{SELECTING[0].label}")
        if way == "right button":
            window.context.mouse_click(1)
        else:
            window.context.mouse_down(0)
            window.wait(40).context.mouse_up(0)
        window.wait(3).screenshot(tmp_path / "group.png")
        window.item("//$FOCUSED/###of group lasso").wait(2)
        assert editor.session.tool == "lasso"
        window.wait(2).item(f"//{bar('##Left')}/###Lasso")

    drive(editor, script)
    assert editor.session.select_tool == "lasso"


def test_escape_closes_the_list_of_tools_and_keys_choose_tools_again(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.wait(4).context.mouse_move(f"//{bar('##Left')}/###{SELECTING[0].label}")
        window.context.mouse_click(1)
        window.wait(3)
        assert imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
        window.key(imgui.Key.escape)
        window.wait(3)
        assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
        window.key(imgui.Key.q)
        window.wait(3)

    drive(editor, script)
    assert editor.session.tool == "object"


def test_a_double_click_on_hand_and_magnifier_fits_the_picture_and_shows_it_one_to_one(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.wait(4).context.mouse_move(f"//{bar('##Left')}/###Zoom")
        window.context.mouse_double_click(0)
        window.wait(2)
        assert editor.session.view.zoom == 1
        window.context.mouse_move(f"//{bar('##Left')}/###Hand")
        window.context.mouse_double_click(0)
        window.wait(2)
        assert editor.session.view == whole(editor)

    drive(editor, script)


def test_the_zoom_is_chosen_and_typed_in_the_status_bar(editor: Editor, tmp_path: Path) -> None:
    def script(window: WindowDriver) -> None:
        window.wait(4)
        size = imgui.get_main_viewport().size

        def open_list() -> None:
            window.context.mouse_move_to_pos(imgui.ImVec2(size.x - 36, size.y - 12))
            window.context.mouse_click(0)
            window.wait(3)

        open_list()
        window.screenshot(tmp_path / "zooms.png")
        window.item("//$FOCUSED/200 %").wait(2)
        assert editor.session.view.zoom == pytest.approx(2)
        open_list()
        window.context.item_input_value("//$FOCUSED/##zoom", 75.0)
        window.wait(3)
        assert editor.session.view.zoom == pytest.approx(0.75)
        open_list()
        window.item("//$FOCUSED/Fit picture").wait(2)
        assert editor.session.view == whole(editor)

    drive(editor, script)
