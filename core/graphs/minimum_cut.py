"""The cheapest cut of a graph of pixels between source and sink, for whole costs.

PyMaxflow (Boykov and Kolmogorov, 2004) where it is installed: it has no wheel for Python 3.14. SciPy's maximum flow
(Dinic) elsewhere, which takes 4 to 19 times as long and gives the same cut: docs/python.md has the figures.
"""

import numpy as np

from core.arrays import Bools, Floats, Ints

try:
    import maxflow
except ImportError:
    maxflow = None

LEAST_COST = 1e-4
"""What fractions of costs are made whole multiples of: the search ends with exact sums only."""
_MOST = 2**30
"""SciPy counts in 32 bits; larger costs stand for what must not be cut."""


def minimum_cut(
    one: Ints, other: Ints, between: Floats, source: Floats, sink: Floats, back: Floats | None = None
) -> Bools:
    """Return which of the n nodes lie on the sink's side of the cheapest cut; those that may lie on either do not.

    `between` (p,) is what it costs to part the nodes `one` and `other` (p,), or only where `other` is the sink's if the
    way `back` (p,) has costs of its own; `source` and `sink` (n,) are what it costs to part a node from either: whole
    numbers, not negative.
    """
    back = between if back is None else back
    if maxflow is None:
        return by_scipy(one, other, between, source, sink, back)
    graph = maxflow.GraphFloat(len(source), len(one))
    nodes = graph.add_nodes(len(source))
    graph.add_edges(one, other, between, back)
    graph.add_grid_tedges(nodes, source, sink)
    graph.maxflow()
    return np.asarray(graph.get_grid_segments(nodes), np.bool_)


def by_scipy(one: Ints, other: Ints, between: Floats, source: Floats, sink: Floats, back: Floats) -> Bools:
    """Return the same by SciPy's maximum flow: the nodes from which the sink can be reached in what is left."""
    from scipy.sparse import csr_array  # loads slowly, and is needed without PyMaxflow only
    from scipy.sparse.csgraph import breadth_first_order, maximum_flow

    n = len(source)
    every, start, end = np.arange(n), n, n + 1
    common = np.minimum(source, sink)
    rows = np.concatenate([one, other, np.full(n, start), every])
    columns = np.concatenate([other, one, every, np.full(n, end)])
    costs = np.minimum(np.concatenate([between, back, source - common, sink - common]), _MOST)
    capacity = csr_array((costs.astype(np.int32), (rows, columns)), shape=(n + 2, n + 2))
    capacity.eliminate_zeros()
    left = capacity - maximum_flow(capacity, start, end).flow
    left.data = np.maximum(left.data, 0)
    left.eliminate_zeros()
    reaching = breadth_first_order(csr_array(left.T), end, return_predecessors=False)
    found = np.zeros(n + 2, np.bool_)
    found[reaching] = True
    return found[:n]
