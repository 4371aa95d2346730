"""ST maps and displacements opened as the warp of a picture, from the menu and by a drop."""

from pathlib import Path

import numpy as np
import pytest

from app.actions import dropped
from app.actions.table import ActionTable
from app.cli import main
from app.model.requests import OpenFile
from app.tools.all import TOOLS
from core.document.map_solver import settle_map
from core.imaging.images import Image, save
from core.progress import run
from core.warps.map_file import is_st_map
from tests.app.driver import EditorDriver, document, picture

TABLE = ActionTable(TOOLS)
WIDTH, HEIGHT = 120, 90
SHIFT_PX = 12


def shifted(width: int = WIDTH, height: int = HEIGHT) -> Image:
    """Return the ST map of a result in which the picture's left tenth lies beyond the left edge."""
    y, x = np.mgrid[0:height, 0:width]
    share = (x + 0.5) / width + SHIFT_PX / WIDTH, 1 - (y + 0.5) / height
    return Image(np.stack([*share, np.zeros_like(share[0])], axis=-1).astype(np.float32), linear=True)


@pytest.fixture
def drive() -> EditorDriver:
    return EditorDriver(document(WIDTH, HEIGHT))


def opened(drive: EditorDriver, name: str, path: Path) -> None:
    """Choose `path` in the dialog of an action."""
    assert TABLE.run(name, drive.editor)
    request = drive.editor.requests.pop(0)
    assert isinstance(request, OpenFile)
    request.then(path)
    drive.frame().rest()


def test_an_st_map_bends_the_picture_as_the_command_line_does(drive: EditorDriver, tmp_path: Path) -> None:
    save(shifted(2 * WIDTH, HEIGHT), tmp_path / "st.exr")
    save(picture(WIDTH, HEIGHT), tmp_path / "p.png")
    opened(drive, "file.open_st_map", tmp_path / "st.exr")
    assert drive.document.canvas_px == (2 * WIDTH, HEIGHT)
    words = ["--from-stmap", str(tmp_path / "st.exr"), "--cell", "8", "--map", str(tmp_path / "m.npz")]
    assert main(["warp", str(tmp_path / "p.png"), *words, "-o", str(tmp_path / "out.png")]) == 0
    np.testing.assert_allclose(drive.editor.map.warped, np.load(tmp_path / "m.npz")["warped"], atol=1e-9)
    assert drive.labels == ("Warp st.exr",)
    drive.undo()
    assert drive.document is drive.start


def test_a_displacement_is_opened_too_and_taken_out_again(drive: EditorDriver, tmp_path: Path) -> None:
    plane = np.zeros((HEIGHT, WIDTH, 3), np.float32)
    plane[..., 0] = SHIFT_PX
    save(Image(plane, linear=True), tmp_path / "d.exr")
    opened(drive, "file.open_displacement", tmp_path / "d.exr")
    moved = drive.editor.map.warped - drive.editor.map.rest
    np.testing.assert_allclose(moved[..., 0], -SHIFT_PX, atol=1e-3)
    drive.editor.edit("Bend", drive.document.with_warp(preset="arc", bend=20.0))
    assert np.abs(run(settle_map(drive.document)).warped - drive.editor.map.rest - moved).max() > 3
    assert TABLE.run("file.remove_warp", drive.editor)
    assert drive.document.warp_map is None


def test_a_dropped_st_map_bends_and_a_dropped_picture_is_opened(drive: EditorDriver, tmp_path: Path) -> None:
    save(shifted(), tmp_path / "st.exr")
    light = picture(30, 20).pixels.astype(np.float32) / 255
    save(Image(light, linear=True), tmp_path / "light.exr")
    dropped.take(drive.editor, tmp_path / "st.exr")
    drive.frame()
    assert drive.document.warp_map is not None
    assert drive.editor.notices[-1].text == "st.exr is an ST map: it bends this picture"
    drive.undo()
    dropped.take(drive.editor, tmp_path / "light.exr")
    assert drive.frame().frame().document.size_px == (30, 20)


def test_what_is_no_warp_is_a_notice_and_nothing_changes(drive: EditorDriver, tmp_path: Path) -> None:
    save(picture(30, 20), tmp_path / "p.png")
    opened(drive, "file.open_st_map", tmp_path / "p.png")
    assert drive.document is drive.start
    text = f"{tmp_path / 'p.png'}: a warp map is a float picture with red and green, such as an EXR file"
    assert drive.editor.notices[-1].text == text


def test_pictures_and_displacements_are_no_st_maps() -> None:
    assert is_st_map(shifted())
    ramp = shifted().pixels.copy()
    ramp[..., 1] = 1 - ramp[..., 1]
    assert not is_st_map(Image(ramp, linear=True))
    lit = shifted().pixels.copy()
    lit[..., 2] = 0.5
    assert not is_st_map(Image(lit, linear=True))
    assert not is_st_map(Image(np.full((20, 30, 3), [4, -2, 0], np.float32), linear=True))
    assert not is_st_map(picture())
