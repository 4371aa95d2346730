"""What is said over the sample until the artist does something: how to begin."""

from typing import cast

from imgui_bundle import ImVec2, imgui

from app.actions.edit import TOURS
from app.editor.editor import Editor
from app.ui.canvas.input import Area
from app.ui.dialogs.tour_card import TourCard
from app.ui.widgets import theme
from app.ui.widgets.controls import colors, plain_button, primary_button, tip
from app.ui.widgets.theme import em, icon, rgb
from core.document.document import Mode

STEPS = (
    ("folder-open", "Drop a picture here, or press Ctrl+O"),
    ("paintbrush", "Paint over what must keep its shape"),
    ("wand-magic-sparkles", "Choose a warp at the right, or drag the outline and pins"),
)


class Welcome:
    """A card over the canvas; it goes for good once something is opened, pressed or dismissed."""

    def __init__(self, editor: Editor, tour: TourCard, *, shown: bool) -> None:
        self.shown = shown
        self._editor = editor
        self._tour = tour
        self._start = editor.document

    def draw(self, area: Area) -> None:
        """Draw the card in the canvas's upper middle."""
        self.shown = self.shown and self._editor.document is self._start and not self._editor.is_busy
        if not self.shown:
            return
        place = ImVec2(area.x + area.width / 2, area.y + em(1.2))
        imgui.set_next_window_pos(place, imgui.Cond_.always, ImVec2(0.5, 0))
        imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(em(1.4), em(1.0)))
        imgui.push_style_var(imgui.StyleVar_.window_border_size, 1.0)
        imgui.push_style_color(imgui.Col_.window_bg, rgb(theme.PANEL, 0.96))
        flags = imgui.WindowFlags_.no_decoration | imgui.WindowFlags_.always_auto_resize
        flags |= imgui.WindowFlags_.no_docking | imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_move
        imgui.begin("##welcome", None, flags)
        self._draw_inside(min(em(24), area.width - em(4)))
        imgui.end()
        imgui.pop_style_color()
        imgui.pop_style_var(2)

    def _draw_inside(self, width: float) -> None:
        """Draw title and steps, `width` screen pixels wide."""
        imgui.push_font(None, theme.TITLE_PX)
        imgui.text("Weft")
        imgui.pop_font()
        with colors(text=theme.FAINT):
            imgui.push_text_wrap_pos(imgui.get_cursor_pos_x() + max(width, em(10)))
            imgui.text("Bend a picture and keep its features. This is a sample: try it.")
        imgui.dummy(ImVec2(width, em(0.3)))
        left = imgui.get_cursor_pos_x()
        for glyph, text in STEPS:
            with colors(text=theme.ACCENT):
                imgui.text(icon(glyph))
            imgui.same_line(left + em(2.2))
            imgui.text(text)
        imgui.pop_text_wrap_pos()
        imgui.dummy(ImVec2(0, em(0.3)))
        for number, (mode, title, about, _) in enumerate(TOURS):
            if number:
                imgui.same_line(0, em(0.4))
            if plain_button(title, 7.4):
                self.shown = False
                self._tour.begin(cast("Mode", mode))
            tip(about)
        imgui.dummy(ImVec2(0, em(0.1)))
        if primary_button("Got it", 6):
            self.shown = False
