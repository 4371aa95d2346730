"""Tells the artist of a fault of the program, and offers a way back and a way to pass it on."""

from imgui_bundle import ImVec2, imgui

from app.editor.editor import Editor
from app.ui.barrier import Fault, FaultBarrier
from app.ui.canvas.input import Area
from app.ui.fault_reports import reports_folder, write_report
from app.ui.widgets import theme
from app.ui.widgets.controls import colors, faint, plain_button, primary_button, tip
from app.ui.widgets.theme import em, icon, rgb
from core.arrays import InputError


class FaultMessage:
    """The message that shows while there is a fault that the artist has not answered."""

    def __init__(self, editor: Editor, barrier: FaultBarrier) -> None:
        self._editor = editor
        self._barrier = barrier

    def draw(self, area: Area) -> None:
        """Draw it near the canvas's upper edge."""
        fault = self._barrier.shown
        if fault is None:
            return
        place = ImVec2(area.x + area.width / 2, area.y + em(2))
        imgui.set_next_window_pos(place, imgui.Cond_.always, ImVec2(0.5, 0))
        imgui.push_style_var(imgui.StyleVar_.window_border_size, 1.0)
        imgui.push_style_color(imgui.Col_.window_bg, rgb(theme.RAISED))
        imgui.push_style_color(imgui.Col_.border, rgb(theme.FAULT))
        flags = imgui.WindowFlags_.no_decoration | imgui.WindowFlags_.always_auto_resize
        flags |= imgui.WindowFlags_.no_docking | imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_move
        imgui.begin("##fault", None, flags | imgui.WindowFlags_.no_focus_on_appearing)
        self._draw_inside(fault, min(max(area.width * 0.7, em(16)), em(36)))
        imgui.end()
        imgui.pop_style_color(2)
        imgui.pop_style_var()

    def _draw_inside(self, fault: Fault, width: float) -> None:
        imgui.push_text_wrap_pos(width)
        with colors(text=theme.FAULT):
            imgui.text(f"{icon('triangle-exclamation')}  Weft has made a mistake (while it was to {fault.part})")
        imgui.text(fault.text)
        faint("What you did last may be missing from the picture. Nothing else is lost, and you can go on.")
        imgui.pop_text_wrap_pos()
        imgui.dummy(ImVec2(width, em(0.2)))
        label = self._editor.history.undo_label
        imgui.begin_disabled(label is None)
        if primary_button("Undo", 6):
            self._barrier.shown = None
            self._editor.undo()
        imgui.end_disabled()
        tip("" if label is None else f"Take back: {label}")
        imgui.same_line()
        if plain_button("Report", 6):
            self._report(fault)
        tip("Copy what is known of the mistake, to be passed on, and write it to a file")
        imgui.same_line()
        if plain_button("Go on", 6):
            self._barrier.shown = None

    def _report(self, fault: Fault) -> None:
        imgui.set_clipboard_text(fault.report)
        try:
            file = write_report(fault.report, reports_folder())
            self._editor.notify(f"The report is on the clipboard and in {file}")
        except InputError as refused:
            self._editor.notify(f"The report is on the clipboard; {refused}")
