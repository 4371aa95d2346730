"""The card over the canvas that leads through a tour, step by step."""

from imgui_bundle import ImVec2, imgui

from app.actions.edit import TOURS as TITLES
from app.editor.editor import Editor
from app.files import document_io
from app.tours.samples import sample_of
from app.tours.steps import TOURS
from app.ui.canvas.input import Area
from app.ui.widgets import theme
from app.ui.widgets.controls import colors, plain_button, primary_button
from app.ui.widgets.theme import em, icon, rgb
from core.document.document import Mode

WIDTH_EM = 25.0


class TourCard:
    """Shows the step that is to be done; the next one follows as soon as it is."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self.mode: Mode | None = None
        """Which tour is being taken; None for none."""
        self.step = 0
        self._start = editor.document
        self._document: object = None
        """The sample's history: the tour ends when something else is opened."""

    def begin(self, mode: Mode) -> None:
        """Open a sample and begin its tour; what is not saved is asked about first."""

        def start() -> None:
            self._editor.replace_document(sample_of(mode), project=None, source=None)
            self.mode, self.step = mode, 0
            self._start, self._document = self._editor.document, self._editor.history

        document_io.guard(self._editor, start)

    def update(self, dialog: str | None) -> None:
        """Go on to the next step if the present one is done, `dialog` being the title of the open one; once a frame."""
        if self.mode is None:
            return
        if self._document is not self._editor.history:
            self.mode = None
            return
        steps = TOURS[self.mode]
        if self.step < len(steps) and steps[self.step].done(self._editor, self._start, dialog):
            self.step, self._start = self.step + 1, self._editor.document

    def draw(self, area: Area) -> None:
        """Draw the card in the canvas's lower middle."""
        if self.mode is None:
            return
        place = ImVec2(area.x + area.width / 2, area.y + area.height - em(1.2))
        imgui.set_next_window_pos(place, imgui.Cond_.always, ImVec2(0.5, 1))
        imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(em(1.2), em(0.9)))
        imgui.push_style_var(imgui.StyleVar_.window_border_size, 1.0)
        imgui.push_style_color(imgui.Col_.window_bg, rgb(theme.PANEL, 0.96))
        flags = imgui.WindowFlags_.no_decoration | imgui.WindowFlags_.always_auto_resize
        flags |= imgui.WindowFlags_.no_docking | imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_move
        flags |= imgui.WindowFlags_.no_focus_on_appearing | imgui.WindowFlags_.no_nav
        imgui.begin("##tour", None, flags)
        self._draw_inside(self.mode, max(min(em(WIDTH_EM), area.width - em(4)), em(10)))
        imgui.end()
        imgui.pop_style_color()
        imgui.pop_style_var(2)

    def _draw_inside(self, mode: Mode, width: float) -> None:
        """Draw how far the tour has come, what is to be done, and the way out, `width` screen pixels wide."""
        steps, title = TOURS[mode], next(row[1] for row in TITLES if row[0] == mode)
        with colors(text=theme.FAINT):
            imgui.text(f"{title}   {min(self.step + 1, len(steps))} of {len(steps)}")
        for number in range(len(steps)):
            imgui.same_line(0, em(0.9 if number == 0 else 0.3))
            with colors(text=theme.ACCENT if number < self.step else theme.EDGE):
                imgui.text(icon("circle-check" if number < self.step else "circle"))
        imgui.push_text_wrap_pos(imgui.get_cursor_pos_x() + width)
        is_over = self.step >= len(steps)
        imgui.text("That was it. Drop a picture of yours on the window." if is_over else steps[self.step].text)
        imgui.pop_text_wrap_pos()
        imgui.dummy(ImVec2(width, em(0.1)))
        if (primary_button if is_over else plain_button)("Done" if is_over else "Leave the tour", 8):
            self.mode = None
