"""Sheets over the window: every key at a glance, what Weft is, and the preferences."""

from typing import Literal

from imgui_bundle import ImVec2, imgui

from app.actions.table import ActionTable
from app.editor.editor import Editor
from app.ui.dialogs.keys_sheet import KeysSheet
from app.ui.dialogs.modal import modal, within
from app.ui.dialogs.preferences import PreferencesSheet
from app.ui.widgets import theme
from app.ui.widgets.controls import faint, primary_button
from app.ui.widgets.theme import em

Sheet = Literal["keys", "about", "preferences"]
TITLES: dict[Sheet, str] = {"keys": "Keys", "about": "About Weft", "preferences": "Preferences"}


class Sheets:
    """The sheet that is open, if any."""

    def __init__(self, editor: Editor, table: ActionTable) -> None:
        self._keys = KeysSheet(editor, table)
        self._preferences = PreferencesSheet(editor)
        self.shown: Sheet | None = None

    def draw(self) -> None:
        """Draw the sheet over the window."""
        if self.shown is None:
            return
        with modal(TITLES[self.shown]) as shown:
            if shown:
                self._draw_inside(self.shown)

    def _draw_inside(self, sheet: Sheet) -> None:
        asked = self._keys.is_asking
        draw = {"keys": self._keys.draw, "about": self._draw_about, "preferences": self._preferences.draw}
        draw[sheet]()
        imgui.dummy(ImVec2(0, em(0.3)))
        if primary_button("Close", 7) or (imgui.is_key_pressed(imgui.Key.escape) and not asked):
            self._keys.is_asking = False
            self.shown = None
            imgui.close_current_popup()

    def _draw_about(self) -> None:
        imgui.push_font(None, theme.TITLE_PX)
        imgui.text("Weft")
        imgui.pop_font()
        faint(f"Version {_version()}. Free software under the GNU General Public License, version 3 or later.")
        imgui.dummy(ImVec2(within(30), em(0.3)))
        imgui.text("Bend a picture and keep its features: warp, retexture and overlay, live.")


def _version() -> str:
    from importlib import metadata  # not before the first frame

    try:
        return metadata.version("weft")
    except metadata.PackageNotFoundError:
        return "of the source folder"
