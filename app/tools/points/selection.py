"""Points that are selected by clicks, Shift and a rectangle, and dragged together: one way of it for every tool."""

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Literal

from app.editor.editor import Editor
from app.model.events import Event, Move, Position, Press
from app.model.gestures import Gesture
from app.tools.points import band
from app.tools.points.grips import drag_from, within
from core.arrays import Points


@dataclass(frozen=True)
class Selection:
    """Which points of a tool are selected."""

    field: Literal["selected", "selected_corners", "selected_knots", "selected_vertices"]
    """Where the session keeps their numbers."""
    numbers: Callable[[Editor], frozenset[int]]
    """Those of them that there are."""

    def choose(self, editor: Editor, numbers: frozenset[int]) -> None:
        """Select other points."""
        editor.show(**{self.field: numbers})

    def grip(self, editor: Editor, press: Press, number: int) -> Generator[None, Event, Move | None]:
        """Select a point, with Shift beside the others, and return the move that begins to drag what is selected.

        None is for a click: it leaves the point selected alone; with Shift, not selected if it was.
        """
        before, shift = self.numbers(editor), press.mods.shift
        if number not in before:
            self.choose(editor, before | {number} if shift else frozenset({number}))
        first = yield from drag_from(press.pos)
        if first is None and number in before:
            self.choose(editor, before - {number} if shift else frozenset({number}))
        return first

    def grip_box(self, editor: Editor, press: Press) -> Generator[None, Event, Move | None]:
        """Return the move that begins to drag the box around what is selected; a click deselects, and returns None."""
        first = yield from drag_from(press.pos)
        if first is None:
            self.choose(editor, frozenset())
        return first

    def span(self, editor: Editor, press: Press, points: Callable[[], Points]) -> Gesture:
        """Select those of the points (n, 2) that lie in a rectangle, with Shift beside those that are selected."""
        before = self.numbers(editor) if press.mods.shift else frozenset[int]()
        self.choose(editor, before)

        def take(a: Position, b: Position) -> None:
            self.choose(editor, before | frozenset(within(points(), a, b).tolist()))

        yield from band.span(editor, press, take)
