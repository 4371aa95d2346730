from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest

from app.actions.file import recent_actions
from app.actions.table import ActionTable
from app.editor.errands import Notice
from app.files import document_io
from app.files.warp_files import write_warp
from app.model.jobs import InlineExecutor, Jobs
from app.model.requests import AskUnsaved, AskWriting, ExportOptions, ExportPicture, OpenFile, SaveFile, Writing
from app.render.picture_file import exporting
from app.tools.all import TOOLS
from core.arrays import InputError
from core.canvas import Canvas
from core.document.document import Document
from core.document.project import load_project, save_project
from core.imaging.images import load, save
from core.mapping.result import Warped
from core.progress import Job, Progress, in_one_step, run
from tests.app.driver import EditorDriver, Later, document, picture

T = TypeVar("T")
TABLE = ActionTable(TOOLS)


@pytest.fixture
def drive(tmp_path: Path) -> EditorDriver:
    drive = EditorDriver()
    drive.editor.recent_file = tmp_path / "config" / "recent.json"
    return drive


def bend(drive: EditorDriver, by: float = 30) -> None:
    drive.editor.edit("Bend", drive.document.with_warp(preset="arc", bend=by))


def ask(drive: EditorDriver, kind: type[T]) -> T:
    """Take the request that the window would show."""
    request = drive.editor.requests.pop(0)
    assert isinstance(request, kind)
    return request


def test_a_picture_is_opened_by_dialog(drive: EditorDriver, tmp_path: Path) -> None:
    save(picture(40, 30), tmp_path / "cat.png")
    document_io.ask_open(drive.editor)
    ask(drive, OpenFile).then(tmp_path / "cat.png")
    drive.frame()
    assert drive.document.size_px == (40, 30)
    assert drive.editor.name == "cat.png"
    assert drive.editor.history.is_saved
    assert document_io.recent_files(drive.editor.recent_file) == (str((tmp_path / "cat.png").resolve()),)


def test_what_cannot_be_opened_is_a_notice_and_nothing_changes(drive: EditorDriver, tmp_path: Path) -> None:
    (tmp_path / "bad.weft").write_bytes(b"nonsense")
    document_io.open_path(drive.editor, tmp_path / "bad.weft")
    drive.frame()
    assert drive.document is drive.start
    assert drive.editor.notices[-1].level == "error"
    assert "bad.weft" in drive.editor.notices[-1].text


def test_a_project_whose_name_has_a_dot_takes_no_other_ones_place(drive: EditorDriver, tmp_path: Path) -> None:
    (tmp_path / "work v1.weft").write_bytes(b"another")
    bend(drive)
    document_io.save(drive.editor)
    ask(drive, SaveFile).then(tmp_path / "work v1.2")
    drive.frame()
    assert drive.editor.project_path == tmp_path / "work v1.2.weft"
    assert (tmp_path / "work v1.weft").read_bytes() == b"another"


def test_save_asks_once_and_then_knows_where(drive: EditorDriver, tmp_path: Path) -> None:
    bend(drive)
    assert not drive.editor.history.is_saved
    document_io.save(drive.editor)
    ask(drive, SaveFile).then(tmp_path / "work")
    drive.frame()
    assert drive.editor.history.is_saved
    assert drive.editor.project_path == tmp_path / "work.weft"
    bend(drive, 60)
    document_io.save(drive.editor)
    drive.frame()
    assert load_project(tmp_path / "work.weft").warp.bend == 60


def test_a_gesture_in_progress_is_finished_before_saving(drive: EditorDriver, tmp_path: Path) -> None:
    drive.editor.project_path = tmp_path / "work.weft"
    drive.tool("brush").press(50, 50).move(90, 60)
    document_io.save(drive.editor)
    drive.frame()
    assert np.array_equal(load_project(tmp_path / "work.weft").mask.array, drive.document.mask.array)
    assert drive.labels == ("Paint mask",)


def test_saving_where_it_cannot_be_is_a_notice_and_stays_unsaved(drive: EditorDriver, tmp_path: Path) -> None:
    bend(drive)
    drive.editor.project_path = tmp_path / "no" / "such" / "folder.weft"
    document_io.save(drive.editor)
    drive.frame()
    assert drive.editor.notices[-1].level == "error"
    assert not drive.editor.history.is_saved


@pytest.mark.gpu
@pytest.mark.parametrize("suffix", ["png", "tif", "exr", "jpg", "webp"])
def test_a_full_disk_while_exporting_is_a_notice_and_loses_nothing(
    drive: EditorDriver, tmp_path: Path, suffix: str
) -> None:
    bend(drive)
    before = drive.document
    full = tmp_path / f"full.{suffix}"
    full.symlink_to("/dev/full")
    drive.editor.exporter = exporting
    document_io.export(drive.editor, ExportOptions(full, drive.document.result_px))
    drive.frame().frame()
    assert drive.editor.notices[-1] == Notice(f"{full}: no space left on device", "error")
    assert drive.document is before
    assert not drive.editor.history.is_saved
    assert [path.name for path in tmp_path.iterdir()] == [full.name]
    drive.undo().redo()
    assert drive.document is before


@pytest.mark.gpu
@pytest.mark.parametrize("suffix", ["png", "tif", "exr", "jpg", "webp"])
def test_an_export_that_is_stopped_leaves_what_was_there(drive: EditorDriver, tmp_path: Path, suffix: str) -> None:
    bend(drive)
    path = tmp_path / f"out.{suffix}"
    path.write_bytes(b"before")
    job = exporting(drive.document, ExportOptions(path, (1600, 1200), bits=16))
    while next(job).fraction < 0.7:
        assert path.read_bytes() == b"before"
    job.close()
    assert path.read_bytes() == b"before"
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_a_full_disk_while_saving_leaves_the_project_as_it_was(drive: EditorDriver, tmp_path: Path) -> None:
    project = tmp_path / "work.weft"
    bend(drive)
    drive.editor.project_path = project
    document_io.save(drive.editor)
    drive.frame()
    before = project.read_bytes()
    bend(drive, 40)
    project.unlink()
    project.symlink_to("/dev/full")
    document_io.save(drive.editor)
    drive.frame()
    assert drive.editor.notices[-1] == Notice(f"{project}: no space left on device", "error")
    assert not drive.editor.history.is_saved
    project.unlink()
    document_io.save(drive.editor)
    drive.frame()
    assert drive.editor.history.is_saved
    assert project.read_bytes() != before


def test_opening_over_changes_asks_and_save_goes_on(drive: EditorDriver, tmp_path: Path) -> None:
    save_project(document(64, 64), tmp_path / "other.weft")
    bend(drive)
    document_io.open_path(drive.editor, tmp_path / "other.weft")
    drive.frame()
    assert drive.document.size_px == (200, 150)
    ask(drive, AskUnsaved).then("save")
    ask(drive, SaveFile).then(tmp_path / "mine.weft")
    drive.frame().frame()
    assert drive.document.size_px == (64, 64)
    assert load_project(tmp_path / "mine.weft").warp.bend == 30


def test_recent_files_are_listed_newest_first(drive: EditorDriver, tmp_path: Path) -> None:
    for name in ("a", "b", "a"):
        save(picture(8, 8), tmp_path / f"{name}.png")
        document_io.open_path(drive.editor, tmp_path / f"{name}.png")
        drive.frame()
    assert [action.label for action in recent_actions(drive.editor)] == ["a.png", "b.png"]
    recent_actions(drive.editor)[1].run(drive.editor)
    drive.frame()
    assert drive.editor.name == "b.png"


def test_a_damaged_list_of_recent_files_is_no_list(tmp_path: Path) -> None:
    (tmp_path / "recent.json").write_text("{")
    assert document_io.recent_files(tmp_path / "recent.json") == ()


def test_what_rests_is_exported_as_it_is_shown_and_what_moves_is_settled_first(
    drive: EditorDriver, tmp_path: Path
) -> None:
    settled: list[Warped | None] = []

    def exporter(document: Document, options: ExportOptions) -> Job[None]:
        yield Progress(0.5)
        settled.append(options.settled)

    drive.editor.exporter = exporter
    bend(drive)
    answer = drive.frame().rest().editor.answer
    document_io.export(drive.editor, ExportOptions(tmp_path / "out.png", (200, 150)))
    drive.frame()
    bend(drive, 40)
    document_io.export(drive.editor, ExportOptions(tmp_path / "out.png", (200, 150)))
    drive.frame()
    assert settled == [answer.result, None]
    assert answer.result is not None
    for suffix in ("exr", "obj"):
        paths = [tmp_path / f"{name}.{suffix}" for name in ("known", "anew")]
        for path, known in zip(paths, (answer.result, None), strict=True):
            run(write_warp(answer.document, path, known))
        assert paths[0].read_bytes() == paths[1].read_bytes()


def test_export_is_a_job_over_the_document_of_that_moment(drive: EditorDriver, tmp_path: Path) -> None:
    seen: list[Document] = []

    def exporter(document: Document, options: ExportOptions) -> Job[None]:
        yield Progress(0.5)
        seen.append(document)
        save(document.image, options.path)

    drive.editor.exporter = exporter
    document_io.ask_export(drive.editor)
    request = ask(drive, ExportPicture)
    assert request.options.size_px == (200, 150)
    request.then(ExportOptions(tmp_path / "out.png", (200, 150)))
    drive.frame()
    assert seen == [drive.document]
    assert load(tmp_path / "out.png").width_px == 200
    assert drive.editor.notices[-1].text == "Exported out.png"


def test_an_export_is_named_after_the_project_and_ends_as_the_picture_does(drive: EditorDriver, tmp_path: Path) -> None:
    def proposed() -> str:
        document_io.ask_export(drive.editor)
        return ask(drive, ExportPicture).options.path.name

    editor = drive.editor
    editor.exporter = lambda document, options: in_one_step("writing", options.path.touch)
    editor.source_path = tmp_path / "photo.jpg"
    assert proposed() == "photo-weft.jpg"
    editor.project_path = tmp_path / "flag.weft"
    assert proposed() == "flag.jpg"
    bend(drive, 80)
    drive.frame()
    assert proposed() == "flag.png"  # a JPEG has no transparency for what is beside the bent picture
    drive.undo().frame()
    editor.project_path = tmp_path / "photo.weft"
    (tmp_path / "photo.jpg").touch()
    assert proposed() == "photo-weft.jpg"
    document_io.export(editor, ExportOptions(tmp_path / "final.tif", (200, 150)))
    drive.frame()
    assert proposed() == "final.tif"


@pytest.mark.parametrize("name", ["warp.exr", "warp.obj"])
def test_the_warp_itself_is_exported_in_the_frame_of_the_picture(
    drive: EditorDriver, tmp_path: Path, name: str
) -> None:
    bend(drive)
    TABLE.run("warp.export", drive.editor)
    ask(drive, SaveFile).then(tmp_path / name)
    drive.frame()
    canvas = Canvas.around(drive.editor.answer.warped)
    if name.endswith("exr"):
        shares = load(tmp_path / name).pixels
        assert shares.shape[:2] == (canvas.height_px, canvas.width_px)
        assert 0.5 < (shares[..., 3] == 1).mean() < 1
    else:
        lines = (tmp_path / name).read_text().splitlines()
        places = np.loadtxt([line[2:] for line in lines if line.startswith("v ")])
        assert np.allclose(places[:, :2].max(axis=0), canvas.size, atol=1)
    assert drive.editor.notices[-1].text == f"Saved {name}"


def test_a_warp_of_another_kind_of_file_is_refused(drive: EditorDriver, tmp_path: Path) -> None:
    TABLE.run("warp.export", drive.editor)
    ask(drive, SaveFile).then(tmp_path / "warp.png")
    drive.frame()
    assert "warp.png: a warp is an .exr file" in drive.editor.notices[-1].text
    assert not list(tmp_path.glob("*.png"))


@pytest.mark.parametrize(
    ("choice", "written", "closed"), [("wait", True, True), ("stop", False, True), ("cancel", True, False)]
)
def test_quitting_while_a_picture_is_exported_asks(
    tmp_path: Path, choice: Writing, written: bool, closed: bool
) -> None:
    work = Later()
    drive = EditorDriver(jobs=Jobs(live=InlineExecutor(), long=work, beside=InlineExecutor()))

    def exporter(document: Document, options: ExportOptions) -> Job[None]:
        yield Progress(0.5)
        save(document.image, options.path)

    drive.editor.exporter = exporter
    document_io.export(drive.editor, ExportOptions(tmp_path / "out.png", (200, 150)))
    document_io.quit_editor(drive.editor)
    assert not drive.editor.is_closing
    request = ask(drive, AskWriting)
    assert request.names == ("Export out.png",)
    request.then(choice)
    if drive.editor.is_closing:
        drive.editor.jobs.close()
    work.run()
    drive.frame()
    assert (tmp_path / "out.png").exists() == written
    assert drive.editor.is_closing == closed


def test_quitting_after_an_export_stays_when_that_failed(tmp_path: Path) -> None:
    work = Later()
    drive = EditorDriver(jobs=Jobs(live=InlineExecutor(), long=work, beside=InlineExecutor()))

    def exporter(document: Document, options: ExportOptions) -> Job[None]:
        yield Progress(0.5)
        raise InputError("out.png: no space left on device")

    drive.editor.exporter = exporter
    document_io.export(drive.editor, ExportOptions(tmp_path / "out.png", (200, 150)))
    document_io.quit_editor(drive.editor)
    ask(drive, AskWriting).then("wait")
    work.run()
    drive.frame()
    assert not drive.editor.is_closing
    assert drive.editor.notices[-1].text == "out.png: no space left on device"


def test_another_picture_keeps_what_was_done(drive: EditorDriver, tmp_path: Path) -> None:
    bend(drive)
    save(picture(400, 300), tmp_path / "large.png")
    document_io.replace_picture(drive.editor, tmp_path / "large.png")
    drive.frame()
    assert drive.document.size_px == (400, 300)
    assert drive.document.warp.bend == 30
    assert drive.editor.answer.grid.width_px == 400
    assert drive.labels == ("Bend", "Replace picture")
