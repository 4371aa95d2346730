"""Lists of what was put on the picture: pins, inner curves, the outline."""

from dataclasses import replace

import numpy as np
from imgui_bundle import imgui

from app.editor import Editor
from app.ui import theme
from app.ui.controls import colors, faint, heading, icon_button
from app.ui.theme import em
from core.document import Document, pixels_from_places


class HandlesPanel:
    """Shows the handles of the document; a row selects, its cross removes."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor

    def draw(self) -> None:
        """Draw the lists."""
        document = self._editor.document
        if not (document.pins or document.curves or document.outline):
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
            self._editor.edit("Reset outline", replace(document, outline=None))

    def _draw_pins(self, document: Document) -> None:
        heading(f"Pins  {len(document.pins)}", "location-dot")
        selected = self._editor.session.selected
        for number, pin in enumerate(document.pins):
            at, to = pixels_from_places(document.size_px, np.array([pin.at, pin.to]))
            moved = "" if np.abs(to - at).max() < 0.5 else f"  →  {to[0]:.0f}, {to[1]:.0f}"
            text = f"{number + 1}    {at[0]:.0f}, {at[1]:.0f}{moved}##pin {number}"
            flags = imgui.SelectableFlags_.allow_overlap
            if imgui.selectable(text, number in selected, flags)[0]:
                chosen = selected ^ {number} if imgui.get_io().key_shift else {number}
                self._editor.show(selected=frozenset(chosen))
            if _cross(f"pin {number + 1}", "Remove this pin"):
                self._editor.show(selected=frozenset())
                pins = document.pins[:number] + document.pins[number + 1 :]
                self._editor.edit("Remove pin", replace(document, pins=pins))

    def _draw_curves(self, document: Document) -> None:
        heading(f"Inner curves  {len(document.curves)}", "bezier-curve")
        for number, curve in enumerate(document.curves):
            kind = "closed" if curve.closed else "open"
            imgui.text(f"{number + 1}    {len(curve.source) // 3} segments, {kind}")
            if _cross(f"curve {number + 1}", "Remove this curve"):
                curves = document.curves[:number] + document.curves[number + 1 :]
                self._editor.edit("Remove curve", replace(document, curves=curves))


def _cross(name: str, hint: str) -> bool:
    """Return whether the button at the row's end was pressed."""
    imgui.same_line(imgui.get_window_width() - em(3.2))
    with colors(text=theme.FAINT):
        return icon_button(f"remove {name}", "xmark", hint=hint, size_em=1.3)
