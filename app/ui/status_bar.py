"""The line at the window's foot: the tool's hint, and the figures of the canvas."""

from typing import TypeAlias

import numpy as np
from imgui_bundle import ImVec2, imgui

from app.actions import view
from app.editor.editor import Editor
from app.marking.feature_list import feature_list, rows_of
from app.model.events import Position
from app.model.jobs import Ticket
from app.model.pointer_keys import word
from app.model.spaces import LEAST_ZOOM, MOST_ZOOM, View, canvas_from_screen
from app.ui.widgets import theme
from app.ui.widgets.controls import Hinted, colors, end_popup, icon_button, shorten, tip
from app.ui.widgets.sliders import number_box
from app.ui.widgets.theme import em, icon
from core.files.text import begin_sentence
from core.imaging.image import Image
from core.mesh import Mesh

Figure: TypeAlias = tuple[str, str, bool]
"""Text, meaning, and whether it is bad news."""
GAP_EM, JOB_EM = 1.6, 34.0
"""Room after a figure, and room for a job."""
HINT_SHARE, HINT_ICON_EM = 0.3, 2.0
"""How much of the bar the hint has beside a job at most, and at least, for its icon."""
LEAST_HINT_EM, LEAST_JOB_EM = 5.0, 16.0
"""What the hint and a job are left where the figures want all; the first figures give way."""


ZOOMS, PERCENTS = "Zooms", (25, 50, 100, 200, 400, 800)
"""Name of the list of zooms, and those in it."""


class StatusBar:
    """What the window's foot says."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._solve_ms = 0.0
        """Of what moved last; 0 while nothing has."""
        self._moved: Image | None = None
        """The picture that did."""
        self._mesh: Mesh | None = None
        self._place = ""
        """Which pixel of the picture is under the pointer."""
        self._looked_at: tuple[Position | None, View, Mesh, bool] | None = None
        """What that was looked up for."""
        self._feature = ""
        """The name of the feature there; nothing while a gesture is in progress, which is what the hint tells of."""
        self._hinted = ""
        """What the widget under the pointer is, as of the last frame."""

    def draw(self) -> None:
        """Draw hint, job and figures."""
        self._hinted = Hinted.take()
        imgui.push_font(None, theme.SMALL_PX + 0.5)
        jobs = self._editor.jobs.long_jobs[:1]
        room = imgui.get_window_width() - em(1)
        figures = _fitting(self.figures(), room - em(LEAST_JOB_EM if jobs else LEAST_HINT_EM))
        width = _width(figures)
        # A job stands still while hints and figures change with the pointer, so that it can be cancelled.
        start = min(HINT_SHARE * room, max(room - width - em(JOB_EM), em(HINT_ICON_EM)))
        self._draw_hint(start if jobs else room - width)
        for ticket in jobs:
            self._draw_job(ticket, start, room - width)
        _draw_figures(figures, width)
        imgui.pop_font()
        self._draw_zooms()

    def _draw_zooms(self) -> None:
        """Draw the list of zooms, while it is open: a press on the figure, which was drawn last, opens it."""
        editor = self._editor
        if not imgui.begin_popup(ZOOMS):
            return
        zoom = editor.session.view.magnification
        held = number_box(100 * zoom, 100 * LEAST_ZOOM, 100 * MOST_ZOOM, 0, name="zoom", width_em=5.0)
        tip("Zoom in per cent")
        if held.value is not None:
            view.zoom(editor, held.value / 100 / zoom)
            imgui.close_current_popup()
        imgui.separator()
        if imgui.menu_item("Fit picture", "", False)[0]:
            view.fit(editor)
        for percent in PERCENTS:
            if imgui.menu_item(f"{percent} %", "", abs(100 * zoom - percent) < 0.5)[0]:
                view.zoom(editor, percent / 100 / zoom)
        end_popup()

    @property
    def hint(self) -> str:
        """What the widget under the mouse does; or else the feature there, and what the tool in hand can do now."""
        editor, tool = self._editor, self._editor.tool
        if self._hinted:
            return self._hinted
        does = word(tool.moment(editor) or tool.hint, tool.name, editor.preferences.pointer_keys)
        return " · ".join(text for text in (self._feature, does) if text)

    def _draw_hint(self, room: float) -> None:
        """Say what the tool does, in `room` screen pixels."""
        hint = f"{icon(self._editor.tool.icon)}   {self.hint}"
        shown = shorten(hint, room)
        with colors(text=theme.FAINT):
            imgui.align_text_to_frame_padding()
            imgui.text(shown)
        if shown != hint:
            tip(self.hint)

    def _draw_job(self, ticket: Ticket, start: float, end: float) -> None:
        """Draw a long job's progress and the button that cancels it, from `start` to `end`, whatever the hint says."""
        imgui.same_line(start + em(1))
        step = ticket.progress
        room = end - imgui.get_cursor_pos_x() - em(4)
        bar = min(em(12), room / 3)
        imgui.progress_bar(step.fraction, ImVec2(bar, imgui.get_frame_height() * 0.8), "")
        imgui.same_line()
        note = f"{ticket.name} – {step.note}" if step.note else ticket.name
        imgui.text("Cancelling …" if ticket.cancelled else shorten(note, room - bar))
        tip(note)
        imgui.same_line()
        if icon_button("Cancel job", "xmark", hint="Cancel", size_em=1.4):
            ticket.cancel()

    def figures(self) -> list[Figure]:
        """Return what is true in the present mode."""
        editor, session = self._editor, self._editor.session
        of_mode = {"warp": self._warp_figures, "retexture": self._retexture_figures, "overlay": list[Figure]}
        rows: list[Figure] = []
        if editor.fault is not None:
            rows.append(
                (f"{icon('triangle-exclamation')}  {begin_sentence(editor.fault)}", "What worked last is shown", True)
            )
        if editor.recovery is not None and editor.recovery.fault is not None:
            rows.append((f"{icon('triangle-exclamation')}  Unsaved work is not kept", editor.recovery.fault, True))
        if session.mode == "warp" and editor.jobs.holds("settle"):
            rows.append(("finishing …", "The final map is worked out; what is shown may still change a little", False))
        self._find_place()
        if self._place:
            rows.append((self._place, "The pixel of the picture under the pointer", False))
        width, height = editor.document.size_px
        rows.append((f"{width} × {height} px", "Width and height of the picture", False))
        result = editor.document.changed(mode=session.mode).result_px
        if result != (width, height):
            rows.append((f"→  {result[0]} × {result[1]} px", "Width and height of the result", False))
        rows.extend(of_mode[session.mode]())
        rows.append((f"{session.view.magnification:.0%}", "Zoom: press for others", False))
        return rows

    def _find_place(self) -> None:
        """Look up what is under the pointer; a gesture that bends the picture need not wait for it in every frame."""
        session, mesh, is_busy = self._editor.session, self._editor.answer.mesh, self._editor.is_busy
        bends = is_busy and mesh is not self._mesh
        looked_at = session.pointer, session.view, mesh, is_busy
        self._mesh = mesh
        if bends or looked_at == self._looked_at:
            return
        self._looked_at = looked_at
        self._place = self._feature = ""
        if session.pointer is not None:
            x, y = mesh.image_from_canvas(canvas_from_screen(session.view, np.array([session.pointer])))[0]
            self._place = f"{round(x)}, {round(y)}" if np.isfinite(x) else ""
            if np.isfinite(x) and session.mode == "warp" and not is_busy:
                self._feature = self._feature_at(x, y)

    def _feature_at(self, x: float, y: float) -> str:
        """Return the name of the feature at a place of the picture, as the grid has it; nothing where there is none."""
        grid = self._editor.map.grid
        column, row = (round((p + 0.5) / side) for p, side in zip((x, y), grid.cell, strict=True))
        number = int(feature_list(self._editor).nodes(self._editor.document, grid).labels[row, column])
        return next((listed.name for listed in rows_of(self._editor) if listed.id == number), "") if number else ""

    def _warp_figures(self) -> list[Figure]:
        answer = self._editor.map
        if not answer.settled and self._editor.is_busy:
            self._solve_ms, self._moved = answer.solve_ms, answer.document.image
        folds = "no folds" if not answer.folds else "1 fold" if answer.folds == 1 else f"{answer.folds} folds"
        about_folds = "Cells that are turned over; at rest, those that the warp itself does not fold are mended"
        figures = [(f"{answer.grid.columns} × {answer.grid.rows}", "Nodes of the grid, across and down", False)]
        if self._solve_ms and self._moved is answer.document.image:
            figures.append((f"{self._solve_ms:.1f} ms", "The last solve while something moved took so long", False))
        figures.append((folds, about_folds, answer.folds > 0))
        if answer.settled and answer.outline_moved_px:
            about_outline = (
                "Features that the picture's edge cuts would fold if its outline stayed where the warp has it"
            )
            figures.append((f"outline off by {answer.outline_moved_px:.0f} px", about_outline, True))
        missed = answer.result.missed_pins if answer.settled and answer.result is not None else []
        if missed:
            about_pins = "Their points are where the lines lead, or turned less: closer, the picture would fold"
            what = "1 pin missed" if len(missed) == 1 else f"{len(missed)} pins missed"
            figures.append((f"{what} by {max(pin.worst_px for pin in missed):.0f} px", about_pins, True))
        return figures

    def _retexture_figures(self) -> list[Figure]:
        work = self._editor.regrowth
        if work.stage is None or not work.is_final:
            return []
        return [(f"{work.stage.found.patches} patches", "Pieces of texture along the curves", False)]


def _width(figures: list[Figure]) -> float:
    """Return how wide the figures are, in screen pixels."""
    return sum(imgui.calc_text_size(text).x + em(GAP_EM) for text, _, _ in figures)


def _fitting(figures: list[Figure], room: float) -> list[Figure]:
    """Return the figures that `room` screen pixels hold: bad news, shortened at need, and the last of the others."""
    kept = list(figures)
    while _width(kept) > room and not all(fault for _, _, fault in kept):
        kept.remove(next(figure for figure in kept if not figure[2]))
    if _width(kept) <= room:
        return kept
    return [(shorten(text, room / len(kept) - em(GAP_EM)), f"{text}\n{hint}", fault) for text, hint, fault in kept]


def _draw_figures(figures: list[Figure], width: float) -> None:
    """Write the figures, which need `width` screen pixels, at the right; a press on the last, the zoom, lists more."""
    imgui.same_line(max(imgui.get_window_width() - width, imgui.get_cursor_pos_x()))
    for text, hint, fault in figures:
        with colors(text=theme.FAULT if fault else theme.FAINT):
            imgui.text(text)
        tip(hint)
        pressed = imgui.is_item_clicked()
        imgui.same_line(0, em(GAP_EM))
    imgui.new_line()
    if pressed:
        imgui.open_popup(ZOOMS)
