"""Edits of a lattice by hand, from the beginning of a gesture to what is shown of it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from app.editor.editor import Editor
from core.arrays import Bools, Points
from core.document.overlay import get_layers
from core.document.overlay_layers import vertices_of
from core.document.overlay_settings import LatticeVertices, Mending, Search


@dataclass(frozen=True)
class LatticeEdit:
    """What an edit goes on from."""

    editor: Editor
    search: Search
    """What was there before the edit."""

    @classmethod
    def begun(cls, editor: Editor) -> "LatticeEdit":
        """Return an edit of the present lattice."""
        search = editor.document.cloth.search
        assert search is not None
        return cls(editor, search)

    def show(
        self,
        lattice: LatticeVertices,
        *,
        hold: Sequence[int] = (),
        release: Sequence[int] = (),
        seam: Points | None = None,
    ) -> None:
        """Make `lattice` that of the document, some of its vertices held or free, with another seam if one is given."""
        before = self.search.mending
        held = keys_of(before.held if before is not None else np.empty((0, 2)))
        held |= keys_of(lattice.keys[list(hold)])
        held -= keys_of(lattice.keys[list(release)])
        held &= keys_of(lattice.keys)
        seams = (*(before.seams if before is not None else ()), *(() if seam is None else (seam,)))
        removed = self._removed(lattice)
        mending = Mending(self._mended, lattice, np.array(sorted(held), np.float64).reshape(-1, 2), seams, removed)
        document = self.editor.document
        search = replace(self.search, mending=mending)
        self.editor.document = document.with_cloth(search=search)

    def _removed(self, lattice: LatticeVertices) -> Points:
        """Return the places (m, 2) of all vertices that were removed, by what is left in `lattice` now, too."""
        before = self.search.mending
        if before is None:
            layers = get_layers(self.editor.document.with_cloth(search=self.search))
            known = None if layers is None else vertices_of(self.editor.document, layers)
        else:
            known = before.lattice
        removed = np.empty((0, 2)) if before is None else before.removed
        if known is None:
            return removed
        left = keys_of(lattice.keys)
        gone = [key not in left for key in map(tuple, np.rint(known.keys).astype(int).tolist())]
        return np.concatenate([removed, known.places[gone]])

    @property
    def _mended(self) -> Search:
        """The search whose layers are mended: the first one where those are known still, else what they came to."""
        mending = self.search.mending
        if mending is None or get_layers(self.editor.document.with_cloth(search=mending.of)) is None:
            return self.search
        return mending.of


def keys_of(keys: Points) -> set[tuple[int, int]]:
    """Return lattice coordinates (n, 2) as a set."""
    return {(int(i), int(j)) for i, j in np.rint(keys)}


def is_held(editor: Editor, lattice: LatticeVertices) -> Bools:
    """Return which vertices (n,) of a lattice are held."""
    search = editor.document.cloth.search
    if search is None or search.mending is None:
        return np.zeros(len(lattice.keys), np.bool_)
    held = keys_of(search.mending.held)
    return np.array([tuple(key) in held for key in np.rint(lattice.keys).astype(int).tolist()], np.bool_)
