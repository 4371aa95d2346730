"""Stories from an empty window to the exported file, by mouse and keys."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from imgui_bundle import hello_imgui, imgui

from app.editor.editor import Editor
from app.marking.feature_list import rows_of
from app.model.jobs import Jobs
from app.render.picture_file import exporting
from app.tools.all import TOOLS
from core.arrays import Bools, Bytes
from core.document.document import Document
from core.imaging.images import Image, load, save
from tests.core.selection.test_importance import two_discs
from tests.gui.tools.test_select_tools import on_screen
from tests.gui.window_driver import WindowDriver, drive

pytestmark = [pytest.mark.gui, pytest.mark.slow]


@pytest.fixture
def editor() -> Iterator[Editor]:
    """Make an editor on a picture of nothing much."""
    jobs = Jobs()
    yield Editor(Document.of(Image(np.full((40, 60, 3), 128, np.uint8))), TOOLS, jobs=jobs, exporter=exporting)
    jobs.close()


def open_picture(window: WindowDriver, path: Path) -> None:
    """Open a picture by the dialog."""
    editor = window.editor
    window.move(300, 300).key(imgui.Key.mod_ctrl, imgui.Key.o).wait(3)
    window.context.item_input_value("//Open/##name", str(path))
    window.wait_until(lambda: editor.name == path.name).wait(6)


def settle(window: WindowDriver) -> None:
    editor = window.editor
    window.wait(3).wait_until(lambda: editor.jobs.is_idle and not editor.is_busy and editor.live.is_settled).wait(3)


def export(window: WindowDriver, path: Path) -> Bytes:
    """Export by the dialog, and return the file's pixels."""
    editor = window.editor
    window.move(300, 300).key(imgui.Key.mod_ctrl, imgui.Key.e).wait(3)
    window.context.item_input_value("//Export picture/##file", str(path))
    if window.wait(3).dialog is not None:
        window.item("//Export picture/Export")
    window.wait_until(lambda: path.exists() and editor.jobs.is_idle)
    return np.asarray(load(path).pixels)


def widths_over_heights(area: Bools) -> list[float]:
    """Return the ratio of both sides of each large part of an area, from the left."""
    count, _, stats, _ = cv2.connectedComponentsWithStats(area.astype(np.uint8))
    large = [row for row in stats[1:count] if row[cv2.CC_STAT_AREA] > 300]
    return [row[cv2.CC_STAT_WIDTH] / row[cv2.CC_STAT_HEIGHT] for row in sorted(large, key=lambda row: row[0])]


def test_a_picture_is_made_square_and_what_stands_out_stays_round(editor: Editor, tmp_path: Path) -> None:
    save(two_discs()[0], tmp_path / "discs.png")
    files: list[Bytes] = []

    def script(window: WindowDriver) -> None:
        open_picture(window, tmp_path / "discs.png")
        window.item("//Warp/Resize##page").wait(2).item("//Warp/1:1").wait(3)
        settle(window)
        files.append(export(window, tmp_path / "square.png"))

    drive(editor, script)
    (pixels,) = files
    assert pixels.shape[:2] == (300, 300)
    orange = pixels[..., 0].astype(int) - pixels[..., 2] > 60
    assert widths_over_heights(orange) == pytest.approx([1.0, 1.0], abs=0.05)


def test_letters_without_ground_ride_a_flag_and_keep_their_shape(editor: Editor, tmp_path: Path) -> None:
    pixels = np.zeros((200, 500, 4), np.uint8)
    for number, letter in enumerate("OHO"):
        cv2.putText(pixels, letter, (40 + 150 * number, 150), cv2.FONT_HERSHEY_DUPLEX, 4.0, (200, 60, 30, 255), 14)
    save(Image(pixels), tmp_path / "letters.png")
    files: list[Bytes] = []

    def script(window: WindowDriver) -> None:
        open_picture(window, tmp_path / "letters.png")
        window.context.set_ref("##MainMenuBar")
        window.context.menu_click("Mask/###mask.transparency")
        window.context.set_ref("")
        window.wait(3).item("//Warp/**/Flag")
        settle(window)
        files.append(export(window, tmp_path / "flag.png"))

    drive(editor, script)
    result = editor.map.result
    assert result is not None
    assert len(result.features) == 3
    assert max(feature.residual for feature in result.features) < 1e-6
    (written,) = files
    assert written.shape[2] == 4
    assert cv2.connectedComponents((written[..., 3] > 127).astype(np.uint8))[0] == 4


def test_a_wing_is_lifted_by_two_pins(editor: Editor, tmp_path: Path) -> None:
    pixels = np.full((300, 400, 3), (190, 210, 230), np.uint8)
    cv2.ellipse(pixels, (150, 170), (60, 100), 0, 0, 360, (40, 40, 50), -1)
    cv2.ellipse(pixels, (260, 170), (70, 18), 0, 0, 360, (30, 120, 60), -1)
    save(Image(pixels), tmp_path / "penguin.png")
    files: list[Bytes] = []

    def script(window: WindowDriver) -> None:
        open_picture(window, tmp_path / "penguin.png")
        window.key(imgui.Key.w).click(*on_screen(editor, (280, 170))[0])
        window.wait_until(lambda: not editor.document.mask.is_empty)
        window.key(imgui.Key.p).wait(2)
        shoulder, tip = on_screen(editor, (205, 170), (318, 170))
        window.click(*shoulder).wait(40).click(*tip).wait(40)
        window.drag(tip, (tip[0] - 4, tip[1] - 25), (tip[0] - 10, tip[1] - 50))
        settle(window)
        window.screenshot(tmp_path / "wing.png")
        files.append(export(window, tmp_path / "lifted.png"))

    drive(editor, script)
    result = editor.map.result
    assert result is not None
    (wing,) = result.features
    assert wing.residual < 1e-6
    assert wing.angle_deg < -10
    assert not result.missed_pins
    (written,) = files
    green = written[..., 1].astype(int) - written[..., 0] > 50
    assert green.nonzero()[0].min() < 140


def test_in_a_square_one_feature_stays_rigid_and_the_other_similar(editor: Editor, tmp_path: Path) -> None:
    save(two_discs()[0], tmp_path / "discs.png")
    files: list[Bytes] = []

    def script(window: WindowDriver) -> None:
        open_picture(window, tmp_path / "discs.png")
        window.item("//Warp/Resize##page").wait(2).item("//Warp/1:1").wait(3)
        settle(window)
        hello_imgui.get_runner_params().docking_params.focus_dockable_window("Features")
        left = min(rows_of(editor), key=lambda row: row.box[0])
        window.wait(4).item(f"//Features/**/feature {left.id}/##row").wait(2).item("//Features/Rigid##keep one")
        settle(window)
        window.screenshot(tmp_path / "kept.png")
        files.append(export(window, tmp_path / "square.png"))

    drive(editor, script)
    (pixels,) = files
    assert pixels.shape[:2] == (300, 300)
    orange = (pixels[..., 0].astype(int) - pixels[..., 2] > 60).astype(np.uint8)
    _, _, stats, _ = cv2.connectedComponentsWithStats(orange)
    discs = sorted((row for row in stats[1:] if row[cv2.CC_STAT_AREA] > 300), key=lambda row: row[0])
    rigid, similar = (row[[cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].tolist() for row in discs)
    assert rigid == pytest.approx([121, 121], abs=4)
    assert similar == pytest.approx([0.6 * 91, 0.6 * 91], abs=4)
