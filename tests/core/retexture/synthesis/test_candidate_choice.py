"""What candidates cost, and which patches are chosen for together."""

import numpy as np

from core.arrays import Singles
from core.retexture.synthesis.candidate_choice import STRETCH, Pool, costs, weigh_drift
from core.retexture.synthesis.candidate_pool import rounds
from core.retexture.synthesis.patches import Covered, PatchShape


def pool(colours: Singles, uses: Singles | None = None, unusable: Singles | None = None) -> Pool:
    """Return what is known of candidates with `colours` (n, K', J', c)."""
    flat = np.zeros(colours.shape[:3], np.float32)
    return Pool(
        np.concatenate([colours, (colours**2).sum(axis=-1, keepdims=True)], axis=-1),
        flat if uses is None else uses,
        flat if unusable is None else unusable,
        np.full(len(colours), colours.var() + 1e-4),
    )


def test_the_candidate_that_continues_what_is_shown_costs_nothing() -> None:
    colours = np.random.default_rng(0).random((2, 15, 31, 3)).astype(np.float32)
    shown = np.stack([colours[0, 3:10, 8:29], colours[1, 2:9, 4:25]])
    whole = np.ones((2, 7, 21), np.float32)
    cost = costs(pool(colours), shown, whole, whole, 0.3)
    assert cost.shape == (2, 9, 11)
    assert divmod(int(cost[0].argmin()), 11) == (3, 8)
    assert divmod(int(cost[1].argmin()), 11) == (2, 4)
    np.testing.assert_allclose(cost.min(axis=(1, 2)), 0, atol=1e-4)


def test_candidates_cost_what_their_colours_differ() -> None:
    rng = np.random.default_rng(1)
    colours, shown = (rng.random((1, *size, 3)).astype(np.float32) for size in ((15, 31), (7, 21)))
    weight = rng.random((1, 7, 21)).astype(np.float32)
    known = pool(colours)
    cost = costs(known, shown, weight, np.ones_like(weight), 0.0)[0]
    for k, j in ((0, 0), (8, 10), (3, 7)):
        gap = ((shown[0] - colours[0, k : k + 7, j : j + 21]) ** 2).sum(axis=-1)
        expected = (weight[0] ** 2 * gap).sum() / ((weight[0] ** 2).sum() * known.variance[0])
        np.testing.assert_allclose(cost[k, j], expected, rtol=1e-4)


def test_used_and_forbidden_places_cost_more() -> None:
    even = np.zeros((1, 15, 31, 3), np.float32)
    whole = np.ones((1, 7, 21), np.float32)
    left = np.zeros((1, 15, 31), np.float32)
    left[..., :12] = 1
    for which in ({"uses": left}, {"unusable": left}):
        cost = costs(pool(even + np.float32(0.5), **which), even[:, :7, :21], whole, whole, 0.5)[0]
        assert (np.diff(cost[4]) < 1e-6).all()
        assert cost[4, 0] > cost[4, -1] + 0.1


def test_a_patch_on_the_curve_keeps_its_distance() -> None:
    shape = PatchShape()
    offset = np.array([0.0, shape.rib + 2.0, -shape.rib - 2.0, 40.0])
    on, inside, outside, far = weigh_drift(shape, offset, np.ones(4), np.zeros(4))[:, :, shape.search_along]
    assert (on < 100).sum() == 1
    assert (np.flatnonzero(inside < 100) >= shape.search_across - 1).all()
    np.testing.assert_array_equal(outside, inside[::-1])
    assert (far < 100).all()


def test_candidates_cost_what_they_are_stretched_on_their_way_back() -> None:
    shape = PatchShape()
    flat, steep = weigh_drift(shape, np.full(2, 40.0), np.ones(2), np.array([0.0, 0.05]))
    across, along = np.indices(flat.shape) - np.array([[[shape.search_across]], [[shape.search_along]]])
    np.testing.assert_allclose(steep - flat, STRETCH * 0.05**2 * (along**2 + across**2))


def test_patches_of_a_round_do_not_touch_and_wait_for_earlier_ones() -> None:
    squares = [(2, 2), (12, 2), (6, 2), (5, 5), (13, 12)]
    pixel = np.concatenate([((np.arange(4) + y)[:, None] * 20 + np.arange(4) + x).ravel() for x, y in squares])
    patch = np.repeat([0, 1, 2, 3, 5], 16)
    found = rounds(Covered(patch, pixel, np.zeros((80, 2), np.float32)), 6, (20, 20))
    # The third lies beside the first, and the fourth over both.
    assert [which.tolist() for which in found] == [[0, 1, 5], [2], [3]]
