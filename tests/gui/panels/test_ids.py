"""No two items of a window have one id: Dear ImGui could not tell them apart, and says so over the window."""

from collections.abc import Iterable
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from imgui_bundle import imgui

from app.editor.editor import Editor
from app.ui.menus import menu_tree
from core.document.document import CurvePair, Document, Mode, Outline, Pin
from tests.gui.window_driver import WindowDriver, drive

pytestmark = pytest.mark.gui

LINE = np.array([(0.2, 0.2), (0.3, 0.2), (0.5, 0.3), (0.6, 0.3)])
MODES = ("Warp", "Retexture", "Overlay")


def shared_ids(window: WindowDriver, ids: Iterable[int]) -> set[int]:
    """Return those of `ids` that more than one item has.

    Dear ImGui counts the items with the id that was hovered in the frame before; every id is said to have been.
    """
    context = imgui.get_current_context()
    assert context is not None
    assert imgui.get_io().config_debug_highlight_id_conflicts
    found = set()
    for hovered in [*ids, 0, 0]:
        context.hovered_id = hovered
        window.wait(1)
        found.add(context.debug_draw_id_conflicts_id)
    return found - {0}


def windows_shown() -> set[str]:
    """Return the names of all windows and popups on the screen."""
    context = imgui.get_current_context()
    assert context is not None
    return {shown.name for shown in context.windows if shown.active and not shown.hidden}


def ids_in(window: WindowDriver, names: Iterable[str]) -> set[int]:
    """Return the ids of all items in some windows."""
    items = imgui.test_engine.TestItemList()
    for name in names:
        window.context.gather_items(items, f"//{name}", 99)
    return {items.get_by_index(number).id_ for number in range(items.get_size())}


def full(document: Document) -> Document:
    """Return the document with several handles of each kind."""
    curves = (CurvePair(LINE, LINE), CurvePair(LINE, LINE))
    pins = (Pin((0.5, 0.5), (0.6, 0.5)), Pin((0.2, 0.2), (0.2, 0.2)))
    return document.changed(outline=Outline.straight(), pins=pins, curves=curves, feature_curves=curves)


def test_panels_bars_and_menu_titles_share_no_ids(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        editor.edit("Handles", full(editor.document))
        tree = menu_tree(window.shell.workspace.table.actions)
        titles = [title for title in tree if title != "Mode"] + [f"{name}##mode.{name.lower()}" for name in MODES]
        for name in MODES:
            editor.choose_mode(cast("Mode", name.lower()))
            editor.show(selected=frozenset({0}), selected_curve=0)
            window.wait(5)
            bar = [window.context.item_info(f"//##MainMenuBar/**/{title}").id_ for title in titles]
            assert all(bar)
            ids = {*ids_in(window, windows_shown()), *bar}
            assert len(ids) > 50
            assert not shared_ids(window, ids), name

    drive(editor, script)


def test_menus_share_no_ids(editor: Editor) -> None:
    def script(window: WindowDriver) -> None:
        behind = windows_shown()
        for title in menu_tree(window.shell.workspace.table.actions):
            if title != "Mode":
                window.item(f"//##MainMenuBar/**/{title}").wait(2)
                check_new(window, title, behind)

    drive(editor, script)


def test_dialogs_and_sheets_share_no_ids(editor: Editor, tmp_path: Path) -> None:
    editor.source_path = tmp_path / "picture.png"

    def script(window: WindowDriver) -> None:
        behind = windows_shown()
        for action in ("file.export", "file.open", "edit.preferences", "help.palette"):
            window.shell.workspace.table.run(action, editor)
            check_new(window.wait(3), action, behind)

    drive(editor, script)


def check_new(window: WindowDriver, name: str, behind: set[str]) -> None:
    """Check what has opened over the windows `behind`, and close it."""
    ids = ids_in(window, windows_shown() - behind)
    assert ids, name
    assert not shared_ids(window, ids), name
    window.key(imgui.Key.escape).wait(2)
