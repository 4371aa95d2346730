"""Stiff pins: so far around one the picture is a feature, which keeps its shape and goes and turns with the pin."""

import numpy as np

from core.arrays import Floats, Points, readonly
from core.document.document import Document, pixels_from_places
from core.grid import Features, Grid
from core.selection.features import MOST


class StiffNodes:
    """The features of a document and its stiff pins, as they fall on the nodes of one grid."""

    def __init__(self, grid: Grid) -> None:
        self._grid = grid
        self._last: tuple[Features, object, Features] | None = None

    def add(self, painted: Features, document: Document) -> Features:
        """Return the painted features, and those of stiff pins; the same object as before for the same ones.

        What is painted stays as it is, and a pin in it adds nothing. Where two pins reach, the nearer has the node.
        """
        pins = tuple((pin.at, pin.stiff) for pin in document.pins if pin.stiff > 0)
        if not pins:
            return painted
        if self._last is None or self._last[0] is not painted or self._last[1] != pins:
            size = document.size_px
            at = pixels_from_places(size, np.array([place for place, _ in pins]))
            radii = np.array([share for _, share in pins]) * float(np.hypot(*size))
            self._last = painted, pins, self._labelled(painted, at, radii)
        return self._last[2]

    def _labelled(self, painted: Features, at: Points, radii: Floats) -> Features:
        """Return the features with discs around places (n, 2), numbered from above all others on."""
        labels = painted.labels
        away = np.linalg.norm(self._grid.nodes[..., None, :] - at, axis=-1)
        own = labels.ravel()[away.reshape(-1, len(at)).argmin(axis=0)]
        away = np.where((away <= radii) & (own == 0), away, np.inf)
        first = max(int(labels.max(initial=0)), MOST) + 1
        free = (labels == 0) & np.isfinite(away.min(axis=-1))
        return Features(readonly(np.where(free, first + away.argmin(axis=-1), labels).astype(np.int32)))
