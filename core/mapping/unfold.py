"""Remove fold-overs from a mapping, which FAT sec. 5 leaves as future work."""

import cv2
import numpy as np

from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.folds import corner_areas, folded_quads
from core.mapping.frames import Complexes
from core.progress import Job, Progress

_ROUNDS = 6
_THIN = 0.15
"""A corner with less than this share of its area under W is about to fold."""
_GAIN = 8.0


def reweight(mapping: FeatureMapping, w: Complexes) -> Job[Solution]:
    """Draw quads that fold closer to W by raising the weight of their equations of FAT eq. 4, a few times over.

    The mapping is left factorised for the weights that were reached.
    """
    solution = mapping.place(w)
    areas = corner_areas(w)
    for step in range(_ROUNDS):
        if not folded_quads(solution.z).any():
            break
        yield Progress(step / _ROUNDS, "unfolding", solution.positions)
        thin = (corner_areas(solution.z) < _THIN * areas).any(axis=0)
        near = cv2.dilate(np.asarray(thin, np.uint8), np.ones((5, 5), np.uint8)) > 0
        mapping.factorise(np.where(near, _GAIN * (1 + mapping.follow_w), mapping.follow_w))
        solution = mapping.place(w)
    return solution


def unfold(mapping: FeatureMapping, w: Complexes) -> Job[Solution]:
    """Solve and remove every folded quad, if W has none; the mapping is left as it was."""
    if folded_quads(w).any():
        return mapping.place(w)
    follow_w = mapping.follow_w
    try:
        solution = yield from reweight(mapping, w)
    finally:
        if mapping.follow_w is not follow_w:
            mapping.factorise(follow_w)
    return solution
