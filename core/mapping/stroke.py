"""Where features are under a brush: each frame costs the same beside many features as beside few.

When just one feature comes from one frame to the next, changed, joined of several or new, each frame places that one
and those close by; the others stay where they are, but for one of them in turn.
"""

from dataclasses import dataclass

import numpy as np

from core.arrays import Ints, Points
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.features.pose import Pose
from core.mapping.handles.straight_frame import Placed
from core.mapping.jacobians import as_complex

_NEAR = 12
"""Cells from a stroke within which features are placed with the one that it changes."""


class MaskStroke:
    """The poses of the last frame, from which those of the next one are found."""

    def __init__(self) -> None:
        self._last: _Frame | None = None
        self._turn = 0

    def forget(self) -> None:
        """Let the next frame place all features anew."""
        self._last = None

    def pose(self, mapping: FeatureMapping, plain: Points, placed: Placed) -> Pose:
        """Return where features are for W at the nodes (R, C, 2); those that are `placed` are given."""
        found = self._find(mapping, plain, placed)
        self._last = _Frame(mapping, plain, found)
        return found

    def _find(self, mapping: FeatureMapping, plain: Points, placed: Placed) -> Pose:
        last, w, stay = self._last, as_complex(plain), placed.bodies
        if last is None or last.mapping is mapping or last.plain is not plain:
            return mapping.pose(w, placed.alpha, placed.t, moving=~stay, frame=placed.frame)
        before = last.places_in(mapping)
        same = np.flatnonzero(before >= 0)
        if len(before) - same.size != 1:
            return mapping.pose(w, placed.alpha, placed.t, moving=~stay, frame=placed.frame)
        alpha, t = placed.alpha.copy(), placed.t.copy()
        known = same[~stay[same]]
        alpha[known], t[known] = last.pose.alpha[before[known]], last.pose.t[before[known]]
        # One that is placed by itself costs nothing.
        joint = mapping.joint_count
        moves = before < 0
        moves[:joint] |= before[:joint] >= last.mapping.joint_count
        moves[joint:] = True
        moves[last.bodies_near_change(mapping)] = True
        turns = same[same < joint]
        if turns.size:
            moves[turns[self._turn % turns.size]] = True
            self._turn += 1
        return mapping.pose(w, alpha, t, moving=moves & ~stay, frame=placed.frame)


@dataclass(frozen=True, eq=False)
class _Frame:
    """The last frame: what it was solved with, for and to, before features were fitted to the outline."""

    mapping: FeatureMapping
    plain: Points
    pose: Pose

    def places_in(self, mapping: FeatureMapping) -> Ints:
        """Return for each body of `mapping` that with its nodes and limits in this frame's mapping, -1 for none."""
        known = {(body.nodes.tobytes(), body.limits): i for i, body in enumerate(self.mapping.bodies)}
        return np.array([known.get((body.nodes.tobytes(), body.limits), -1) for body in mapping.bodies], np.int64)

    def bodies_near_change(self, mapping: FeatureMapping) -> Ints:
        """Return the bodies of `mapping` around nodes that came into a feature, or out of one, since this frame."""
        row, column = ((mapping.index >= 0) != (self.mapping.index >= 0)).nonzero()
        if not row.size:
            return np.empty(0, np.int64)
        rows = np.s_[max(row.min() - _NEAR, 0) : row.max() + _NEAR + 1]
        columns = np.s_[max(column.min() - _NEAR, 0) : column.max() + _NEAR + 1]
        near = np.unique(mapping.index[rows, columns])
        return near[near >= 0]
