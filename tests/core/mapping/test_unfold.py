from typing import Any

import cv2
import numpy as np
import pytest

from core.arrays import Bools, Bytes, Floats, Points
from core.grid import Features, Grid, find_features
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.features.pose import Solution
from core.mapping.features.similarity import fit_residual
from core.mapping.folds import find_folded_quads
from core.mapping.handles.constraints import Constraints
from core.mapping.handles.straight_frame import distance_to_line
from core.mapping.injective.outline import crosses_itself, ring_of
from core.mapping.injective.unfold import unfold
from core.mapping.jacobians import Complexes, as_complex
from core.mapping.options import Keep, MappingOptions
from core.mapping.result import Warped
from core.mapping.warping import warp_grid
from core.progress import Job, Progress, run
from core.warps.presets import make_warp

WIDTH, HEIGHT = 240, 180
GRID = Grid(WIDTH, HEIGHT, cell_px=3)
FINE = Grid(WIDTH, HEIGHT, cell_px=1.5)


def unfolding(mapping: FeatureMapping, w: Complexes) -> Job[Solution]:
    linear = mapping.place(w)
    none = Constraints.none(mapping.bodies, as_complex(mapping.grid.nodes))
    return unfold(mapping, w, linear, shape=w, scales=np.abs(linear.alpha), constraints=none)


def off_its_side(z: Points, plain: Points, outside: Bools) -> Floats:
    """How far the frame nodes outside features are from the side that W draws."""
    sides: list[Any] = [np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]]
    return np.array([distance_to_line(point[None], plain[side]) for side in sides for point in z[side][outside[side]]])


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
    assert not find_folded_quads(as_complex(plain)).any()
    assert not find_folded_quads(as_complex(z)).any()
    assert residuals(features, z, rigid=False).max() < 1e-9
    outside = GRID.outline & (features.labels == 0)
    assert off_its_side(z, plain, outside).max() == 0


@pytest.mark.parametrize("name", MASKS)
def test_every_scene_folds_without_unfolding(name: str) -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, MASKS[name]), keep="rigid")
    warps = [make_warp(preset, WIDTH, HEIGHT, bend=45)(GRID.nodes) for preset in ("arc", "squeeze", "swirl")]
    assert any(find_folded_quads(as_complex(mapping.solve(plain))).any() for plain in warps)


def specks() -> Bytes:
    mask, rng = blank(), np.random.default_rng(0)
    for _ in range(260):
        cv2.circle(mask, (int(rng.integers(WIDTH)), int(rng.integers(HEIGHT))), 3, 255, -1)
    return mask


@pytest.mark.parametrize(("preset", "bend"), [("arc", 90), ("flag", 70)])
def test_many_rigid_specks_are_unfolded(preset: str, bend: float) -> None:
    features, plain, z = mapped(specks(), preset, bend, "rigid")
    assert len(features) > 100
    assert not find_folded_quads(as_complex(plain)).any()
    assert not find_folded_quads(as_complex(z)).any()


def test_rigid_features_that_fit_keep_their_size() -> None:
    features, _, z = mapped(MASKS["close_neighbours"], "arc", 25, "rigid")
    assert residuals(features, z, rigid=True).max() < 1e-9


def test_rigid_features_take_the_sizes_they_have_under_w_where_their_own_do_not_fit() -> None:
    features, _, z = mapped(MASKS["close_neighbours"], "squeeze", 100, "rigid")
    assert not find_folded_quads(as_complex(z)).any()
    assert residuals(features, z, rigid=False).max() < 1e-9
    assert residuals(features, z, rigid=True).max() > 1e-3


def low_band() -> Bytes:
    mask = blank()
    mask[130:150] = 255
    return mask


def cross() -> Bytes:
    mask = blank()
    mask[80:110] = mask[:, 100:130] = 255
    return mask


def stripes() -> Bytes:
    mask = blank()
    for top in (20, 65, 110, 150):
        mask[top : top + 18] = 255
    return mask


CUT = {mask.__name__: mask() for mask in (low_band, cross, stripes)}


Cut = tuple[str, str, float, Keep]
BETWEEN_SIDES: list[Cut] = [
    ("low_band", "arc", 90, "similarity"),
    ("low_band", "arc", 90, "rigid"),
    ("cross", "arc", 90, "rigid"),
    ("stripes", "squeeze", 60, "similarity"),
]


def unfolded_cut(cut: Cut) -> tuple[Features, Points, Warped]:
    name, preset, bend, keep = cut
    features = find_features(GRID, CUT[name])
    plain = make_warp(preset, WIDTH, HEIGHT, bend=bend)(GRID.nodes)
    return features, plain, warp_grid(GRID, features, plain, options=MappingOptions(keep=keep))


@pytest.mark.parametrize("cut", BETWEEN_SIDES, ids=str)
def test_features_that_the_edge_cuts_at_both_ends_are_unfolded(cut: Cut) -> None:
    features, plain, result = unfolded_cut(cut)
    assert not find_folded_quads(as_complex(plain)).any()
    assert not result.folded.any()
    assert residuals(features, result.warped, rigid=False).max() < 1e-6
    assert all(0.4 < feature["scale"] < 1.1 for feature in result.report()["features"])


@pytest.mark.parametrize("cut", BETWEEN_SIDES, ids=str)
def test_only_what_is_beside_the_cuts_leaves_the_outline(cut: Cut) -> None:
    features, plain, result = unfolded_cut(cut)
    assert not crosses_itself(as_complex(result.warped).ravel()[ring_of(GRID)])
    moved = off_its_side(result.warped, plain, GRID.outline & (features.labels == 0))
    assert moved.max() < 0.5 * WIDTH
    assert result.report().get("outline_moved_px", 0.0) == moved.max()
    # Size gives way before more of the outline than what is beside the cuts leaves W.
    assert (moved == 0).mean() > 0.5


@pytest.mark.parametrize("keep", ["similarity", "rigid"])
def test_on_a_large_grid_too_only_what_is_beside_the_cuts_leaves_the_outline(keep: Keep) -> None:
    features = find_features(FINE, CUT["low_band"])
    plain = make_warp("arc", WIDTH, HEIGHT, bend=90)(FINE.nodes)
    result = warp_grid(FINE, features, plain, options=MappingOptions(keep=keep))
    z, inside = as_complex(result.warped), features.labels > 0
    assert not result.folded.any()
    assert fit_residual(as_complex(FINE.nodes)[inside], z[inside], rigid=False) < 1e-9
    assert not crosses_itself(z.ravel()[ring_of(FINE)])
    assert (off_its_side(result.warped, plain, FINE.outline & ~inside) == 0).mean() > 0.8


def test_a_line_that_crosses_itself_is_told_from_one_that_does_not() -> None:
    ring = ring_of(GRID)
    z = as_complex(GRID.nodes).ravel().copy()
    assert len(ring) == GRID.outline.sum()
    assert np.abs(np.diff(z[ring])).max() <= max(GRID.cell) + 1e-9
    for angle in (0.0, 0.3, 1.1):
        assert not crosses_itself(np.exp(1j * angle) * z[ring])
    z[ring[5]] += HEIGHT * 1.5j
    assert crosses_itself(z[ring])


def test_a_line_crosses_itself_where_two_of_its_edges_do() -> None:
    def turns(a: complex, b: complex, c: complex) -> float:
        return float(((b - a).conjugate() * (c - a)).imag)

    rng, told = np.random.default_rng(3), []
    for _ in range(60):
        count = int(rng.integers(4, 30))
        radius = 1 + rng.normal(0, 0.35, count)
        ring = radius * np.exp(1j * np.sort(rng.uniform(0, 2 * np.pi, count)))
        ring[int(rng.integers(count))] *= rng.choice([1, 1j, -0.5])
        edges = [(ring[i], ring[(i + 1) % count]) for i in range(count)]
        crossed = any(
            turns(*one, other[0]) * turns(*one, other[1]) < 0 and turns(*other, one[0]) * turns(*other, one[1]) < 0
            for i, one in enumerate(edges)
            for other in edges[i + 2 : count - (i == 0)]
        )
        assert crosses_itself(ring) == crossed
        told.append(crossed)
    assert 10 < sum(told) < 50


def test_an_outline_that_stays_is_not_reported() -> None:
    features = find_features(GRID, MASKS["hooks"])
    plain = make_warp("arc", WIDTH, HEIGHT, bend=45)(GRID.nodes)
    assert "outline_moved_px" not in warp_grid(GRID, features, plain).report()


def test_what_does_not_fold_is_left_as_it_is() -> None:
    features = find_features(GRID, MASKS["close_neighbours"])
    mapping = FeatureMapping(GRID, features)
    w = as_complex(make_warp("arc", WIDTH, HEIGHT, bend=5)(GRID.nodes))
    assert np.array_equal(run(unfolding(mapping, w)).z, mapping.place(w).z)


def test_a_warp_that_folds_itself_is_not_unfolded() -> None:
    features = find_features(GRID, MASKS["hooks"])
    mapping = FeatureMapping(GRID, features)
    w = as_complex(GRID.nodes * np.array([-1.0, 1.0]))
    assert find_folded_quads(w).all()
    assert np.array_equal(run(unfolding(mapping, w)).z, mapping.place(w).z)


def test_unfolding_leaves_the_mapping_as_it_was_even_when_stopped() -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, MASKS["close_neighbours"]), keep="rigid")
    w = as_complex(make_warp("squeeze", WIDTH, HEIGHT, bend=45)(GRID.nodes))
    before = mapping.place(w).z
    job = unfolding(mapping, w)
    for _ in range(2):
        assert isinstance(next(job), Progress)
    job.close()
    assert np.abs(mapping.place(w).z - before).max() < 1e-9


@pytest.mark.parametrize("grid", [GRID, FINE], ids=["small", "large"])
def test_what_is_shown_on_the_way_has_the_grid_s_nodes_and_no_folds(grid: Grid) -> None:
    mapping = FeatureMapping(grid, find_features(grid, CUT["stripes"]), keep="rigid")
    w = as_complex(make_warp("squeeze", WIDTH, HEIGHT, bend=60)(grid.nodes))
    shown = [step.preview for step in unfolding(mapping, w) if step.preview is not None]
    assert shown
    for positions in shown:
        assert positions.shape == (*grid.shape, 2)
        assert not find_folded_quads(as_complex(positions)).any()


def test_progress_never_runs_backwards() -> None:
    mapping = FeatureMapping(GRID, find_features(GRID, MASKS["standing_on_the_edge"]), keep="rigid")
    w = as_complex(make_warp("arc", WIDTH, HEIGHT, bend=45)(GRID.nodes))
    seen: list[float] = []
    run(unfolding(mapping, w), lambda step: seen.append(step.fraction))
    assert seen == sorted(seen)
    assert 0 <= seen[0] <= seen[-1] <= 1


def test_per_quad_mappings_are_unfolded_too() -> None:
    features = find_features(GRID, MASKS["close_neighbours"])
    plain = make_warp("arc", WIDTH, HEIGHT, bend=45)(GRID.nodes)
    options = MappingOptions(keep="rigid", method="per-quad")
    assert warp_grid(GRID, features, plain, options=options, allow_folds=True).folded.any()
    assert not warp_grid(GRID, features, plain, options=options).folded.any()
