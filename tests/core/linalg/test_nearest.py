import numpy as np

from core.linalg.nearest import Nearest, close_pairs


def test_the_nearest_of_points_and_how_far_it_is() -> None:
    points, places = (np.random.default_rng(seed).random((count, 2)) * 900 for seed, count in ((0, 700), (1, 3000)))
    apart = np.linalg.norm(places[:, None] - points, axis=-1)
    distance, number = Nearest(points).to(places)
    np.testing.assert_allclose(distance, apart[np.arange(3000), number])
    np.testing.assert_allclose(distance, apart.min(axis=1), atol=1e-3)


def test_one_point_is_the_nearest_to_all_and_nothing_is_near_to_nothing() -> None:
    only = Nearest(np.array([[3.0, 4.0]]))
    distance, number = only.to(np.array([[0.0, 0.0], [3.0, 4.0]]))
    assert distance.tolist() == [5, 0]
    assert number.tolist() == [0, 0]
    assert [part.tolist() for part in only.to(np.empty((0, 2)))] == [[], []]


def test_close_pairs_are_all_found() -> None:
    a, b = (np.random.default_rng(seed).random((400, 2)) * 30 - 10 for seed in (2, 3))
    apart = np.linalg.norm(a[:, None] - b, axis=-1)
    one, other = close_pairs(a, b, 1.0)
    found = list(zip(one.tolist(), other.tolist(), strict=True))
    assert len(set(found)) == len(found)
    assert set(map(tuple, np.argwhere(apart <= 1.0).tolist())) <= set(found)
    assert apart[one, other].max() < 3
    assert (np.diff(one) >= 0).all()
