"""When Overlay mode exports, and what it looks for then."""

from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from app.__main__ import main
from app.commands import decompose
from app.files import document_io
from app.model.jobs import Jobs
from app.model.requests import ExportPicture
from core.document.document import Document
from core.document.overlay import UNSOUGHT
from core.document.overlay_settings import Laying, Search
from core.document.overlay_texture import picture
from core.document.project import save_project
from core.imaging.images import Image, load, save
from core.progress import Job, Progress, run
from tests.app.driver import EditorDriver, Later, document
from tests.core.pictures import picture as small


def exported(*_: object) -> Job[None]:
    yield Progress(1.0)


def begun() -> EditorDriver:
    drive = EditorDriver(jobs=Jobs(live=Later(), long=Later(), beside=Later()))
    drive.editor.exporter = exported
    drive.editor.choose_mode("overlay")
    return drive


def test_what_is_laid_on_cloth_is_not_exported_before_its_pattern_is_found() -> None:
    drive = begun()
    drive.editor.edit("Texture", drive.document.with_cloth(texture=drive.document.image, search=Search()))
    drive.frame()
    document_io.ask_export(drive.editor)
    assert drive.editor.requests == []
    assert drive.editor.notices[-1].text == "Nothing to export yet: the pattern of the cloth is still being looked for"


def test_a_texture_without_a_search_is_not_exported_as_the_bare_photo(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    drive = begun()
    drive.editor.edit("Texture", drive.document.with_cloth(texture=drive.document.image))
    drive.frame()
    document_io.ask_export(drive.editor)
    assert drive.editor.requests == []
    assert drive.editor.notices[-1].text == f"Nothing to export yet: {UNSOUGHT}"
    monkeypatch.chdir(tmp_path)
    save_project(drive.document, Path("a.weft"))
    assert main(["render", "a.weft", "-o", "a.png"]) == 2
    assert capsys.readouterr().err == f"weft: error: a.weft: {UNSOUGHT}\n"
    assert not Path("a.png").exists()


def test_a_photo_with_nothing_on_its_cloth_is_exported_as_it_is_without_a_search() -> None:
    drive = begun()
    drive.editor.edit("Find", drive.document.with_cloth(search=Search()))
    drive.frame()
    document_io.ask_export(drive.editor)
    assert isinstance(drive.editor.requests.pop(), ExportPicture)
    start = document().with_cloth(search=Search())
    assert run(picture(start, start.image)) is start.image


def test_a_fine_texture_is_sampled_at_the_size_of_the_export(found: Document, tmp_path: Path) -> None:
    checks = Image(
        np.repeat(np.kron(np.indices((16, 16)).sum(0) % 2, np.ones((8, 8)))[..., None] * 90 + 80, 3, -1).astype(
            np.uint8
        )
    )
    start = found.with_cloth(texture=checks, laying=Laying(size=2.0))
    save_project(start, tmp_path / "a.weft")
    for scale in ("1", "2"):
        words = ["render", str(tmp_path / "a.weft"), "-o", str(tmp_path / f"{scale}.png"), "--scale", scale]
        assert main(words) == 0
    one, two = (load(tmp_path / f"{scale}.png").pixels.astype(np.float32) for scale in ("1", "2"))
    assert two.shape == (2 * one.shape[0], 2 * one.shape[1], 3)
    blown_up = cv2.resize(one, two.shape[1::-1], interpolation=cv2.INTER_CUBIC)
    sharpness = [np.abs(cv2.Laplacian(picture, cv2.CV_32F))[20:-20, 20:-20].mean() for picture in (two, blown_up)]
    assert sharpness[0] > 1.5 * sharpness[1]
    shrunk = cv2.resize(two, one.shape[1::-1], interpolation=cv2.INTER_AREA)
    assert np.abs(shrunk - one)[10:-10, 10:-10].mean() < 10


def test_parts_that_cover_no_pixel_are_not_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    save(small(height=64, width=64), tmp_path / "photo.png")
    nothing = SimpleNamespace(uv=np.full((64, 64, 2), np.nan))
    monkeypatch.setattr(decompose, "run_shown", lambda _: nothing)
    assert main(["decompose", str(tmp_path / "photo.png"), "-o", str(tmp_path / "parts")]) == 2
    assert capsys.readouterr().err == f"weft: error: {tmp_path}/photo.png: the lattice covers no pixel of the photo\n"
    assert not (tmp_path / "parts").exists()
