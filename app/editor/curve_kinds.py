"""The curves that a mode edits: which part of the document they are, and which of them is in hand."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from app.editor.editor import Editor
from core.curves import curve_edit
from core.curves.bezier import Curve
from core.document.curves import pairs as curve_pairs
from core.document.curves.snapping import snap
from core.document.document import CurvePair, Document, Mode, places_from_pixels
from core.document.retexture import with_curve

STILL_PX = 1.0
"""A new curve that the deformation moves by less holds its place."""


@dataclass(frozen=True)
class CurveKind:
    """One of the document's tuples of curves."""

    mode: Mode
    part: Literal["curves", "feature_curves"]

    def of(self, document: Document) -> tuple[CurvePair, ...]:
        """Return the curves of `document`."""
        return document.curves if self.part == "curves" else document.feature_curves

    def put(self, document: Document, pairs: Sequence[CurvePair]) -> Document:
        """Return `document` with other curves."""
        return document.changed(**{self.part: tuple(pairs)})

    def replace(self, document: Document, number: int, pair: CurvePair | None) -> Document:
        """Return `document` with one curve exchanged, or taken out."""
        pairs = self.of(document)
        return self.put(document, (*pairs[:number], *(() if pair is None else (pair,)), *pairs[number + 1 :]))

    def number(self, editor: Editor) -> int | None:
        """Return the number of the curve that is being edited, if there is one."""
        number = editor.session.selected_curve
        there = editor.session.mode == self.mode and number is not None and number < len(self.of(editor.document))
        return number if there else None

    def chosen(self, editor: Editor) -> CurvePair | None:
        """Return the curve that is being edited, if there is one."""
        number = self.number(editor)
        return None if number is None else self.of(editor.document)[number]

    def edit(self, editor: Editor, label: str, pair: CurvePair) -> None:
        """Put `pair` in place of the curve that is being edited."""
        number = self.number(editor)
        if number is not None:
            editor.edit(label, self.replace(editor.document, number, pair))

    def toggle_closed(self, editor: Editor) -> None:
        """Close the curve that is being edited, or open it."""
        pair = self.chosen(editor)
        if pair is not None:
            changed = curve_pairs.open_up(pair) if pair.closed else curve_pairs.close(pair)
            self.edit(editor, "Open curve" if pair.closed else "Close curve", changed)

    def snap(self, editor: Editor) -> bool:
        """Bring the curve that is being edited onto the edge beside it, as one undo entry; return whether it moved."""
        number, pair = self.number(editor), self.chosen(editor)
        found = None if pair is None else snap(pair, editor.document.image)
        if number is None or found is None or found is pair:
            return False
        with editor.group("Snap curve to edge"):
            editor.document = self.replace(editor.document, number, found)
        return True

    def remove(self, editor: Editor, number: int) -> None:
        """Take a curve out."""
        editor.edit("Remove curve", self.replace(editor.document, number, None))
        editor.show(selected_curve=None, selected_knots=frozenset(), hover=None)


def with_found_curve(editor: Editor, document: Document, curve: Curve, *, on_result: bool = False) -> Document:
    """Return `document` with a feature curve that was found on the original, or on the result, in pixels.

    It goes along with what other curves move already, so that it changes nothing yet.
    """
    document, mesh = with_curve(document, curve), editor.regrowth.mesh
    seen_through = mesh.image_from_canvas if on_result else mesh.canvas_from_image
    line = seen_through(curve_edit.samples_of(curve.points))
    if np.isnan(line).any():
        return document
    moved = curve_edit.map_along(curve.points, line)
    if np.abs(moved - curve.points).max() < STILL_PX:
        return document
    places, pair = places_from_pixels(document.size_px, moved), document.feature_curves[-1]
    pair = replace(pair, source=places) if on_result else replace(pair, target=places)
    return document.changed(feature_curves=(*document.feature_curves[:-1], pair))


INNER = CurveKind("warp", "curves")
FEATURE = CurveKind("retexture", "feature_curves")
