"""The presets as pictures: the present picture, small, warped by each."""

from collections.abc import Callable
from dataclasses import dataclass

from imgui_bundle import ImVec2, imgui

from app.ui.widgets import theme
from app.ui.widgets.controls import tip
from app.ui.widgets.theme import color, em, icon
from core.warps.presets import PRESETS, Preset

LEAST_EM, MOST_COLUMNS = 4.0, 6
"""Width of a picture, and how many stand in a row at most."""

SHAPE = 0.62
"""Height of a picture over its width."""


@dataclass(frozen=True)
class Thumbnail:
    """A picture on the GPU."""

    texture: int
    """Its OpenGL name."""
    width_px: int
    height_px: int


class PresetList:
    """A grid of pictures to choose from; `thumbnail` gives each, None while there is none yet."""

    def __init__(self, thumbnail: Callable[[str], Thumbnail | None]) -> None:
        self._thumbnail = thumbnail

    def draw(self, chosen: str) -> str | None:
        """Draw the pictures and return the name of the one that was pressed."""
        pressed: str | None = None
        gap, room = em(0.35), imgui.get_content_region_avail().x
        columns = min(max(int((room + gap) / (em(LEAST_EM) + gap)), 2), MOST_COLUMNS)
        side = (room - gap * (columns - 1)) / columns
        imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(gap, gap))
        sheet = imgui.get_window_draw_list()
        sheet.channels_split(2)
        for number, preset in enumerate(PRESETS.values()):
            if number % columns:
                imgui.same_line()
            if self._draw_one(preset, side, chosen=preset.name == chosen):
                pressed = preset.name
        sheet.channels_merge()
        imgui.pop_style_var()
        return pressed

    def _draw_one(self, preset: Preset, side: float, *, chosen: bool) -> bool:
        text_px = theme.SMALL_PX - 0.5
        foot = em(1.25)
        pressed = imgui.invisible_button(preset.label, ImVec2(side, side * SHAPE + foot))
        hovered = imgui.is_item_hovered()
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        sheet = imgui.get_window_draw_list()
        plate = theme.BUTTON if hovered or chosen else theme.SUNKEN
        sheet.add_rect_filled(low, high, color(plate), em(0.25))
        sheet.channels_set_current(1)
        self._draw_picture(preset, sheet, ImVec2(low.x, low.y), ImVec2(high.x, high.y - foot))
        sheet.channels_set_current(0)
        imgui.push_font(None, text_px)
        width = imgui.calc_text_size(preset.label).x
        is_cut = width > side
        if is_cut:
            tip(preset.label)
            sheet.push_clip_rect(low, high, True)
        place = ImVec2((low.x + high.x - width) / 2, high.y - foot + em(0.1))
        sheet.add_text(place, color(theme.ACCENT if chosen else theme.TEXT if hovered else theme.FAINT), preset.label)
        if is_cut:
            sheet.pop_clip_rect()
        imgui.pop_font()
        if chosen:
            sheet.add_rect(low, high, color(theme.ACCENT), em(0.25), em(0.12))
        return pressed

    def _draw_picture(self, preset: Preset, sheet: imgui.ImDrawList, low: ImVec2, high: ImVec2) -> None:
        """Draw the thumbnail as large as fits between `low` and `high`, centred."""
        middle = ImVec2((low.x + high.x) / 2, (low.y + high.y) / 2)
        shown = self._thumbnail(preset.name)
        if shown is None:
            text = icon("image")
            size = imgui.calc_text_size(text)
            sheet.add_text(ImVec2(middle.x - size.x / 2, middle.y - size.y / 2), color(theme.DISABLED), text)
            return
        inset = em(0.25)
        room = (high.x - low.x - 2 * inset, high.y - low.y - 2 * inset)
        scale = min(room[0] / shown.width_px, room[1] / shown.height_px) / 2
        half = (shown.width_px * scale, shown.height_px * scale)
        sheet.add_image(
            imgui.ImTextureRef(shown.texture),
            ImVec2(middle.x - half[0], middle.y - half[1]),
            ImVec2(middle.x + half[0], middle.y + half[1]),
        )
