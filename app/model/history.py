"""Undo: a list of documents and a place between them. There is no inverse code.

One entry per gesture: whatever happens inside `group` is one entry, and nothing at all when the group is left by an
exception, `GeneratorExit` of a cancelled gesture included.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass

import numpy as np
from numpy.typing import NDArray

from core.document.document import Document


@dataclass(frozen=True)
class Entry:
    """A document and what made it from the one before."""

    label: str
    document: Document


class History:
    """The present document, those before it and those undone; at most `budget_bytes` beyond the present one."""

    def __init__(self, document: Document, *, saved: bool = True, budget_bytes: int = 512 << 20) -> None:
        self.document = document
        """The present. Set it inside `group` only."""
        self._entries = [Entry("Open", document)]
        self._index = 0
        self._saved = document if saved else None
        self._depth = 0
        self._open_label: str | None = None
        """Label of the last entry while another edit may still join it."""
        self.budget_bytes = budget_bytes
        """What the arrays that only history holds may take."""

    @property
    def is_saved(self) -> bool:
        """Whether the present document is the one last saved or opened."""
        return self.document is self._saved

    @property
    def undo_label(self) -> str | None:
        """What undo would take back."""
        return self._entries[self._index].label if self._index > 0 else None

    @property
    def redo_label(self) -> str | None:
        """What redo would do again."""
        return self._entries[self._index + 1].label if self._index + 1 < len(self._entries) else None

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of all entries, the oldest first."""
        return tuple(entry.label for entry in self._entries)

    @property
    def index(self) -> int:
        """Number of the present entry in `labels`."""
        return self._index

    def mark_saved(self, document: Document) -> None:
        """Remember `document` as the one on disk."""
        self._open_label = None
        self._saved = document

    @contextmanager
    def group(self, label: str, *, joins: bool = False) -> Iterator[None]:
        """Make one entry of all edits in the block; take them back when it is left by an exception.

        With `joins` the entry is one with the last if that has the same label and nothing happened since.
        """
        start = self.document
        self._depth += 1
        try:
            yield
        except BaseException:
            self.document = start
            raise
        finally:
            self._depth -= 1
        if self._depth == 0:
            self._commit(label, joins=joins)

    def undo(self) -> None:
        """Go back by one entry."""
        self.go_to(self._index - 1)

    def redo(self) -> None:
        """Go forward by one entry."""
        self.go_to(self._index + 1)

    def go_to(self, index: int) -> None:
        """Make entry number `index`, or the nearest there is, the present one."""
        self._open_label = None
        self._index = min(max(index, 0), len(self._entries) - 1)
        self.document = self._entries[self._index].document

    def _commit(self, label: str, *, joins: bool) -> None:
        """Keep the present as an entry unless nothing changed."""
        if self.document is self._entries[self._index].document:
            return
        if joins and self._open_label == label:
            self._entries[self._index] = Entry(label, self.document)
        else:
            self._entries[self._index + 1 :] = [Entry(label, self.document)]
            self._index += 1
        self._open_label = label if joins else None
        self._forget()

    def _forget(self) -> None:
        """Drop the oldest entries while the arrays that only history holds exceed the budget."""
        kept = {id(a) for a in _find_arrays(self.document)}
        total = 0
        for number in range(len(self._entries) - 1, -1, -1):
            for array in _find_arrays(self._entries[number].document):
                if id(array) not in kept:
                    kept.add(id(array))
                    total += array.nbytes
            if total > self.budget_bytes:
                del self._entries[: number + 1]
                self._index -= number + 1
                return


def _find_arrays(value: object) -> Iterator[NDArray[np.generic]]:
    """Yield every array inside a document or a part of one."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from _find_arrays(item)
    elif is_dataclass(value):
        for entry in fields(value):
            yield from _find_arrays(getattr(value, entry.name))
