"""A grid worked on patch by patch: what is computed on the way stays near the processor, and the rest is left out."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from core.arrays import Bools

Window = tuple[slice, slice]

_NODES = 1 << 15
"""Of a patch: half a megabyte of complex numbers."""


@dataclass(frozen=True)
class Patch:
    """Nodes that are written, all their neighbours, which are read, and what lies between these."""

    write: Window
    read: Window
    inner: Window
    """Where the written nodes are among those that are read."""

    @property
    def across(self) -> Window:
        """The edges from left to right between the nodes that are read."""
        return self.read[0], _shorter(self.read[1])

    @property
    def down(self) -> Window:
        """The edges downwards between them."""
        return _shorter(self.read[0]), self.read[1]

    @property
    def quads(self) -> Window:
        """The quads between them."""
        return _shorter(self.read[0]), _shorter(self.read[1])


def cover(nodes: Bools) -> Iterator[Patch]:
    """Yield patches of some rows each that cover the `nodes` (R, C) which are marked."""
    rows, columns = nodes.shape
    height = max(_NODES // columns, 1)
    for top in range(0, rows, height):
        marked = np.flatnonzero(nodes[top : top + height].any(axis=0))
        if marked.size:
            write = slice(top, min(top + height, rows)), slice(int(marked[0]), int(marked[-1]) + 1)
            read = _wider(write[0], rows), _wider(write[1], columns)
            inner = tuple(slice(w.start - r.start, w.stop - r.start) for w, r in zip(write, read, strict=True))
            yield Patch(write, read, (inner[0], inner[1]))


def _wider(nodes: slice, count: int) -> slice:
    return slice(max(nodes.start - 1, 0), min(nodes.stop + 1, count))


def _shorter(nodes: slice) -> slice:
    return slice(nodes.start, nodes.stop - 1)
