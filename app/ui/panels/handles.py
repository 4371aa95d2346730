"""Lists of what was put on the picture: pins, inner curves, the outline."""

from contextlib import nullcontext

import numpy as np
from imgui_bundle import imgui

from app.editor.curve_kinds import FEATURE, INNER
from app.editor.editor import Editor
from app.tools import outline, pin_ring, pins
from app.ui.widgets import theme
from app.ui.widgets.controls import colors, faint, heading, icon_button, tip
from app.ui.widgets.key_button import key_button
from app.ui.widgets.sliders import number_box
from app.ui.widgets.theme import em
from core.arrays import Points
from core.document.document import CurvePair, Document, pixels_from_places, places_from_pixels
from core.document.ring import RING_SCALES, Ring

CORNERS = ("top left", "top right", "bottom right", "bottom left")
MOST_PX = 1e6
"""A handle may be so far off."""


class HandlesPanel:
    """Shows the handles of the document; a row selects, its cross removes."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor

    def draw(self) -> None:
        """Draw the lists."""
        document = self._editor.document
        if self._editor.session.mode == "retexture":
            self._draw_feature_curves(document)
            return
        self._draw_corner(document)
        if not (document.pins or document.curves or document.outline or outline.find_selected(self._editor)):
            faint(
                "No handles yet. Click with the pin tool to hold or move a place, draw inner curves with the pen, "
                "or drag the outline's corners and sides."
            )
            return
        if document.outline is not None:
            self._draw_outline(document)
        if document.pins:
            self._draw_pins(document)
        if document.curves:
            self._draw_curves(document)

    def _draw_outline(self, document: Document) -> None:
        heading("Outline", "vector-square")
        imgui.text("Dragged by hand")
        if _cross("outline", "Straighten the outline"):
            self._editor.edit("Reset outline", document.changed(outline=None))

    def _draw_corner(self, document: Document) -> None:
        """Draw where the one selected corner is, to be typed."""
        corners = outline.find_selected(self._editor)
        if self._editor.session.tool != "outline" or len(corners) != 1:
            return
        (corner,) = corners
        heading(f"Corner at the {CORNERS[corner]}", "vector-square")
        place = pixels_from_places(document.canvas_px, outline.find_outline(self._editor).ring[3 * corner])
        typed = _typed_place(f"corner {corner}", place)
        if typed is not None:
            self._editor.edit("Move corner", outline.move_by(self._editor, corners, typed - place))

    def _draw_pins(self, document: Document) -> None:
        heading(f"Pins  {len(document.pins)}", "location-dot")
        selected = self._editor.session.selected
        all_at = pixels_from_places(document.size_px, np.array([pin.at for pin in document.pins])).tolist()
        all_to = pixels_from_places(document.canvas_px, np.array([pin.to for pin in document.pins])).tolist()
        for number, (at, to) in enumerate(zip(all_at, all_to, strict=True)):
            moved = "" if max(abs(to[0] - at[0]), abs(to[1] - at[1])) < 0.5 else f"  →  {to[0]:.0f}, {to[1]:.0f}"
            missed = pins.measure_miss_px(self._editor, number)
            # In the row itself: one more would move the boxes below while somebody types in them.
            by = f"    misses by {missed:.0f} px" if missed else ""
            text = f"{number + 1}    {at[0]:.0f}, {at[1]:.0f}{moved}{by}##pin {number}"
            flags = imgui.SelectableFlags_.allow_overlap
            key_button(self._editor, number, is_low=True)
            with colors(text=theme.FAULT) if missed else nullcontext():
                pressed = imgui.selectable(text, number in selected, flags)[0]
            if missed:
                tip(f"Its point is {missed:.1f} px from here: closer, the picture would fold")
            if pressed:
                chosen = selected ^ {number} if imgui.get_io().key_shift else {number}
                self._editor.show(selected=frozenset(chosen))
            if _cross(f"pin {number + 1}", "Remove this pin"):
                pins.remove(self._editor, (number,))
            elif selected == {number}:
                self._draw_place(document, number)

    def _draw_place(self, document: Document, number: int) -> None:
        """Draw where a pin goes, to be typed."""
        place = pixels_from_places(document.canvas_px, np.array(document.pins[number].to))
        typed = _typed_place(f"pin {number}", place)
        if typed is not None:
            to = places_from_pixels(document.canvas_px, typed[None])
            self._editor.edit("Move pin", pins.with_targets(document, (number,), to))
            return
        self._draw_ring(number)

    def _draw_ring(self, number: int) -> None:
        """Draw how the picture is turned and scaled around a pin, to be typed."""
        ring = pin_ring.find_ring(self._editor, number)
        holds = self._editor.document.pins[number].ring is not None
        imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + em(1.4))
        turned = _typed("Turn", ring.turn_deg, -360, 360, "In degrees, clockwise, against the picture without handles")
        imgui.same_line(0, em(1.0))
        scaled = _typed("Scale", 100 * ring.scale, 100 * RING_SCALES[0], 100 * RING_SCALES[1], "In per cent")
        if turned is not None or scaled is not None:
            typed = Ring(ring.turn_deg if turned is None else turned, ring.scale if scaled is None else scaled / 100)
            self._editor.edit("Turn and scale pin", pin_ring.with_ring(self._editor.document, number, typed))
        elif holds and _cross(f"ring {number + 1}", "Let the picture turn and scale here as it will"):
            pin_ring.remove(self._editor, number)
        else:
            self._draw_stiffness(number)

    def _draw_stiffness(self, number: int) -> None:
        """Draw how far around a pin the picture keeps its shape, to be typed."""
        document = self._editor.document
        diagonal = float(np.hypot(*document.size_px))
        imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + em(1.4))
        hint = "So far around it the picture keeps its shape, and goes and turns with the pin; in pixels of the picture"
        typed = _typed("Stiff within", diagonal * document.pins[number].stiff, 0, diagonal, hint)
        if typed is not None:
            self._editor.edit("Stiff pin", pins.with_stiffness(document, (number,), typed / diagonal))

    def _draw_curves(self, document: Document) -> None:
        heading(f"Inner curves  {len(document.curves)}", "bezier-curve")
        for number, curve in enumerate(document.curves):
            kind = "closed" if curve.closed else "open"
            imgui.text(f"{number + 1}    {_segments(curve)}, {kind}")
            if _cross(f"curve {number + 1}", "Remove this curve"):
                INNER.remove(self._editor, number)

    def _draw_feature_curves(self, document: Document) -> None:
        """Draw a row for every feature curve: a press selects it."""
        if not document.feature_curves:
            faint("No feature curves yet. Draw one with the pen (C), trace an edge (T), or let edges be suggested.")
            return
        heading(f"Feature curves  {len(document.feature_curves)}", "bezier-curve")
        editor = self._editor
        for number, pair in enumerate(document.feature_curves):
            kind = "passive" if pair.passive else f"moved by {_moved_px(document, pair):.0f} px"
            closed = ", closed" if pair.closed else ""
            text = f"{number + 1}    {_segments(pair)}{closed}, {kind}##feature {number}"
            chosen = number == editor.session.selected_curve
            if imgui.selectable(text, chosen, imgui.SelectableFlags_.allow_overlap)[0]:
                editor.choose_tool("feature-curves")
                editor.show(selected_curve=number, selected_knots=frozenset())
            if _cross(f"feature {number + 1}", "Remove this curve"):
                FEATURE.remove(editor, number)


def _segments(pair: CurvePair) -> str:
    """Say of how many cubic segments a curve is made."""
    count = len(pair.source) // 3
    return "1 segment" if count == 1 else f"{count} segments"


def _typed_place(name: str, place: Points) -> Points | None:
    """Draw boxes for a position (2,) in pixels of the result; return the new one when one was typed."""
    imgui.push_id(name)
    typed = place.copy()
    done = False
    for axis, text in enumerate("xy"):
        if axis:
            imgui.same_line(0, em(1.0))
        else:
            imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + em(1.4))
        imgui.align_text_to_frame_padding()
        with colors(text=theme.FAINT):
            imgui.text(text.upper())
        imgui.same_line(0, em(0.4))
        held = number_box(float(place[axis]), -MOST_PX, MOST_PX, 1, name=text, width_em=5.0)
        if held.value is not None:
            typed[axis], done = held.value, True
        tip("In pixels of the result; beyond its frame too")
    imgui.pop_id()
    return typed if done else None


def _typed(name: str, value: float, low: float, high: float, hint: str) -> float | None:
    """Draw a named box for a number; return the new one when one was typed."""
    imgui.align_text_to_frame_padding()
    with colors(text=theme.FAINT):
        imgui.text(name)
    imgui.same_line(0, em(0.4))
    held = number_box(value, low, high, 1, name=name, width_em=4.0)
    tip(hint)
    return held.value


def _moved_px(document: Document, pair: CurvePair) -> float:
    """Return how far a curve's target lies from it at most, in pixels."""
    apart = (
        (pair.target - pair.source) * document.size_px if pair.target.shape == pair.source.shape else np.zeros((1, 2))
    )
    return float(np.hypot(*apart.T).max())


def _cross(name: str, hint: str) -> bool:
    """Return whether the button at the row's end was pressed."""
    imgui.same_line(imgui.get_window_width() - em(3.2))
    with colors(text=theme.FAINT):
        return icon_button(f"remove {name}", "xmark", hint=hint, size_em=1.3)
