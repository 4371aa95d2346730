"""Corners of a fine grid that no free node of it has a part in, as a coarser grid sees them.

Between a body and a held outline node, or between two bodies, poses alone decide whether a corner folds. Behind the
coarse grid's barrier as well, they make sure that what is found there fits on the fine grid.
"""

from dataclasses import dataclass

import numpy as np

from core.arrays import Ints
from core.mapping.injective.levels import GridLevel
from core.mapping.jacobians import Complexes


@dataclass(frozen=True)
class BoundaryContacts:
    """Corners (k, 3): the tip, the end of the edge ahead and that of the edge behind, of nodes (m,)."""

    corners: Ints
    shape: Complexes
    rest: Complexes
    """Nodes in the map that corners are measured against, and in the picture."""
    index: Ints
    """Body of each node, -1 for one that stays on the outline."""

    @classmethod
    def of(cls, fine: GridLevel, coarse: GridLevel, *, held_outline: bool) -> "BoundaryContacts":
        """Find those of the fine grid that bodies of the coarse one and, if it is held, the outline decide."""
        quads, index = fine.grid.quads, fine.index
        moves = fine.inner | fine.constraints.glide.ravel()
        mixed = quads[(moves[quads].sum(axis=1) <= 1) & ~(index[quads] == index[quads[:, :1]]).all(axis=1)]
        corners = np.concatenate([mixed[:, [k, (k + 1) % 4, k - 1]] for k in range(4)])
        bodies = index[corners]
        known = np.append(coarse.counts() > 0, True)
        chosen = ~moves[corners].any(axis=1) & (bodies != bodies[:, :1]).any(axis=1) & known[bodies].all(axis=1)
        if not held_outline:
            chosen &= (bodies >= 0).all(axis=1)
        nodes, corners = np.unique(corners[chosen], return_inverse=True)
        return cls(corners.reshape(-1, 3), fine.shape.ravel()[nodes], fine.rest[nodes], index[nodes])


_NO_NODES = np.empty(0, np.complex128)
NO_CONTACTS = BoundaryContacts(np.empty((0, 3), np.int64), _NO_NODES, _NO_NODES, np.empty(0, np.int64))
