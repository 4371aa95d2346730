"""The cheapest cut, by PyMaxflow and by SciPy: the same nodes, and none is cheaper."""

from itertools import product

import numpy as np
import pytest

from core.arrays import Bools, Floats, Ints
from core.graphs import minimum_cut as module
from core.graphs.minimum_cut import by_scipy, minimum_cut

Graph = tuple[Ints, Ints, Floats, Floats, Floats, Floats]


def grid(height: int, width: int, seed: int, most: int = 40) -> Graph:
    """Return a grid of nodes with random whole costs, of its edges either way."""
    rng = np.random.default_rng(seed)
    nodes = np.arange(height * width).reshape(height, width)
    one = np.concatenate([nodes[:, :-1].ravel(), nodes[:-1].ravel()])
    other = np.concatenate([nodes[:, 1:].ravel(), nodes[1:].ravel()])
    sizes = (len(one), nodes.size, nodes.size, len(one))
    between, source, sink, back = (rng.integers(0, most, n).astype(float) for n in sizes)
    return one, other, between, source, sink, back


def cost(graph: Graph, sunk: Bools) -> float:
    one, other, between, source, sink, back = graph
    edges = between[~sunk[one] & sunk[other]].sum() + back[sunk[one] & ~sunk[other]].sum()
    return float(edges + source[sunk].sum() + sink[~sunk].sum())


@pytest.mark.parametrize("seed", range(5))
def test_no_cut_is_cheaper(seed: int) -> None:
    graph = grid(3, 3, seed, most=6)
    least = min(cost(graph, np.array(sides)) for sides in product([False, True], repeat=9))
    assert cost(graph, minimum_cut(*graph)) == least
    assert cost(graph, by_scipy(*graph)) == least


@pytest.mark.parametrize("most", [3, 1000])
@pytest.mark.parametrize("seed", range(4))
def test_both_give_the_same_nodes_of_many_equal_cuts(seed: int, most: int) -> None:
    graph = grid(40, 30, seed, most)
    np.testing.assert_array_equal(minimum_cut(*graph), by_scipy(*graph))


def test_without_costs_of_its_own_an_edge_costs_as_much_either_way() -> None:
    one, other, between, source, sink, _ = grid(20, 15, 2)
    np.testing.assert_array_equal(
        minimum_cut(one, other, between, source, sink), minimum_cut(one, other, between, source, sink, between)
    )


def test_costs_beyond_32_bits_are_not_cut() -> None:
    one, other, between, source, sink, _ = grid(1, 4, 0)
    between[:] = [1e12, 5, 1e12]
    source[:], sink[:] = [9, 0, 0, 0], [0, 0, 0, 9]
    assert minimum_cut(one, other, between, source, sink).tolist() == [False, False, True, True]
    assert by_scipy(one, other, between, source, sink, between).tolist() == [False, False, True, True]


def test_without_pymaxflow_scipy_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = grid(6, 5, 1)
    expected = minimum_cut(*graph)
    monkeypatch.setattr(module, "maxflow", None)
    np.testing.assert_array_equal(minimum_cut(*graph), expected)
