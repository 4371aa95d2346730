"""What a frame of the canvas may take, and what is drawn for it."""

from app.render.gpu import around
from app.render.layers import LEAST_SHRINK, MOST_SHRINK, Costs


def settled(costs: Costs, seconds: float) -> int:
    """Return by how much drafts are drawn smaller once each pixel of the canvas takes so long."""
    for _ in range(30):
        costs.learn_draft(seconds / costs.shrink**2, costs.shrink)
    return costs.shrink


def test_a_draft_gets_coarser_the_longer_it_takes() -> None:
    costs = Costs(0.010)
    assert settled(costs, 0.039) == LEAST_SHRINK == 2
    assert settled(costs, 0.041) == 3
    assert settled(costs, 9.0) == MOST_SHRINK == 3


def test_a_draft_gets_finer_only_where_there_is_time_to_spare() -> None:
    costs = Costs(0.010)
    assert settled(costs, 0.041) == 3
    assert settled(costs, 0.039) == 3
    assert settled(costs, 0.029) == 3
    assert settled(costs, 0.027) == 2


def test_what_is_around_a_rectangle_covers_the_rest_once() -> None:
    outer = (2, 3, 6, 5)
    for inner in ((4, 4, 2, 2), (0, 0, 20, 5), (2, 3, 6, 5), (7, 7, 9, 9), (0, 0, 1, 1), (4, 4, 0, 3)):
        painted: dict[tuple[int, int], int] = {}
        for left, low, width, height in around(inner, outer):
            for x in range(left, left + width):
                for y in range(low, low + height):
                    painted[x, y] = painted.get((x, y), 0) + 1
        inside = {(x, y) for x in range(2, 8) for y in range(3, 8)}
        held = {(x, y) for x, y in inside if 0 <= x - inner[0] < inner[2] and 0 <= y - inner[1] < inner[3]}
        assert painted == dict.fromkeys(inside - held, 1)
