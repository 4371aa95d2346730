"""Offers work that earlier runs left: what it was called, where it was, when it was kept, and how it looks."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

from imgui_bundle import ImVec2, imgui

from app.model.requests import AskRecover, Offer
from app.ui.dialogs.file_browser import format_date
from app.ui.dialogs.modal import is_confirmed, within, within_height
from app.ui.panels.preset_list import Thumbnail
from app.ui.widgets import theme
from app.ui.widgets.controls import colors, faint, move_right, plain_button, primary_button, shorten, tip
from app.ui.widgets.theme import em

ThumbnailOf: TypeAlias = Callable[[Path], Thumbnail | None]
"""Returns the texture of a picture's file; None where it cannot be read."""
ROW_EM, PICTURE_EM = 4.4, 5.6
"""Height of a row, and width of its picture."""


class RecoverDialog:
    """Offers what an earlier run left."""

    title = "Recover unsaved work?"

    def __init__(self, request: AskRecover, thumbnail: ThumbnailOf) -> None:
        self._request = request
        self._thumbnail = thumbnail
        self.chosen = 0
        """Number of the offer to recover."""
        self._is_taken = False
        """Whether an offer was double-clicked."""

    def draw(self) -> bool:
        """Draw the list and the answers."""
        imgui.text("Weft did not close as it should last time. It kept your work:")
        count = len(self._request.offers)
        height = min(within_height(22, 11.5), em(ROW_EM + 0.6) * count + em(0.6))
        imgui.begin_child("offers", ImVec2(within(34), height), imgui.ChildFlags_.nav_flattened)
        for number, offer in enumerate(self._request.offers):
            self._draw_offer(number, offer)
        imgui.end_child()
        imgui.dummy(ImVec2(within(34), em(0.4)))
        if plain_button("Discard all" if count > 1 else "Discard", 8):
            self._request.then(None)
            return False
        move_right(7, 8)
        if plain_button("Later", 7) or imgui.is_key_pressed(imgui.Key.escape):
            return False
        tip("It stays and is offered again at the next start")
        imgui.same_line()
        if primary_button("Recover", 8) or is_confirmed() or self._is_taken:
            self._request.then(self.chosen)
            return False
        return True

    def _draw_offer(self, number: int, offer: Offer) -> None:
        """Draw one row: picture, name, date and folder; a click chooses it."""
        at = imgui.get_cursor_pos()
        flags = imgui.SelectableFlags_.allow_double_click | imgui.SelectableFlags_.no_auto_close_popups
        if imgui.selectable(f"##offer {number}", number == self.chosen, flags, ImVec2(0, em(ROW_EM)))[0]:
            self.chosen, self._is_taken = number, imgui.is_mouse_double_clicked(0)
        if number == 0:
            imgui.set_item_default_focus()
        if imgui.is_item_focused():  # arrow keys go from row to row
            self.chosen = number
        low = imgui.get_item_rect_min()
        picture = None if offer.picture is None else self._thumbnail(offer.picture)
        if picture is not None:
            _draw_picture(picture, ImVec2(low.x + em(0.3), low.y + em(0.2)))
        below = imgui.get_cursor_pos()
        left, room = at.x + em(PICTURE_EM + 1), within(34) - em(PICTURE_EM + 2)
        imgui.set_cursor_pos(ImVec2(left, at.y + em(0.4)))
        imgui.text(shorten(offer.name, room))
        imgui.set_cursor_pos_x(left)
        with colors(text=theme.FAINT):
            imgui.text(f"{format_date(offer.kept_at, with_time=True)}{', an earlier state' if offer.earlier else ''}")
        imgui.set_cursor_pos_x(left)
        faint(shorten(offer.folder, room, keeps_end=True))
        imgui.set_cursor_pos(below)
        imgui.dummy(ImVec2(0, 0))


def _draw_picture(picture: Thumbnail, at: ImVec2) -> None:
    """Draw a picture with its upper left corner at `at`, as large as its place allows."""
    width, height = picture.width_px, picture.height_px
    scale = min(em(PICTURE_EM) / width, em(ROW_EM - 0.4) / height)
    far = ImVec2(at.x + width * scale, at.y + height * scale)
    imgui.get_window_draw_list().add_image(imgui.ImTextureRef(picture.texture), at, far)
