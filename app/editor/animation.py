"""The timeline: which frame is shown, what the document is at it, and playing.

The history keeps a document with its keys. The editor shows it as it is at the present frame; where an edit changes a
value that has keys, the value becomes a key at that frame.
"""

import math
from typing import TYPE_CHECKING

from core.document.animated import is_animated, pose, set_keys
from core.document.document import Document

if TYPE_CHECKING:
    from app.editor.editor import Editor


class Animation:
    """Goes from frame to frame, by hand or by the clock."""

    def __init__(self, editor: "Editor") -> None:
        self._editor = editor
        self._shown: tuple[Document, float, Document] | None = None
        """A document of the history, a frame, and the document as it is there."""
        self._began: tuple[float, int] | None = None
        """When playing began, by the editor's clock, and at which frame; None while it does not play."""
        self.open_up()

    @property
    def is_playing(self) -> bool:
        """Whether frames follow one another by themselves."""
        return self._began is not None

    def show(self, document: Document) -> Document:
        """Return a document of the history as it is at the present frame, the same object while neither changes."""
        frame = self._editor.session.frame
        if self._shown is None or self._shown[0] is not document or self._shown[1] != frame:
            self._shown = document, frame, pose(document, frame)
        return self._shown[2]

    def take(self, document: Document) -> Document:
        """Return what the history is to keep of an edited document: with keys where values that have keys changed."""
        if self._shown is not None and document is self._shown[2]:
            return self._shown[0]
        return set_keys(document, self._editor.session.frame)

    def edit(self, label: str, document: Document) -> None:
        """Make a document with other keys the present one; its values follow them."""
        self._editor.edit(label, pose(document, self._editor.session.frame))

    def slide(self, label: str, document: Document) -> None:
        """Show a document with other keys while they are dragged; one undo entry until the editor finishes."""
        self._editor.slide(label, pose(document, self._editor.session.frame))

    def open_up(self) -> None:
        """Show the first frame of a document that was opened, and the timeline of one that has keys."""
        editor = self._editor
        self.stop()
        first, timeline = editor.history.document.span.first, editor.session.timeline
        is_shown = timeline or is_animated(editor.history.document)
        editor.show(frame=first, timeline=is_shown, selected_keys=frozenset())

    def go_to(self, frame: float) -> None:
        """Finish what is in progress and show the nearest frame of the timeline; playing ends there."""
        self.stop()
        self._show_frame(frame)

    def toggle(self) -> None:
        """Play from the present frame on, from the first where that is the last; or stop."""
        if self.is_playing:
            self.stop()
            return
        span, frame = self._editor.document.span, self._editor.session.frame
        self._editor.finish()
        self._began = self._editor.clock(), span.first if frame >= span.last else frame
        self._show_frame(self._began[1])

    def stop(self) -> None:
        """End playing at the frame that is shown."""
        self._began = None

    def let_go(self) -> None:
        """End playing and select no key: the artist's hand is on the picture."""
        self.stop()
        if self._editor.session.selected_keys:
            self._editor.show(selected_keys=frozenset())

    def update(self) -> None:
        """Show the frame that is due; once a frame of the window."""
        if self._began is None:
            return
        span, passed = self._editor.document.span, self._passed()
        frame = self._began[1] + passed
        if frame > span.last and not self._editor.session.loops:
            self.go_to(span.last)
        else:
            self._show_frame(span.first + (frame - span.first) % (span.last - span.first + 1))

    @property
    def wait_s(self) -> float | None:
        """Seconds until the next frame is due; None while it does not play."""
        if self._began is None:
            return None
        due = self._began[0] + (self._passed() + 1) / self._editor.document.span.rate
        return max(0.0, due - self._editor.clock())

    def _passed(self) -> int:
        """Return how many frames have gone by since playing began."""
        assert self._began is not None
        return math.floor((self._editor.clock() - self._began[0]) * self._editor.document.span.rate + 1e-9)

    def _show_frame(self, frame: float) -> None:
        span = self._editor.document.span
        number = min(max(round(frame), span.first), span.last)
        if number != self._editor.session.frame:
            self._editor.finish()
            self._editor.show(frame=number, hover=None)
