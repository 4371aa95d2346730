"""The canvas: hands the pointer and the keys to the editor, and draws over the picture what is not picture."""

import numpy as np
from imgui_bundle import ImVec2, imgui

from app.actions.table import ActionTable
from app.actions.view import whole
from app.editor.editor import Editor
from app.model.events import Event, Key, KeyUp, Modifiers, Move, Press, Release
from app.model.spaces import View
from app.tools.marks import marks
from app.ui.canvas.comparing import draw_legend, draw_onion
from app.ui.canvas.input import Area, Chords, Pointer
from app.ui.canvas.marks import MarkPainter
from app.ui.widgets import theme
from app.ui.widgets.picture_texture import PictureTexture
from app.ui.widgets.theme import color, em, icon

CURSORS = {
    "arrow": imgui.MouseCursor_.arrow,
    "cross": imgui.MouseCursor_.arrow,
    "hand": imgui.MouseCursor_.hand,
    "move": imgui.MouseCursor_.resize_all,
    "none": imgui.MouseCursor_.none,
}


class CanvasWidget:
    """Where the picture is, between the panels."""

    def __init__(self, editor: Editor, table: ActionTable, picture: PictureTexture) -> None:
        self.editor = editor
        self._picture = picture
        self._table = table
        self.area = Area(0, 0, 1, 1)
        self._pointer = Pointer()
        self._chords = Chords()
        self._holds_divider = False

    def hear_pointer(self, x: float, y: float) -> None:
        """Take note of a place that the mouse passes between two frames."""
        self._pointer.trail.append((x, y))

    def hear_key(self, modifiers: Modifiers) -> None:
        """Take note of what was held when a key went down; before the next frame it may be let go."""
        self._chords.hear(modifiers)

    def lay_out(self, area: Area, *, is_whole: bool) -> None:
        """Take the place that the panels leave; the middle stays in the middle, a picture seen whole stays whole."""
        if area == self.area:
            return
        self.area, view = area, self.editor.session.view
        grown, (width, height), old = view.unit / area.unit, area.size, view.size
        pan = ((width - old[0] * grown) / 2 + view.pan[0] * grown, (height - old[1] * grown) / 2 + view.pan[1] * grown)
        self.editor.show(view=View(view.zoom * grown, pan, area.size, area.unit))
        if is_whole:
            self.editor.show(view=whole(self.editor))

    def take_input(self) -> None:
        """Send what mouse and keyboard did to the editor."""
        held_at_press = self._chords.take()
        if imgui.is_popup_open("", imgui.PopupFlags_.any_popup_id | imgui.PopupFlags_.any_popup_level):
            return
        for event in self._pointer.events(self.area):
            if not self._move_divider(event):
                self.editor.handle(event)
        for key in self._chords.events(held_at_press):
            if isinstance(key, KeyUp):
                self._table.release(key.name, self.editor)
            if not self.editor.handle(key) and isinstance(key, Key):
                self._table.press(key, self.editor)
        if not self._pointer.is_held and not self.is_under_pointer and self.editor.session.pointer is not None:
            self.editor.show(pointer=None, hover=None)

    @property
    def is_under_pointer(self) -> bool:
        """Whether the pointer is on the canvas and on nothing that lies over it."""
        io = imgui.get_io()
        return not io.want_capture_mouse and self.area.holds(io.mouse_pos.x, io.mouse_pos.y)

    def draw(self) -> None:
        """Draw marks, the divider of the split view and the pointer."""
        sheet = imgui.get_background_draw_list()
        area, session = self.area, self.editor.session
        sheet.push_clip_rect((area.x, area.y), (area.x + area.width, area.y + area.height))
        if session.compare == "onion":
            draw_onion(sheet, self.editor, self._picture, area)
        if session.compare != "before":
            left = self._divider_x if session.compare == "split" else area.x
            sheet.push_clip_rect((left, area.y), (area.x + area.width, area.y + area.height), True)
            MarkPainter(sheet, area).draw(marks(self.editor))
            sheet.pop_clip_rect()
        if session.compare == "split":
            self._draw_divider(sheet)
        heat = session.overlays.heat
        if heat is not None and session.mode != "overlay" and session.compare != "before":
            draw_legend(sheet, heat, area)
        if session.compare in ("before", "split") or self.editor.unwarped.is_shown:
            self._draw_labels(sheet)
        sheet.pop_clip_rect()
        if self._pointer.is_held or self.is_under_pointer:
            imgui.set_mouse_cursor(self._cursor())

    def _cursor(self) -> imgui.MouseCursor_:
        pointer = self.editor.session.pointer
        if self._holds_divider or (pointer is not None and self._on_divider(pointer)):
            return imgui.MouseCursor_.resize_ew
        return CURSORS[self.editor.tool.cursor]

    @property
    def _divider_x(self) -> float:
        """Where the divider of the split view is in the window."""
        return self.area.x + self.editor.session.split * self.area.width

    def _on_divider(self, pos: tuple[float, float]) -> bool:
        session = self.editor.session
        return session.compare == "split" and abs(pos[0] - session.split * self.area.size[0]) < theme.TEXT_PX * 0.45

    def _move_divider(self, event: Event) -> bool:
        """Drag the divider of the split view; return whether the event was for it."""
        if isinstance(event, Press) and event.button == "left":
            self._holds_divider = self._on_divider(event.pos)
        held = self._holds_divider
        if held and isinstance(event, Move):
            self.editor.show(split=float(np.clip(event.pos[0] / max(self.area.size[0], 1), 0.02, 0.98)))
        if isinstance(event, Release):
            self._holds_divider = False
        return held

    def _draw_divider(self, sheet: imgui.ImDrawList) -> None:
        area = self.area
        x, middle = self._divider_x, area.y + area.height / 2
        sheet.add_line((x, area.y), (x, area.y + area.height), color(theme.LINE, 0.7), em(0.22))
        sheet.add_line((x, area.y), (x, area.y + area.height), color(theme.TEXT), em(0.1))
        sheet.add_circle_filled((x, middle), em(0.95), color(theme.LINE, 0.8))
        sheet.add_circle((x, middle), em(0.95), color(theme.TEXT), 0, em(0.1))
        text = icon("left-right")
        size = imgui.calc_text_size(text)
        sheet.add_text(ImVec2(x - size.x / 2, middle - size.y / 2), color(theme.TEXT), text)

    def _draw_labels(self, sheet: imgui.ImDrawList) -> None:
        """Say which side is which."""
        session, area = self.editor.session, self.area
        divider = self._divider_x
        if session.compare == "before":
            self._badge(sheet, "Before", area.x + area.width / 2, 0.5)
        elif self.editor.unwarped.is_shown:
            self._badge(sheet, "As it was, to paint on  ·  J shows the result", area.x + area.width / 2, 0.5)
        else:
            sides = (session.look_before, session.look) if session.mode == "retexture" else ("before", "after")
            for side, x, share in zip(sides, (divider - em(0.8), divider + em(0.8)), (1.0, 0.0), strict=True):
                self._badge(sheet, side.capitalize(), x, share)

    def _badge(self, sheet: imgui.ImDrawList, text: str, x: float, share: float) -> None:
        """Write `text` on a dark plate near the canvas's upper edge, `share` of its width to the left of `x`."""
        size, pad = imgui.calc_text_size(text), em(0.5)
        left, top = x - (size.x + 2 * pad) * share, self.area.y + em(0.8)
        low, high = (left, top), (left + size.x + 2 * pad, top + size.y + pad)
        sheet.add_rect_filled(low, high, color(theme.LINE, 0.75), em(0.3))
        sheet.add_text(ImVec2(left + pad, top + pad / 2), color(theme.TEXT), text)
