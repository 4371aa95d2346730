"""The curves that a mode edits: which part of the document they are, and which of them is in hand."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from app.editor import Editor
from core import curve_pairs
from core.document import CurvePair, Document, Mode


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

    def replaced(self, document: Document, number: int, pair: CurvePair | None) -> Document:
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
            editor.edit(label, self.replaced(editor.document, number, pair))

    def toggle_closed(self, editor: Editor) -> None:
        """Close the curve that is being edited, or open it."""
        pair = self.chosen(editor)
        if pair is not None:
            changed = curve_pairs.opened(pair) if pair.closed else curve_pairs.closed(pair)
            self.edit(editor, "Open curve" if pair.closed else "Close curve", changed)

    def remove(self, editor: Editor, number: int) -> None:
        """Take a curve out."""
        editor.edit("Remove curve", self.replaced(editor.document, number, None))
        editor.show(selected_curve=None, selected_knots=frozenset(), hover=None)


INNER = CurveKind("warp", "curves")
FEATURE = CurveKind("retexture", "feature_curves")
