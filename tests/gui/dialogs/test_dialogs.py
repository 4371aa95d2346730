"""The dialogs, typed into at random, and what the window does with keys of its own."""

import random
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import hello_imgui, imgui

from app.actions.view import whole
from app.editor.editor import Editor
from app.model.requests import AskUnsaved, ExportOptions, OpenFile, SaveFile, Unsaved
from app.ui.widgets.theme import icon
from core.document.project import load_project, save_project
from core.imaging.images import Image, save
from core.progress import Job, Progress
from tests.gui.window.test_small_windows import item
from tests.gui.window_driver import WindowDriver, drive, inside

pytestmark = pytest.mark.gui

SCRAPS = ("/", "~", ".", "..", "~x", " ", "*", "%s", "{}", "##", "a", ".png", "é", "名", "-1", "1e99", "nan", "x" * 300)
FIELDS = {
    "file.export": ("Export picture", ("##file", "##width", "##height")),
    "file.open": ("Open", ("##name",)),
    "file.save_as": ("Save project as", ("##name",)),
    "mask.load": ("Load mask", ("##name",)),
    "mask.save": ("Save mask", ("##name",)),
    "surface.open": ("Open a mesh to lay the picture on", ("##name",)),
    "warp.export": ("Export warp: ST map (.exr) or mesh (.obj)", ("##name",)),
}


@pytest.mark.parametrize("action", FIELDS)
def test_random_typing_in_a_dialog_harms_nothing(
    editor: Editor, action: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    editor.source_path = tmp_path / "picture.png"
    editor.edit("Mask", editor.document.changed(mask=editor.document.mask.inverted))
    title, fields = FIELDS[action]
    choose = random.Random(7)

    def script(window: WindowDriver) -> None:
        for _ in range(8):
            if window.dialog is None:
                window.shell.workspace.table.run(action, editor)
                window.wait(4)
            assert window.dialog == title
            for field in fields:
                window.item(f"//{title}/{field}")
                window.key(imgui.Key.mod_ctrl, imgui.Key.a)
                window.context.key_chars("".join(choose.choices(SCRAPS, k=choose.randint(1, 4))))
                window.wait(2)
            if action != "file.export":
                window.key(imgui.Key.enter).wait(2)
            editor.jobs.cancel_all()
        while window.dialog is not None:
            window.key(imgui.Key.escape).wait(3)

    drive(editor, script)


def test_a_slash_as_the_name_of_an_export_is_said(editor: Editor, tmp_path: Path) -> None:
    editor.source_path = tmp_path / "picture.png"

    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("file.export", editor)
        window.wait(4).item("//Export picture/##file")
        window.key(imgui.Key.mod_ctrl, imgui.Key.a)
        window.context.key_chars("/")
        window.wait(3).key(imgui.Key.enter).wait(3)
        assert window.dialog == "Export picture"

    drive(editor, script)


def test_enter_exports(editor: Editor, tmp_path: Path) -> None:
    chosen: list[Path] = []

    def exported(_: object, options: ExportOptions) -> Job[None]:
        chosen.append(options.path)
        yield Progress(1.0)

    editor.source_path, editor.exporter = tmp_path / "picture.png", exported

    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("file.export", editor)
        window.wait(4).key(imgui.Key.enter).wait_until(lambda: bool(chosen))
        assert window.dialog is None

    drive(editor, script)
    assert chosen == [tmp_path / "picture-weft.png"]


def test_file_dialogs_open_on_the_folder_of_the_last_one(editor: Editor, tmp_path: Path) -> None:
    (tmp_path / "masks").mkdir()
    save(Image(np.full((400, 600, 1), 255, np.uint8)), tmp_path / "masks" / "all.png")
    save(Image(np.full((20, 30, 3), 90, np.uint8)), tmp_path / "masks" / "moor.png")

    def script(window: WindowDriver) -> None:
        window.shell.workspace.table.run("mask.load", editor)
        window.wait(4).context.key_chars_append_enter(str(tmp_path / "masks" / "all.png"))
        window.wait_until(lambda: not editor.document.mask.is_empty)
        window.wait_until(lambda: "The mask marks the whole picture." in window.shell.workspace.toasts.texts)
        window.shell.workspace.table.run("file.open", editor)
        window.wait(4).context.key_chars_append_enter("moor.png")
        window.wait(4)

    drive(editor, script)
    assert editor.session.folder == tmp_path / "masks"


@pytest.mark.parametrize(
    ("typed", "keys", "opened"),
    [
        ("", [imgui.Key.down_arrow] * 3, "moor.png"),
        ("", [imgui.Key.up_arrow], "skye.png"),
        ("oo", [], "moor.png"),
        ("oo", [imgui.Key.down_arrow], "moor.png"),
        ("fol", [imgui.Key.enter, imgui.Key.down_arrow], "inside.png"),
    ],
)
def test_a_file_is_chosen_by_keys(
    editor: Editor, tmp_path: Path, typed: str, keys: list[imgui.Key], opened: str
) -> None:
    (tmp_path / "folder").mkdir()
    for name in ("folder/inside.png", "heath.png", "moor.png", "skye.png"):
        (tmp_path / name).touch()
    chosen: list[Path] = []
    editor.show(folder=tmp_path)
    editor.requests.append(OpenFile("Open", ("png",), chosen.append))

    def script(window: WindowDriver) -> None:
        window.wait(4)
        if typed:
            window.context.key_chars(typed)
        for key in keys:
            window.wait(2).key(key).wait(2)
        window.key(imgui.Key.enter).wait_until(lambda: bool(chosen))

    drive(editor, script)
    assert chosen[0].name == opened


@pytest.mark.parametrize(("typed", "written"), [("moor", "moor.tif"), ("moor.png", "moor.png")])
def test_a_name_typed_at_once_keeps_the_proposed_ending(
    editor: Editor, tmp_path: Path, typed: str, written: str
) -> None:
    chosen: list[Path] = []
    editor.requests.append(SaveFile("Save mask", ("png", "tif"), tmp_path / "sky v1.2.tif", chosen.append))

    def script(window: WindowDriver) -> None:
        window.wait(4).context.key_chars(typed)
        window.key(imgui.Key.enter).wait_until(lambda: bool(chosen))

    drive(editor, script)
    assert chosen == [tmp_path / written]


def test_of_a_large_folder_what_is_in_sight_is_drawn(editor: Editor, tmp_path: Path) -> None:
    for number in range(500):
        (tmp_path / f"{number:03}.png").touch()
    chosen: list[Path] = []
    editor.show(folder=tmp_path)
    editor.requests.append(OpenFile("Open", ("png",), chosen.append))

    def is_drawn(window: WindowDriver, row: int) -> bool:
        return item(window, f"//Open/**/{icon('image')}   {row:03}.png##{row}") is not None

    def script(window: WindowDriver) -> None:
        window.wait(4)
        assert is_drawn(window, 2)
        assert not is_drawn(window, 499)
        window.key(imgui.Key.up_arrow).wait(4)  # from the first to the last
        assert is_drawn(window, 499)
        assert not is_drawn(window, 2)
        window.key(imgui.Key.enter).wait_until(lambda: bool(chosen))

    drive(editor, script)
    assert chosen == [tmp_path / "499.png"]


def test_enter_gives_the_usual_answer_after_a_dialog_that_was_answered_by_keys(editor: Editor) -> None:
    answers: list[Unsaved] = []
    editor.requests += [AskUnsaved("moor.png", answers.append), AskUnsaved("heath.png", answers.append)]

    def script(window: WindowDriver) -> None:
        window.wait(4).key(imgui.Key.tab).wait(2).key(imgui.Key.enter).wait_until(lambda: len(answers) == 1)
        window.wait(6).key(imgui.Key.enter).wait_until(lambda: len(answers) == 2)

    drive(editor, script)
    assert answers[1] == "save"


def test_any_answer_of_a_question_is_given_by_keys(editor: Editor) -> None:
    answers: list[Unsaved] = []
    editor.requests.append(AskUnsaved("moor.png", answers.append))

    def script(window: WindowDriver) -> None:
        window.wait(4)
        for _ in range(2):  # the first shows where the keys are
            window.key(imgui.Key.tab).wait(2)
        window.key(imgui.Key.enter).wait_until(lambda: bool(answers))
        window.wait(4).key(imgui.Key.tab).wait(4)
        assert not editor.session.panels  # Tab is the window's own again

    drive(editor, script)
    assert answers == ["discard"]


def test_tab_hides_the_panels_and_brings_them_back(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        canvas = window.shell.workspace.canvas
        window.wait(4)
        narrow = canvas.area.width
        window.move(300, 300).key(imgui.Key.tab).wait(4)
        assert canvas.area.width > narrow + 100
        window.key(imgui.Key.tab).wait(4)
        assert canvas.area.width == pytest.approx(narrow, abs=1)
        window.item("//Warp/**/Arch").wait(2)

    drive(editor, script)
    assert editor.document.warp.preset == "arch"


def test_a_picture_seen_whole_is_as_large_as_the_window_allows_though_fewer_handles_show(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        editor.choose_tool("outline")
        window.item("//Warp/**/Arch").wait_until(lambda: editor.live.is_settled).wait(3)
        before = editor.session.view
        editor.choose_tool("pins")
        window.wait(3)
        assert editor.session.view == before != whole(editor)  # the outline's handles no longer count
        window.move(300, 300).key(imgui.Key.tab).wait(4)
        assert editor.session.view == whole(editor)

    drive(editor, script)


def tabs() -> list[str]:
    """Return the names of the lower panels in their order, the one in front in brackets."""
    node = imgui.internal.find_window_by_name("History").dock_node
    names = [tab.window.name for tab in node.tab_bar.tabs]
    return [f"[{name}]" if name == node.visible_window.name else name for name in names]


def test_panels_are_in_their_order_where_the_window_was_closed_while_some_were_away(
    editor: Editor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    names = ["Handles", "Features", "History"]

    def leave_in_overlay(window: WindowDriver) -> None:
        assert [name.strip("[]") for name in tabs()] == names
        editor.choose_mode("overlay")
        window.wait(10)

    def come_back(window: WindowDriver) -> None:
        window.wait(10)
        assert [name.strip("[]") for name in tabs()] == names

    drive(editor, leave_in_overlay, keeps_settings=True)
    editor.choose_mode("warp")
    drive(editor, come_back, keeps_settings=True)
    assert (tmp_path / "weft" / "window.ini").exists()


def test_panels_come_back_in_their_order_with_the_same_one_in_front(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.wait(4)
        for front in ("Handles", "Features", "History"):
            hello_imgui.get_runner_params().docking_params.focus_dockable_window(front)
            window.wait(4)
            before = tabs()
            assert f"[{front}]" in before
            for mode in ("overlay", "warp"):
                editor.choose_mode(mode)
                window.wait(10)
            assert tabs() == before
            for _ in range(2):
                window.move(300, 300).key(imgui.Key.tab).wait(10)
            assert tabs() == before

    drive(editor, script)


def test_f11_takes_the_whole_screen_and_gives_it_back(editor: Editor) -> None:
    sizes: list[tuple[float, float]] = []

    def script(window: WindowDriver) -> None:
        def note() -> None:
            size = imgui.get_io().display_size
            sizes.append((size.x, size.y))

        window.move(300, 300).wait(2)
        note()
        window.key(imgui.Key.f11).wait(12)
        note()
        window.key(imgui.Key.f11).wait(12)
        note()

    drive(editor, script, size=(1000, 700))
    assert sizes[0] == sizes[2] == (1000, 700)
    assert sizes[1] > sizes[0]


def test_a_picture_seen_whole_stays_whole_when_a_warp_makes_it_larger(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        window.wait(6)
        editor.edit("Stretch", editor.document.with_warp(preset="stretch", values={"width": 300.0}))
        window.wait(8)
        assert editor.session.view == whole(editor)
        window.move(300, 300).context.mouse_wheel_y(2)
        window.wait(3)
        chosen = editor.session.view
        editor.edit("Stretch", editor.document.with_warp(values={"width": 900.0}))
        window.wait(8)
        assert editor.session.view == chosen

    drive(editor, script)


def test_the_history_scrolls_to_its_present_step(editor: Editor) -> None:
    for number in range(60):
        editor.edit(f"Bend {number}", editor.document.with_warp(preset="arc", bend=float(number)))

    def script(window: WindowDriver) -> None:
        window.shell.workspace.show_panel("history")
        place(window.wait(4))
        editor.go_to(2)
        assert place(window.wait(4)) < 60
        editor.go_to(60)
        assert place(window.wait(4)) > 300
        editor.go_to(2)
        assert place(window.wait(4)) < 60

    def place(window: WindowDriver) -> float:
        return float(inside("History").scroll.y)

    drive(editor, script)


@pytest.mark.parametrize(("button", "bend"), [("Overwrite", 20.0), ("Reload", 10.0), ("Cancel", 10.0)])
def test_a_project_that_another_window_wrote_is_asked_about(
    editor: Editor, tmp_path: Path, button: str, bend: float
) -> None:
    path = tmp_path / "work.weft"
    save_project(editor.document, path)
    editor.project_path = path
    editor.on_disk.note(path)

    def script(window: WindowDriver) -> None:
        save_project(editor.document.with_warp(preset="arc", bend=10.0), path)
        editor.edit("Bend", editor.document.with_warp(preset="arc", bend=20.0))
        window.key(imgui.Key.mod_ctrl, imgui.Key.s).wait_until(lambda: window.dialog == "Changed on disk").wait(3)
        window.item(f"//Changed on disk/{button}").wait_until(lambda: editor.jobs.is_idle).wait(3)
        assert window.dialog is None

    drive(editor, script)
    assert load_project(path).warp.bend == bend
    assert editor.document.warp.bend == (10.0 if button == "Reload" else 20.0)
