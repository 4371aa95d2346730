"""What Retexture mode writes: exports, renders and projects."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.actions.table import ActionTable
from app.model.requests import ExportOptions
from app.tools.all import TOOLS
from core.document.project import load_project, save_project
from core.imaging.images import load
from core.progress import run
from tests.app.driver import EditorDriver
from tests.app.retexture.driver import HEIGHT, WIDTH, driver, moved, shown, target


@pytest.fixture
def drive() -> EditorDriver:
    return driver()


def test_letting_go_regrows_the_texture_and_export_gives_the_same(drive: EditorDriver, tmp_path: Path) -> None:
    from app.render.picture_file import exporting

    moved(drive)
    work = drive.editor.regrowth
    assert work.is_final
    assert work.stage is not None
    assert work.stage.found.patches > 5
    result = shown(drive)
    assert result is work.stage.image
    place = tmp_path / "out.png"
    run(exporting(drive.document, ExportOptions(place, drive.document.result_px)))
    assert np.array_equal(load(place).pixels, result.pixels)
    # Under the target lies what lay under the curve.
    assert np.abs(work.stage.found.place[90, 97:104, 1] - 70).max() < 2


def test_a_project_brings_curves_masks_and_mode_back(drive: EditorDriver, tmp_path: Path) -> None:
    moved(drive)
    ActionTable(TOOLS).run("retexture.paint_matte", drive.editor)
    drive.drag((70, 85), (90, 85))
    drive.editor.edit("Seed", drive.document.with_retexture(seed=7, reach=0.2))
    path = tmp_path / "project.weft"
    save_project(drive.document, path)
    again = EditorDriver(load_project(path))
    assert again.editor.session.mode == "retexture"
    assert again.document.retexture == drive.document.retexture
    assert np.array_equal(target(again), target(drive))
    assert again.document.matte is not None
    assert drive.document.matte is not None
    assert np.array_equal(again.document.matte.array, drive.document.matte.array)
    again.frame()
    drive.frame()
    assert np.array_equal(shown(again).pixels, shown(drive).pixels)


def test_weft_render_gives_the_retextured_picture(drive: EditorDriver, tmp_path: Path) -> None:
    from app.cli import main

    moved(drive)
    save_project(drive.document, tmp_path / "project.weft")
    assert main(["render", str(tmp_path / "project.weft"), "-o", str(tmp_path / "out.png")]) == 0
    assert np.array_equal(load(tmp_path / "out.png").pixels, shown(drive).pixels)


def test_export_writes_the_result_of_the_mode(drive: EditorDriver, tmp_path: Path) -> None:
    from app.files import document_io
    from app.model.requests import ExportPicture
    from app.render.picture_file import exporting

    moved(drive)
    drive.editor.edit("Size", drive.document.with_warp(aspect=(2.0, 1.0)))
    drive.editor.exporter = exporting
    document_io.ask_export(drive.editor)
    request = drive.editor.requests.pop()
    assert isinstance(request, ExportPicture)
    assert request.options.size_px == (WIDTH, HEIGHT)
    request.then(replace(request.options, path=tmp_path / "out.png", bits=16))
    drive.frame()
    written = load(tmp_path / "out.png").pixels
    assert written.dtype == np.uint16
    assert np.abs(written / 257 - shown(drive).pixels).mean() < 0.5
