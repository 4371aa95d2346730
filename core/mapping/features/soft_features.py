"""Features that keep their shape by a weight p between 0 and 1, softly: free nodes, whose quads ask for a mean.

With α the similarity closest to W in such a feature, within its limits, its quads ask for

    dz = (1 - p) dW + p α dp,

with a weight between that of what is free and that of features (`quad_weights.weigh_free`). What this adds to the
equations is a load beside that of W, and so a displacement, for features that keep their shape where they are.
"""

import numpy as np

from core.linalg.blas import one_thread
from core.linalg.laplacian import edge_weights, laplacian
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.features.pose import Solution
from core.mapping.features.quad_weights import quads_inside
from core.mapping.features.reduced_system import as_one, as_two
from core.mapping.features.similarity import Bodies
from core.mapping.jacobians import Complexes, as_complex


class SoftFeatures:
    """What the soft features of a mapping add to an answer; prepared once for it, a solve for each answer."""

    def __init__(self, mapping: FeatureMapping) -> None:
        self._mapping, self._rest = mapping, as_complex(mapping.grid.nodes)
        self._bodies = Bodies(mapping.soft)
        self._edges = []
        for body in mapping.soft:
            asks = np.where(quads_inside(mapping.grid, body), mapping.follow_w * body.limits.weight, 0.0)
            self._edges.append(edge_weights(asks))

    def soften(self, found: Solution, w: Complexes) -> Solution:
        """Return the answer for W at the nodes (R, C) with soft features as far from W as they are protected."""
        alpha, _ = self._bodies.fit_within(w.ravel())
        load = np.zeros_like(w)
        for edges, a in zip(self._edges, alpha.tolist(), strict=True):
            load += laplacian(edges, a * self._rest - w)
        load = np.where(self._mapping.free, load, 0)
        with one_thread():
            moved = as_one(self._mapping.factor.solve(as_two(load.ravel())))
        return Solution(found.z + moved.reshape(w.shape), found.alpha, found.t)
