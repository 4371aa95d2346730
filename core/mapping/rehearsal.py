"""Clear folds on a coarser grid beforehand, where it takes little time, so that on the fine one few are left."""

from core.mapping.approach import count_folds, relaxed, steps_to_clear, window_around
from core.mapping.coarser import Coarser, is_large, unseen
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.folds import folded_quads
from core.mapping.frames import Complexes
from core.mapping.untangle import Untangler
from core.progress import Job

_REACH = 6
"""Coarse cells around what folds, and around features there, that may move."""
_STEPS = 24
"""Newton steps at most."""


class Rehearsal:
    """The same mapping and W on a coarser grid, where features cover all nodes that they have on the fine one."""

    def __init__(self, mapping: FeatureMapping, w: Complexes) -> None:
        self._w = w
        self.left = 0
        """Folds that were left the last time."""
        self._coarser = Coarser(mapping, covered=True) if is_large(mapping) and mapping.has_poses else None
        if self._coarser is not None:
            self._coarse_w = self._coarser.at_nodes(w)
            if folded_quads(self._coarse_w).any() or not self._coarser.mapping.has_poses:
                self._coarser = None

    def cleared(self, solution: Solution) -> Job[Solution]:
        """Return the solution with fewer folds, features where they are, if the coarser grid shows how."""
        if self._coarser is None:
            return solution
        coarse = self._coarser.placed(self._coarse_w, solution)
        if count_folds(coarse):
            window = window_around(self._coarser.mapping, coarse, _REACH)
            here = Untangler(self._coarser.mapping, self._coarse_w, coarse, window=window, stiffness=None)
            if (yield from unseen(steps_to_clear(here, "barrier", _STEPS))):
                yield from unseen(relaxed(here))
            coarse = here.solution
        found = self._coarser.lifted(self._w, coarse, solution, released=False)
        if count_folds(found) >= count_folds(solution):
            found = solution
        self.left = count_folds(found)
        return found
