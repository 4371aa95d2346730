import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from threadpoolctl import threadpool_info

from core.arrays import Bytes, Floats, Points
from core.grid import Grid, find_features
from core.linalg.blas import one_thread
from core.mapping.features.feature_mapping import FeatureMapping, Keep, Method
from core.mapping.features.similarity import Bodies, Body, fit_residual
from core.mapping.jacobians import Complexes, as_complex, linear_parts

WIDTH, HEIGHT = 300, 200


def discs(*circles: tuple[int, int, int]) -> Bytes:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    for x, y, radius in circles:
        cv2.circle(mask, (x, y), radius, 255, -1)
    return mask


def stretch(points: Points) -> Points:
    return np.asarray(points * np.array([1.6, 1.0]))


def swirl(points: Points, strength: float = 1.0) -> Points:
    centre = np.array([(WIDTH - 1) / 2, (HEIGHT - 1) / 2])
    z = as_complex((points - centre) / WIDTH * 2)
    turned = z * np.exp(1j * strength * np.exp(-2 * np.abs(z) ** 2))
    return np.asarray(np.stack([turned.real, turned.imag], -1) * WIDTH / 2 + centre)


GRID = Grid(WIDTH, HEIGHT, cell_px=4)
MASK = discs((70, 60, 30), (210, 120, 45), (298, 20, 15))
FEATURES = find_features(GRID, MASK)
KEEPS: list[Keep] = ["similarity", "rigid"]


def residuals(z: Points, *, rigid: bool) -> Floats:
    rest = as_complex(GRID.nodes)
    inside = [FEATURES.labels == number for number in FEATURES.ids]
    return np.array([fit_residual(rest[i], as_complex(z)[i], rigid=rigid) for i in inside])


@pytest.mark.parametrize("keep", ["similarity", "rigid"])
def test_every_feature_moves_as_one(keep: Keep) -> None:
    mapped = FeatureMapping(GRID, FEATURES, keep=keep).solve(swirl(GRID.nodes))
    assert residuals(swirl(GRID.nodes), rigid=False).min() > 0.01
    assert residuals(mapped, rigid=keep == "rigid").max() < 1e-12


def test_outline_nodes_outside_features_stay_where_w_takes_them() -> None:
    w = swirl(GRID.nodes)
    outside = GRID.outline & (FEATURES.labels == 0)
    assert np.array_equal(FeatureMapping(GRID, FEATURES).solve(w)[outside], w[outside])


def test_features_that_w_leaves_no_size_have_that_of_the_closest_similarity() -> None:
    mapping = FeatureMapping(GRID, FEATURES)
    left, chosen = as_complex(GRID.nodes).copy(), np.arange(len(mapping.bodies))
    left.imag[:, GRID.columns // 2 :] = 0  # W lays the right half of the picture on a line
    sizes, fitted = mapping.sizes_under(left, chosen), [abs(body.fit(left.ravel())[0]) for body in mapping.bodies]
    are_flat = [GRID.nodes.reshape(-1, 2)[body.nodes, 0].min() > WIDTH / 2 for body in mapping.bodies]
    assert sorted(are_flat) == [False, True, True]
    assert sizes == pytest.approx(np.where(are_flat, fitted, 1.0))
    assert min(fitted) > 0.1


@pytest.mark.parametrize("method", ["exact", "per-quad"])
def test_a_similar_w_is_reproduced(method: Method) -> None:
    w = as_complex(GRID.nodes) * (1.2 + 0.5j) + (10 - 3j)
    mapping = FeatureMapping(GRID, FEATURES, method=method)
    assert np.abs(mapping.place(w).z - w).max() < 1e-9


MAPPINGS = {keep: FeatureMapping(GRID, FEATURES, keep=keep) for keep in KEEPS}


@settings(max_examples=20)
@given(st.floats(0.2, 5), st.floats(-3, 3), st.floats(-500, 500))
def test_what_moves_turns_or_scales_w_does_so_to_the_result(scale: float, angle: float, shift: float) -> None:
    w = as_complex(swirl(GRID.nodes))
    for keep, mapping in MAPPINGS.items():
        alpha, t = (1.0 if keep == "rigid" else scale) * np.exp(1j * angle), shift * (1 - 0.4j)
        wanted = alpha * mapping.place(w).z + t
        assert np.abs(mapping.place(alpha * w + t).z - wanted).max() < 1e-7


def test_without_features_w_is_returned() -> None:
    empty = find_features(GRID, None)
    w = swirl(GRID.nodes)
    assert np.array_equal(FeatureMapping(GRID, empty).solve(w), w)


def test_a_mask_that_covers_everything_gives_the_best_fit_similarity() -> None:
    everything = find_features(GRID, np.full((HEIGHT, WIDTH), 255, np.uint8))
    rest, w = as_complex(GRID.nodes), as_complex(stretch(GRID.nodes))
    alpha = np.vdot(rest - rest.mean(), w) / np.vdot(rest - rest.mean(), rest - rest.mean())
    mapped = FeatureMapping(GRID, everything).place(w).z
    assert np.abs(mapped - (alpha * (rest - rest.mean()) + w.mean())).max() < 1e-6


def test_the_reduced_system_minimises_the_energy() -> None:
    mapping = FeatureMapping(GRID, FEATURES, keep="rigid")
    w = as_complex(swirl(GRID.nodes))
    solution = mapping.place(w)

    def energy(z: Complexes, alpha: Complexes) -> float:
        follow = np.where(mapping.owner >= 0, alpha[mapping.owner], 0)
        corners = [np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, 1:], np.s_[1:, :-1]]
        total = 0.0
        for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
            edge, wanted, rest = (a[end] - a[start] for a in (z, w, as_complex(GRID.nodes)))
            total += float((mapping.follow_w * np.abs(edge - wanted) ** 2).sum())
            total += float((mapping.follow_feature * np.abs(edge - follow * rest) ** 2).sum())
        return total

    least = energy(solution.z, solution.alpha)
    rng = np.random.default_rng(0)
    for _ in range(10):
        alpha = solution.alpha * np.exp(1j * rng.normal(0, 1e-3, len(solution.alpha)))
        t = solution.t + rng.normal(0, 0.05, len(solution.t))
        z = solution.z + np.where(mapping.free, rng.normal(0, 0.01, GRID.shape), 0)
        for body, a, b in zip(mapping.bodies, alpha, t, strict=True):
            z.ravel()[body.nodes] = body.place(a, b)
        assert energy(z, alpha) > least


def test_per_quad_frames_agree_with_the_singular_value_decomposition() -> None:
    rng = np.random.default_rng(3)
    grid = Grid(12, 9, cell_px=1.5)
    z = as_complex(grid.nodes) + rng.normal(0, 1.5, (*grid.shape, 2)).view(np.complex128)[..., 0]
    frames = linear_parts(grid, z)
    for row, column in np.ndindex(frames.similar.shape):
        corners = [(row, column), (row, column + 1), (row + 1, column + 1), (row + 1, column)]
        rest, there = (np.array([a[c] for c in corners]) for a in (as_complex(grid.nodes), z))
        u, u2 = (np.stack([a.real - a.real.mean(), a.imag - a.imag.mean()]) for a in (rest, there))
        U, sigma, Vt = np.linalg.svd(u2 @ np.linalg.pinv(u))
        R = U @ np.diag([1, np.sign(np.linalg.det(U @ Vt))]) @ Vt
        rotation = frames.rotations[row, column]
        assert np.allclose(R, [[rotation.real, -rotation.imag], [rotation.imag, rotation.real]])
        assert np.isclose(frames.smaller_singular_values[row, column], sigma[1])


@pytest.mark.parametrize("method", ["exact", "per-quad"])
def test_a_mapping_that_another_is_updated_to_is_the_one_made_afresh(method: Method) -> None:
    w = swirl(GRID.nodes)
    before = FeatureMapping(GRID, FEATURES, method=method)
    before.solve(w)
    more = find_features(GRID, np.maximum(MASK, discs((90, 150, 20), (70, 95, 12))))
    after = before.update(more, method=method)
    assert np.array_equal(after.solve(w), FeatureMapping(GRID, more, method=method).solve(w))
    assert after.factor is before.factor
    if before._placement is not None and after._placement is not None:
        kept = [field for field in after._placement.fields if field in before._placement.fields]
        assert len(kept) == 2
    with pytest.raises(RuntimeError, match="updated"):
        before.solve(w)


def test_solving_leaves_blas_as_many_threads_as_it_had() -> None:
    def threads() -> list[int]:
        return [library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"]

    had = threads()
    with one_thread():
        within = threads()
    FeatureMapping(GRID, FEATURES).solve(GRID.nodes)
    assert set(within) == {1}
    assert threads() == had


def test_many_bodies_are_placed_and_fitted_as_each_alone() -> None:
    rng = np.random.default_rng(4)
    rest = as_complex(Grid(300, 200, cell_px=10).nodes)
    chosen = rng.permutation(rest.size)
    bodies = []
    for number, nodes in enumerate(np.split(chosen[:60], [2, 9, 30])):
        p = rest.ravel()[nodes]
        bodies.append(Body(number, nodes, p - p.mean()))
    stack, z = Bodies(bodies), as_complex(rng.normal(size=(rest.size, 2)))
    alpha, t = stack.fit(z)
    assert alpha == pytest.approx([body.fit(z)[0] for body in bodies])
    assert t == pytest.approx([body.fit(z)[1] for body in bodies])
    there = np.concatenate([body.place(a, b) for body, a, b in zip(bodies, alpha, t, strict=True)])
    assert np.array_equal(stack.place(alpha, t), there)
    assert np.array_equal(stack.nodes, np.concatenate([body.nodes for body in bodies]))
    none = Bodies([])
    assert none.nodes.size == none.place(*none.fit(z)).size == 0


def test_the_load_of_many_features_is_the_gradient_at_rest() -> None:
    """K W - dᵀ w_own d W of the picture as it is vanishes but where features turn against their surroundings."""
    grid = Grid(400, 300, cell_px=10)
    mask = np.zeros((300, 400), np.uint8)
    for y, x in np.ndindex(5, 7):
        mask[20 + 55 * y : 45 + 55 * y, 20 + 52 * x : 45 + 52 * x] = 255
    mapping = FeatureMapping(grid, find_features(grid, mask))
    assert len(mapping.bodies) == 35 > mapping.joint_count
    assert mapping.solve(grid.nodes) == pytest.approx(grid.nodes, abs=1e-8)
    turned = as_complex(grid.nodes) * (1.2 + 0.4j) + 30
    assert mapping.place(turned).z == pytest.approx(turned, abs=1e-7)
