import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.arrays import Bytes, Floats, Points
from core.grid import Features, Grid, find_features
from core.mapping import unfold as unfolding
from core.mapping.distortion import Barrier, Corners, Hinge, Penalty
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.folds import corner_areas, folded_quads
from core.mapping.frames import Complexes, as_complex
from core.mapping.junctions import fit_between
from core.mapping.similarity import fit_residual
from core.mapping.stiffen import stiffen
from core.mapping.unfold import unfold
from core.mapping.warping import Keep, MappingOptions, warp_grid
from core.progress import Job, Progress, run
from core.warps.presets import make_warp

WIDTH, HEIGHT = 240, 180
GRID = Grid(WIDTH, HEIGHT, cell_px=3)


def blank() -> Bytes:
    return np.zeros((HEIGHT, WIDTH), np.uint8)


def standing_on_the_edge() -> Bytes:
    mask = blank()
    mask[60:150, 70:150] = 255
    for left in (70, 100, 135):
        mask[150:, left : left + 15] = 255
    return mask


def close_neighbours() -> Bytes:
    mask = blank()
    cv2.circle(mask, (80, 90), 36, 255, -1)
    mask[50:130, 124:170] = 255
    mask[60:120, 176:215] = 255
    return mask


def hooks() -> Bytes:
    mask = blank()
    mask[40:140, 60:75] = mask[125:140, 60:170] = mask[70:140, 155:170] = 255
    mask[30:110, 100:130] = 255
    return mask


def across() -> Bytes:
    mask = blank()
    mask[70:110] = 255
    return mask


MASKS = {mask.__name__: mask() for mask in (standing_on_the_edge, close_neighbours, hooks, across)}


def mapped(mask: Bytes, preset: str, bend: float, keep: Keep) -> tuple[Features, Points, Points]:
    features = find_features(GRID, mask)
    plain = make_warp(preset, WIDTH, HEIGHT, bend=bend)(GRID.nodes)
    return features, plain, warp_grid(GRID, features, plain, options=MappingOptions(keep=keep)).warped


def residuals(features: Features, z: Points, *, rigid: bool) -> Floats:
    rest, moved = as_complex(GRID.nodes), as_complex(z)
    parts = [features.labels == number for number in features.ids]
    return np.array([fit_residual(rest[part], moved[part], rigid=rigid) for part in parts])


@pytest.mark.parametrize("keep", ["similarity", "rigid"])
@pytest.mark.parametrize("preset", ["arc", "flag", "rise", "squeeze", "swirl"])
@pytest.mark.parametrize("name", MASKS)
def test_nothing_folds_and_every_feature_keeps_its_shape(name: str, preset: str, keep: Keep) -> None:
    features, plain, z = mapped(MASKS[name], preset, 45, keep)
    assert not folded_quads(as_complex(plain)).any()
    assert not folded_quads(as_complex(z)).any()
    assert residuals(features, z, rigid=False).max() < 1e-9
    outside = GRID.outline & (features.labels == 0)
    assert np.array_equal(z[outside], plain[outside])


@pytest.mark.parametrize("name", MASKS)
def test_every_scene_folds_without_unfolding(name: str) -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, MASKS[name]), keep="rigid")
    warps = [make_warp(preset, WIDTH, HEIGHT, bend=45)(GRID.nodes) for preset in ("arc", "squeeze", "swirl")]
    assert any(folded_quads(as_complex(mapping.solve(plain))).any() for plain in warps)


def specks() -> Bytes:
    mask, rng = blank(), np.random.default_rng(0)
    for _ in range(260):
        cv2.circle(mask, (int(rng.integers(WIDTH)), int(rng.integers(HEIGHT))), 3, 255, -1)
    return mask


@pytest.mark.parametrize(("preset", "bend"), [("arc", 90), ("flag", 70)])
def test_many_rigid_specks_are_unfolded(preset: str, bend: float) -> None:
    features, plain, z = mapped(specks(), preset, bend, "rigid")
    assert len(features) > 100
    assert not folded_quads(as_complex(plain)).any()
    assert not folded_quads(as_complex(z)).any()


@pytest.mark.parametrize("name", ["close_neighbours", "hooks"])
def test_features_stiffen_from_w_without_folding(name: str) -> None:
    features = find_features(GRID, MASKS[name])
    mapping = FeatureMapping(GRID, features)
    w = as_complex(make_warp("arc", WIDTH, HEIGHT, bend=60)(GRID.nodes))
    found = run(stiffen(mapping, w, np.abs(mapping.place(w).alpha)))
    assert found is not None
    assert not folded_quads(found.z).any()
    assert residuals(features, found.positions, rigid=False).max() < 1e-9
    outside = GRID.outline & (features.labels == 0)
    assert np.array_equal(found.z[outside], w[outside])


def test_rigid_features_that_fit_keep_their_size() -> None:
    features, _, z = mapped(MASKS["close_neighbours"], "arc", 25, "rigid")
    assert residuals(features, z, rigid=True).max() < 1e-9


def test_rigid_features_take_their_size_under_w_where_the_search_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    search = unfolding._untangled

    def fails_when_rigid(mapping: FeatureMapping, w: Complexes, start: Solution, *, fitted: bool) -> Job[Solution]:
        return start if mapping.keep == "rigid" else (yield from search(mapping, w, start, fitted=fitted))

    monkeypatch.setattr(unfolding, "_untangled", fails_when_rigid)
    _, _, z = mapped(MASKS["close_neighbours"], "squeeze", 45, "rigid")
    assert not folded_quads(as_complex(z)).any()


def test_what_does_not_fold_is_left_as_it_is() -> None:
    features = find_features(GRID, MASKS["close_neighbours"])
    mapping = FeatureMapping(GRID, features)
    w = as_complex(make_warp("arc", WIDTH, HEIGHT, bend=5)(GRID.nodes))
    assert np.array_equal(run(unfold(mapping, w)).z, mapping.place(w).z)


def test_a_warp_that_folds_itself_is_not_unfolded() -> None:
    features = find_features(GRID, MASKS["hooks"])
    mapping = FeatureMapping(GRID, features)
    w = as_complex(GRID.nodes * np.array([-1.0, 1.0]))
    assert folded_quads(w).all()
    assert np.array_equal(run(unfold(mapping, w)).z, mapping.place(w).z)


def test_unfolding_leaves_the_mapping_as_it_was_even_when_stopped() -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, MASKS["close_neighbours"]), keep="rigid")
    w = as_complex(make_warp("squeeze", WIDTH, HEIGHT, bend=45)(GRID.nodes))
    before = mapping.place(w).z
    job = unfold(mapping, w)
    for _ in range(2):
        assert isinstance(next(job), Progress)
    job.close()
    assert np.abs(mapping.place(w).z - before).max() < 1e-9


def test_progress_never_runs_backwards() -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, MASKS["standing_on_the_edge"]), keep="rigid")
    w = as_complex(make_warp("arc", WIDTH, HEIGHT, bend=45)(GRID.nodes))
    seen: list[float] = []
    run(unfold(mapping, w), lambda step: seen.append(step.fraction))
    assert seen == sorted(seen)
    assert 0 <= seen[0] <= seen[-1] <= 1


def test_per_quad_mappings_are_unfolded_too() -> None:
    features = find_features(GRID, MASKS["close_neighbours"])
    plain = make_warp("arc", WIDTH, HEIGHT, bend=45)(GRID.nodes)
    options = MappingOptions(keep="rigid", method="per-quad")
    assert folded_quads(as_complex(warp_grid(GRID, features, plain, options=options, allow_folds=True).warped)).any()
    assert not warp_grid(GRID, features, plain, options=options).folded.any()


def test_a_feature_that_stands_on_the_edge_is_put_between_the_outline_nodes() -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, MASKS["standing_on_the_edge"]), keep="rigid")
    w = as_complex(make_warp("arc", WIDTH, HEIGHT, bend=45)(GRID.nodes))
    linear = mapping.place(w)
    fitted = fit_between(mapping, w, linear)
    assert fitted is not None
    decided = np.zeros(folded_quads(w).shape, bool)
    decided[-1] = True
    inside = mapping.index[:-1, :-1] >= 0
    assert (folded_quads(linear.z) & decided).sum() > (folded_quads(fitted.z) & decided & inside).sum()


def squares(seed: int, wobble: float) -> Complexes:
    noise = np.random.default_rng(seed).normal(0, wobble, (12, 4, 2)).view(np.complex128)[..., 0]
    return np.array([0, 1, 1 + 1j, 1j]) + noise


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([Hinge(0.3), Barrier(0.2), Barrier(1.0)]))
def test_slopes_are_those_of_the_energy_and_curvature_is_never_negative(seed: int, penalty: Penalty) -> None:
    corners, z = Corners.of(squares(seed, 0.05)), squares(seed + 1, 0.4)
    gradient, curvature = penalty.model(corners, z)
    assert np.linalg.eigvalsh(curvature).min() > -1e-7 * np.abs(curvature).max()
    step = 1e-6
    for i in range(8):
        move = np.zeros((12, 4), np.complex128)
        move[:, i // 2] = step * (1j if i % 2 else 1)
        slope = (penalty.energy(corners, z + move) - penalty.energy(corners, z - move)) / (2 * step)
        assert np.allclose(slope, gradient[:, i], rtol=1e-4, atol=1e-4 * np.abs(gradient).max())


def test_a_quad_is_folded_when_one_corner_is() -> None:
    z = as_complex(Grid(3, 3, cell_px=1).nodes).copy()
    assert not folded_quads(z).any()
    assert np.allclose(corner_areas(z), 1)
    z[1, 1] += 1.2 + 1.2j
    assert folded_quads(z).sum() == 3
