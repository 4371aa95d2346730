"""The chart of the timeline: a ruler of frames, and a row of keys for everything that has some.

A drag along the ruler shows the frames under it. Keys are selected by a press or a rectangle, and dragged from frame
to frame; a double click in a row puts a key there.
"""

from collections.abc import Collection
from itertools import pairwise

from imgui_bundle import ImVec2, imgui

from app.actions.timeline import EASING_LABELS
from app.editor.editor import Editor
from app.marking import keying
from app.ui.widgets import theme
from app.ui.widgets.controls import Hinted, end_popup, shorten
from app.ui.widgets.key_button import draw_key
from app.ui.widgets.theme import color, em
from core.document.animated import Animated, tracks_of
from core.document.document import Document
from core.document.keys import EASINGS

NAMES_EM, ROW_EM, RULER_EM, MARGIN_EM = 8.0, 1.5, 1.7, 0.9
KEY_EM = 0.42
LABEL_EM = 3.2
"""Numbers on the ruler are so far apart at least."""
STEPS = (1, 2, 5)


class TimelineChart:
    """Draws the chart and acts on the pointer in it."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._left = self._width = self._top = 0.0
        """Where frames begin, how much room they have, and where the rows begin, in screen pixels."""
        self._rows: list[Animated] = []
        self._dragged: tuple[Document, dict[Animated, frozenset[float]], float] | None = None
        """What was there when a drag of keys began, which keys, and where it began in frames."""
        self._band: ImVec2 | None = None
        """Where a rectangle began."""

    def place(self, what: Animated, frame: float) -> ImVec2:
        """Return where a key is in the window."""
        return ImVec2(self._x(frame), self._top + (self._rows.index(what) + 0.5) * em(ROW_EM))

    def ruler_place(self, frame: float) -> ImVec2:
        """Return where a frame is on the ruler, in the window."""
        return ImVec2(self._x(frame), self._ruler_y + em(RULER_EM) / 2)

    def draw(self) -> None:
        """Draw ruler and rows."""
        self.draw_ruler()
        if imgui.begin_child("rows"):
            self._draw_rows()
        imgui.end_child()

    def draw_ruler(self) -> None:
        """Draw the numbers of the frames; a press or a drag shows the frame under the pointer."""
        room, low = imgui.get_content_region_avail().x, imgui.get_cursor_screen_pos()
        names = min(em(NAMES_EM), 0.3 * room)
        self._left, self._ruler_y = low.x + names + em(MARGIN_EM), low.y
        self._width = max(room - names - 2 * em(MARGIN_EM) - imgui.get_style().scrollbar_size, 1.0)
        imgui.invisible_button("ruler", ImVec2(max(room, 1.0), em(RULER_EM)))
        if imgui.is_item_hovered():
            Hinted.text = "Drag to show the frames"
        if imgui.is_item_active():
            self._editor.animation.go_to(self._frame(imgui.get_mouse_pos().x))
        sheet, bottom = imgui.get_window_draw_list(), low.y + em(RULER_EM)
        sheet.add_rect_filled((self._left - em(MARGIN_EM), low.y), (low.x + room, bottom), color(theme.SUNKEN), em(0.2))
        self._draw_numbers(sheet, low.y, bottom)
        self._draw_head(sheet, low.y, bottom, is_ruler=True)

    def _draw_numbers(self, sheet: imgui.ImDrawList, top: float, bottom: float) -> None:
        span = self._editor.document.span
        step = self._step()
        imgui.push_font(None, theme.SMALL_PX)
        for frame in range(-(-span.first // step) * step, span.last + 1, step):
            x = self._x(frame)
            sheet.add_line((x, bottom - em(0.35)), (x, bottom), color(theme.EDGE))
            text = str(frame)
            sheet.add_text(ImVec2(x - imgui.calc_text_size(text).x / 2, top + em(0.1)), color(theme.FAINT), text)
        imgui.pop_font()

    def _step(self) -> int:
        """Return how many frames apart the numbers on the ruler are."""
        span = self._editor.document.span
        least = em(LABEL_EM) / self._width * max(span.last - span.first, 1)
        power = 1
        while True:
            for step in STEPS:
                if step * power >= least:
                    return step * power
            power *= 10

    def _draw_head(self, sheet: imgui.ImDrawList, top: float, bottom: float, *, is_ruler: bool = False) -> None:
        """Draw the line at the frame that is shown; on the ruler with its number on a plate."""
        frame = self._editor.session.frame
        x, shade = self._x(frame), color(theme.ACCENT)
        if not is_ruler:
            sheet.add_line((x, top), (x, bottom), shade, em(0.1))
            return
        imgui.push_font(None, theme.SMALL_PX)
        text = str(frame)
        half = imgui.calc_text_size(text).x / 2 + em(0.3)
        sheet.add_rect_filled((x - half, top), (x + half, bottom - em(0.25)), shade, em(0.2))
        sheet.add_triangle_filled((x - em(0.3), bottom - em(0.3)), (x + em(0.3), bottom - em(0.3)), (x, bottom), shade)
        sheet.add_text(ImVec2(x - half + em(0.3), top + em(0.1)), color(theme.ON_ACCENT), text)
        imgui.pop_font()

    def _draw_rows(self) -> None:
        document, low = self._editor.document, imgui.get_cursor_screen_pos()
        tracks = tracks_of(document)
        self._rows, self._top = list(tracks), low.y
        room = imgui.get_content_region_avail()
        height = max(len(tracks) * em(ROW_EM), room.y)
        imgui.invisible_button("keys", ImVec2(max(room.x, 1.0), max(height, 1.0)))
        hovered = imgui.is_item_hovered()
        under = self._under(imgui.get_mouse_pos()) if hovered else None
        self._act(under, hovered=hovered)
        sheet, chosen = imgui.get_window_draw_list(), self._editor.session.selected_keys
        for number, (what, track) in enumerate(tracks_of(self._editor.document).items()):
            y = low.y + (number + 0.5) * em(ROW_EM)
            if number % 2 == 0:
                sides = (low.x, y - em(ROW_EM) / 2), (low.x + room.x, y + em(ROW_EM) / 2)
                sheet.add_rect_filled(*sides, color(theme.RAISED, 0.6), em(0.2))
            name = shorten(keying.name_of(document, what), self._left - low.x - em(1.6))
            sheet.add_text(ImVec2(low.x + em(0.5), y - imgui.get_font_size() / 2), color(theme.TEXT), name)
            for a, b in pairwise(track):
                shade = color(theme.FAINT if a.easing != "hold" else theme.EDGE, 0.6)
                sheet.add_line((self._x(a.frame), y), (self._x(b.frame), y), shade, em(0.08))
            for key in track:
                lit = (what, key.frame) in chosen or (what, key.frame) == under
                shade = color(theme.ACCENT if lit else theme.TEXT)
                draw_key(sheet, (self._x(key.frame), y), em(KEY_EM), shade, key.easing)
        self._draw_head(sheet, low.y, low.y + height)
        self._draw_band(sheet)
        self._draw_menu()

    def _draw_band(self, sheet: imgui.ImDrawList) -> None:
        if self._band is not None:
            now = imgui.get_mouse_pos()
            sheet.add_rect_filled(self._band, now, color(theme.ACCENT, 0.15))
            sheet.add_rect(self._band, now, color(theme.ACCENT, 0.8))

    def _draw_menu(self) -> None:
        """Draw what the right button offers for the selected keys."""
        chosen = keying.find_chosen_keys(self._editor)
        if not imgui.begin_popup("keys menu"):
            return
        easing = keying.find_easing(self._editor)
        for choice in EASINGS:
            if imgui.menu_item(EASING_LABELS[choice][0], "", choice == easing)[0]:
                keying.ease_keys(self._editor, chosen, choice)
        imgui.separator()
        if imgui.menu_item("Remove", "Delete", False)[0]:
            keying.remove_keys(self._editor, chosen)
        end_popup()

    def _act(self, under: tuple[Animated, float] | None, *, hovered: bool) -> None:
        """Do what the pointer asks for among the rows."""
        if imgui.is_item_activated():
            self._begin(under)
        if imgui.is_item_active():
            self._drag()
        elif self._dragged is not None or self._band is not None:
            self._end()
        if hovered and under is not None:
            imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
            name = keying.name_of(self._editor.document, under[0])
            Hinted.text = f"{name}, frame {under[1]:g} · Drag to move · Shift: several · Right button: easing"
        elif hovered:
            Hinted.text = "Drag to select keys · Double-click puts a key"
        if hovered and under is not None and imgui.is_mouse_clicked(1):
            if under not in self._editor.session.selected_keys:
                keying.select_keys(self._editor, (under,))
            imgui.open_popup("keys menu")

    def _begin(self, under: tuple[Animated, float] | None) -> None:
        """Take what a press is on: a key, the name of a row, or nothing, where a double click puts a key."""
        editor, at = self._editor, imgui.get_mouse_pos()
        selected = editor.session.selected_keys
        several = imgui.get_io().key_shift
        if under is not None:
            if several:
                keying.select_keys(editor, selected ^ {under})
            elif under not in selected:
                keying.select_keys(editor, (under,))
            editor.finish()
            self._dragged = editor.document, keying.find_chosen_keys(editor), self._frame(at.x)
            return
        row = self._row(at.y)
        if row is not None and at.x < self._left - em(MARGIN_EM):
            keying.select_keys(editor, self._keys_of((row,)))
        elif row is not None and imgui.is_mouse_double_clicked(0):
            editor.animation.go_to(self._frame(at.x))
            keying.set_keys(editor, (row,))
            keying.select_keys(editor, ((row, editor.session.frame),))
        else:
            self._band = ImVec2(at.x, at.y)
            keying.select_keys(editor, selected if several else ())

    def _drag(self) -> None:
        """Move the keys that are held; Escape puts them back."""
        if self._dragged is None:
            return
        start, chosen, began = self._dragged
        if imgui.is_key_pressed(imgui.Key.escape):
            self._dragged = None
            self._editor.cancel()
            keying.select_keys(self._editor, {(what, f) for what, frames in chosen.items() for f in frames})
            return
        span, frames = start.span, [frame for some in chosen.values() for frame in some]
        if not frames:
            return
        by = round(self._frame(imgui.get_mouse_pos().x) - began)
        by = min(max(by, round(span.first - min(frames))), round(span.last - max(frames)))
        if by or self._editor.is_busy:
            keying.move_keys(self._editor, start, chosen, by)

    def _end(self) -> None:
        """Keep what a drag did, or select what is in the rectangle."""
        if self._dragged is not None:
            self._editor.finish()
        if self._band is not None:
            a, b = self._band, imgui.get_mouse_pos()
            low, high = sorted((a.x, b.x))
            up, down = sorted((a.y, b.y))
            half = em(ROW_EM) / 2
            rows = [row for row in self._rows if up - half < self.place(row, 0).y < down + half]
            inside = {key for key in self._keys_of(rows) if low <= self._x(key[1]) <= high}
            keying.select_keys(self._editor, self._editor.session.selected_keys | inside)
        self._dragged = self._band = None

    def _keys_of(self, rows: Collection[Animated]) -> set[tuple[Animated, float]]:
        return {(w, key.frame) for w, track in tracks_of(self._editor.document).items() if w in rows for key in track}

    def _under(self, at: ImVec2) -> tuple[Animated, float] | None:
        """Return the key at a place of the window."""
        row = self._row(at.y)
        frames = () if row is None else [key.frame for key in tracks_of(self._editor.document).get(row, ())]
        near = [frame for frame in frames if abs(self._x(frame) - at.x) <= em(KEY_EM) + 2]
        return None if row is None or not near else (row, min(near, key=lambda frame: abs(self._x(frame) - at.x)))

    def _row(self, y: float) -> Animated | None:
        number = int((y - self._top) // em(ROW_EM))
        return self._rows[number] if 0 <= number < len(self._rows) else None

    def _x(self, frame: float) -> float:
        span = self._editor.document.span
        return self._left + (frame - span.first) / max(span.last - span.first, 1) * self._width

    def _frame(self, x: float) -> float:
        span = self._editor.document.span
        return span.first + (x - self._left) / self._width * max(span.last - span.first, 1)
