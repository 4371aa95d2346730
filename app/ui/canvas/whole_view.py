"""Keeps a picture that is seen whole inside the window, when a warp or another mode makes it larger."""

import numpy as np

from app.actions.view import reach, whole
from app.editor.editor import Editor
from app.model.spaces import View, screen_from_canvas


class WholeView:
    """Follows the view: as long as the artist has not chosen a part of the picture, all of it stays in sight."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._view: View | None = None
        """The view of the frame before."""
        self.is_whole = False
        """Whether the view is one that showed the whole picture when it was chosen."""
        self._size_px: tuple[int, int] | None = None
        """Of the result, the frame before."""
        self._preset: str | None = None
        """Of the warp, the frame before."""

    def update(self) -> None:
        """Look at the view, once a frame, and fit it anew where the picture has run out, or has another size or preset.

        Not while a hand holds it, nor after the hand has given it its size, nor where keys give it one.
        """
        session, document = self._editor.session, self._editor.answer.document
        view, is_given = session.view, "size" in document.tracks or document.canvas_px == session.resizing.dragged_px
        is_resized = document.canvas_px != self._size_px and not is_given
        is_other = is_resized or document.warp.preset != self._preset
        self._size_px, self._preset = document.canvas_px, document.warp.preset
        if view != self._view:
            self._view, self.is_whole = view, view == whole(self._editor)
        elif self.is_whole and not self._editor.is_busy and (is_other or not _holds(view, self._editor)):
            self._view = whole(self._editor)
            self._editor.show(view=self._view)


def _holds(view: View, editor: Editor) -> bool:
    """Return whether all of picture and canvas is in sight."""
    low, high = (screen_from_canvas(view, corner) for corner in reach(editor))
    return bool((low >= 0).all() and (high <= np.asarray(view.size)).all())
