"""Asks what is to become of a project that another program has written since it was opened here."""

from imgui_bundle import ImVec2, imgui

from app.model.requests import AskChanged
from app.ui.dialogs.modal import within
from app.ui.widgets.controls import faint, move_right, plain_button, primary_button, tip
from app.ui.widgets.theme import em


class ChangedDialog:
    """Offers to save elsewhere, to write over the other version, or to take it in."""

    title = "Changed on disk"

    def __init__(self, request: AskChanged) -> None:
        self._request = request

    def draw(self) -> bool:
        """Draw question and answers."""
        imgui.text(f"{self._request.name} was written by another program, or another window.")
        faint("Nothing is saved yet. What is yours stays open here.")
        imgui.dummy(ImVec2(within(34), em(0.4)))
        if plain_button("Overwrite", 7):
            self._request.then("overwrite")
            return False
        tip("Write over the other version; it is kept as a backup where that is switched on")
        imgui.same_line()
        if plain_button("Reload", 7):
            self._request.then("reload")
            return False
        tip("Take in the other version and give up what is open here")
        move_right(7, 7)
        if plain_button("Cancel", 7) or imgui.is_key_pressed(imgui.Key.escape):
            self._request.then("cancel")
            return False
        imgui.same_line()
        if primary_button("Save as …", 7) or imgui.is_key_pressed(imgui.Key.enter):
            self._request.then("save_as")
            return False
        return True
