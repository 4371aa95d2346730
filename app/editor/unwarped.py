"""The picture as it was, which Warp mode shows while something is painted or selected on it.

On the warped picture, what is painted keeps its shape at once, and so runs away under the brush.
"""

from typing import TYPE_CHECKING

import numpy as np

from app.live.answer import Answer
from app.model.spaces import View, canvas_from_screen, move
from core.document.document import Document
from core.mesh import Mesh

if TYPE_CHECKING:
    from app.editor.editor import Editor

SEEN_PX = 0.5
"""A warp that moves nothing farther is none."""


class Unwarped:
    """Says when the picture as it was is shown, and gives the map that leaves it so."""

    def __init__(self, editor: "Editor") -> None:
        self._editor = editor
        self._answer: Answer | None = None
        self._warped_by: tuple[object, ...] | None = None
        """What warped the picture in the frame before."""
        self._views: tuple[View, View] | None = None
        """The view that the picture as it was is shown in, and the one before, where the former is not the artist's."""

    @property
    def is_shown(self) -> bool:
        """Whether the canvas shows the picture as it was; a split view shows both."""
        session = self._editor.session
        return session.unwarped and session.mode == "warp" and session.compare != "split"

    @property
    def _warps(self) -> bool:
        """Whether the picture is warped at all."""
        shown = self._editor.map
        return bool(np.abs(shown.warped - shown.rest).max() > SEEN_PX)

    def answer(self) -> Answer:
        """Return the map that leaves the picture as it is."""
        document, grid = self._editor.document, self._editor.map.grid
        if self._answer is None or self._answer.document is not document or self._answer.grid is not grid:
            self._answer = Answer(document, Mesh(grid, grid.nodes), None, settled=True)
        return self._answer

    def show_at(self, pos: tuple[float, float]) -> None:
        """Show the picture as it was, with the place of it that is at a screen position still there."""
        session, shown = self._editor.session, self._editor.map
        if self.is_shown or session.mode != "warp" or session.compare == "split" or not session.paints_unwarped:
            return
        if not self._warps:
            return
        place = shown.mesh.image_from_canvas(canvas_from_screen(session.view, np.array([pos])))[0]
        self._editor.show(unwarped=True)
        if np.isfinite(place).all():
            x, y = pos - (place * session.view.zoom + session.view.pan)
            view = move(session.view, (float(x), float(y)))
            self._views = view, session.view
            self._editor.show(view=view)

    def show(self) -> None:
        """Show the picture as it was, where something warps it."""
        self._editor.show(unwarped=self._warps and self._editor.session.paints_unwarped)

    def hide(self) -> None:
        """Show the warped picture again, in the view that it had."""
        if not self._editor.session.unwarped:
            return
        views, self._views = self._views, None
        self._editor.show(unwarped=False)
        if views is not None and self._editor.session.view == views[0]:
            self._editor.show(view=views[1])

    def toggle(self) -> None:
        """Show the other of both pictures, and paint on that from now on; where nothing is warped both are the same."""
        session = self._editor.session
        paints = not (session.unwarped if self._warps else session.paints_unwarped)
        self._editor.show(paints_unwarped=paints)
        (self.show if paints else self.hide)()

    def update(self) -> None:
        """Show the warped picture when something else warps it: that is what the artist wants to see; once a frame."""
        by = _warped_by(self._editor.document)
        if self._warped_by is not None and by != self._warped_by:
            self.hide()
        self._warped_by = by


def _warped_by(document: Document) -> tuple[object, ...]:
    warps = document.warp, document.warp_map, document.surface, document.outline
    return document.image, *warps, document.pins, document.curves
