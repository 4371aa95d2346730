"""A grid worked on by bands of whole rows: what is on the way stays near the processor, other rows are left out."""

from collections.abc import Iterator

import numpy as np

from core.arrays import Bools

_NODES = 1 << 15
"""Of a band: half a megabyte of complex numbers."""


def cut_bands(marked: Bools, columns: int) -> Iterator[slice]:
    """Yield bands of rows that cover those `marked` (R,) of a grid with so many columns."""
    height = max(_NODES // columns, 1)
    ends = np.flatnonzero(np.diff(marked, prepend=False, append=False))
    for first, last in ends.reshape(-1, 2).tolist():
        for top in range(first, last, height):
            yield slice(top, min(top + height, last))
