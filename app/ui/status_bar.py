"""The line at the window's foot: the tool's hint, and the figures of the canvas."""

import numpy as np
from imgui_bundle import ImVec2, imgui

from app.editor import Editor
from app.jobs import Ticket
from app.spaces import canvas_from_screen
from app.ui import theme
from app.ui.controls import colors, icon_button, tip
from app.ui.theme import em, icon


class StatusBar:
    """What the window's foot says."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._solve_ms = 0.0

    def draw(self) -> None:
        """Draw hint, job and figures."""
        imgui.push_font(None, theme.SMALL_PX + 0.5)
        with colors(text=theme.FAINT):
            imgui.align_text_to_frame_padding()
            imgui.text(f"{icon(self._editor.tool.icon)}   {self._editor.tool.hint}")
        for ticket in self._editor.jobs.long_jobs[:1]:
            self._draw_job(ticket)
        self._draw_figures()
        imgui.pop_font()

    def _draw_job(self, ticket: Ticket) -> None:
        """Draw a long job's progress and the button that cancels it."""
        imgui.same_line(0, em(2))
        step = ticket.progress
        imgui.progress_bar(step.fraction, ImVec2(em(12), imgui.get_frame_height() * 0.8), "")
        imgui.same_line()
        note = f"{ticket.name} – {step.note}" if step.note else ticket.name
        imgui.text("Cancelling …" if ticket.cancelled else note)
        imgui.same_line()
        if icon_button("Cancel job", "xmark", hint="Cancel", size_em=1.4):
            ticket.cancel()

    def _draw_figures(self) -> None:
        """Write the figures, from the right."""
        figures = self.figures()
        gap = em(1.6)
        total = sum(imgui.calc_text_size(text).x + gap for text, _, _ in figures)
        imgui.same_line(max(imgui.get_window_width() - total, imgui.get_cursor_pos_x()))
        for text, hint, fault in figures:
            with colors(text=theme.FAULT if fault else theme.FAINT):
                imgui.text(text)
            tip(hint)
            imgui.same_line(0, gap)
        imgui.new_line()

    def figures(self) -> list[tuple[str, str, bool]]:
        """Return text and meaning of each figure, and whether it is bad news."""
        editor, session = self._editor, self._editor.session
        answer = editor.answer
        rows: list[tuple[str, str, bool]] = []
        if editor.fault is not None:
            rows.append((f"{icon('triangle-exclamation')}  {editor.fault}", "The last map that worked is shown", True))
        if session.pointer is not None:
            on_canvas = canvas_from_screen(session.view, np.array([session.pointer]))
            x, y = answer.mesh.image_from_canvas(on_canvas)[0]
            if np.isfinite(x):
                rows.append((f"{x:.0f}, {y:.0f}", "The pixel of the picture under the pointer", False))
        width, height = editor.document.size_px
        rows.append((f"{width} × {height} px", "Width and height of the picture", False))
        rows.append((f"{answer.grid.columns} × {answer.grid.rows}", "Nodes of the grid, across and down", False))
        if not answer.settled:
            self._solve_ms = answer.solve_ms
        rows.append((f"{self._solve_ms:.1f} ms", "The last solve while something moved took so long", False))
        folds = f"{answer.folds} folds" if answer.folds else "no folds"
        rows.append(
            (
                folds,
                "Cells that are turned over; at rest, those that the warp itself does not fold are mended",
                answer.folds > 0,
            )
        )
        rows.append((f"{session.view.zoom:.0%}", "Zoom", False))
        return rows
