from dataclasses import replace

import cv2
import numpy as np
import pytest

from core.arrays import Bytes, Floats, Points
from core.grid import SIDES, Features, Grid, find_features
from core.linalg.blas import on_one_thread
from core.mapping.features.feature_mapping import FeatureMapping, Keep
from core.mapping.features.pose import Solution
from core.mapping.features.similarity import fit_residual
from core.mapping.folds import corner_areas, find_folded_quads
from core.mapping.handles.constraints import Constraints
from core.mapping.handles.probes import Probes
from core.mapping.injective.levels import GridLevel, Map
from core.mapping.injective.outline import CORNERS
from core.mapping.injective.problem import Goal
from core.mapping.injective.unfold import unfold
from core.mapping.injective.ways import Ways
from core.mapping.jacobians import Complexes, as_complex
from core.progress import Job, Progress, run
from core.warps.presets import make_warp

WIDTH, HEIGHT = 240, 180
GRID = Grid(WIDTH, HEIGHT, cell_px=3)
REST = as_complex(GRID.nodes)


def blank() -> Bytes:
    return np.zeros((HEIGHT, WIDTH), np.uint8)


def disc() -> Bytes:
    mask = blank()
    cv2.circle(mask, (120, 90), 30, 255, -1)
    return mask


def neighbours() -> Bytes:
    mask = blank()
    cv2.circle(mask, (80, 90), 36, 255, -1)
    mask[50:130, 124:170] = 255
    mask[60:120, 176:215] = 255
    return mask


def on_the_edge() -> Bytes:
    mask = blank()
    mask[60:150, 70:150] = 255
    for left in (70, 100, 135):
        mask[150:, left : left + 15] = 255
    return mask


def band() -> Bytes:
    mask = blank()
    mask[70:110] = 255
    return mask


def mapping_of(mask: Bytes, keep: Keep = "similarity") -> FeatureMapping:
    return FeatureMapping(GRID, find_features(GRID, mask), keep=keep)


def held_by(mapping: FeatureMapping, at: Points, to: Complexes, *, glide: bool = True) -> Constraints:
    held = Constraints.none(mapping.bodies, REST)
    gliding = np.zeros(GRID.shape, bool)
    if glide:
        gliding = GRID.outline & (mapping.index < 0)
        gliding[CORNERS] = False
    return replace(held, probes=Probes.of_points(at), to=to, glide=gliding)


def pulled(z: Complexes, held: Constraints, reach: float = 25.0) -> Complexes:
    """Put points on their targets, each with what is near it: a linear answer that folds where that is far."""
    z = z.copy()
    for _ in range(200):
        nodes, weights = GRID.weights_at(held.probes.at)
        miss = held.to - (z.ravel()[nodes] * weights).sum(axis=1)
        for p, by in zip(as_complex(held.probes.at), miss, strict=True):
            share = np.exp(-(np.abs(REST - p) ** 2) / (2 * reach**2))
            z[1:-1, 1:-1] += (0.6 * share * by)[1:-1, 1:-1]
    return z


def misses(z: Complexes, held: Constraints) -> Floats:
    nodes, weights = GRID.weights_at(held.probes.at)
    return np.asarray(np.abs((z.ravel()[nodes] * weights).sum(axis=1) - held.to))


def residuals(mapping: FeatureMapping, z: Complexes) -> Floats:
    parts = [body.nodes for body in mapping.bodies]
    return np.array([fit_residual(REST.ravel()[part], z.ravel()[part], rigid=False) for part in parts])


def at_rest(mapping: FeatureMapping) -> Solution:
    centres = np.array([REST.ravel()[body.nodes].mean() for body in mapping.bodies])
    return Solution(REST.copy(), np.ones(len(centres), np.complex128), centres)


def dragged(
    mask: Bytes, at: list[tuple[float, float]], by: list[complex]
) -> tuple[FeatureMapping, Constraints, Solution]:
    mapping, points = mapping_of(mask), np.array(at, np.float64)
    held = held_by(mapping, points, as_complex(points) + np.array(by))
    z = pulled(REST, held)
    rest = at_rest(mapping)
    for body, t in zip(mapping.bodies, rest.t, strict=True):
        z.ravel()[body.nodes] = body.place(1, t)
    return mapping, held, replace(rest, z=z)


def unfolded(mapping: FeatureMapping, held: Constraints, start: Solution) -> Solution:
    scales = np.abs(start.alpha)
    job = unfold(mapping, REST, start, shape=REST, scales=scales, constraints=held, safe=at_rest(mapping))
    return run(on_one_thread(job))


def warped(mask: Bytes, preset: str, bend: float, keep: Keep) -> tuple[FeatureMapping, Complexes, Solution, Solution]:
    mapping = mapping_of(mask, keep)
    w = as_complex(make_warp(preset, WIDTH, HEIGHT, bend=bend)(GRID.nodes))
    start, held = mapping.place(w), Constraints.none(mapping.bodies, REST)
    job = unfold(mapping, w, start, shape=w, scales=np.abs(start.alpha), constraints=held)
    return mapping, w, start, run(on_one_thread(job))


@pytest.mark.parametrize(
    ("mask", "preset", "bend", "keep"),
    [
        (neighbours, "swirl", 60, "similarity"),
        (neighbours, "squeeze", 45, "rigid"),
        (on_the_edge, "rise", 45, "rigid"),
        (on_the_edge, "arc", 80, "similarity"),
        (band, "swirl", 60, "similarity"),
        (band, "arc", 100, "rigid"),
    ],
)
def test_nothing_folds_and_bodies_keep_their_shape(mask: object, preset: str, bend: float, keep: Keep) -> None:
    assert callable(mask)
    mapping, w, start, found = warped(mask(), preset, bend, keep)
    assert not find_folded_quads(w).any()
    assert find_folded_quads(start.z).any()
    assert not find_folded_quads(found.z).any()
    assert residuals(mapping, found.z).max() < 1e-12
    if not (mapping.index[GRID.outline] >= 0).any():
        assert np.array_equal(found.z[GRID.outline], w[GRID.outline])


def test_what_does_not_fold_is_returned_as_it_is() -> None:
    _, _, start, found = warped(disc(), "flag", 10, "similarity")
    assert not find_folded_quads(start.z).any()
    assert found is start


DRAGS = [(60.0, 60.0), (180.3, 60.7), (61.0, 131.0), (175.0, 130.0)], [24 + 10j, -20 + 14j, 18 - 22j, 12 + 3j]


def test_points_end_on_their_targets_and_the_frame_stays_filled() -> None:
    mapping, held, start = dragged(disc(), *DRAGS)
    assert find_folded_quads(start.z).any()
    found = unfolded(mapping, held, start)
    assert not find_folded_quads(found.z).any()
    assert corner_areas(found.z).min() > 0
    assert misses(found.z, held).max() < 1e-3
    assert residuals(mapping, found.z).max() < 1e-12
    for number, side in enumerate(SIDES):
        across = found.z[side].imag if number < 2 else found.z[side].real
        along = found.z[side].real if number < 2 else found.z[side].imag
        assert np.ptp(across) == 0
        assert (np.diff(along) > 0).all()
    assert np.array_equal(found.z[CORNERS], REST[CORNERS])


def test_bodies_that_do_not_fit_a_new_frame_shrink_and_it_stays_filled() -> None:
    mask = on_the_edge()
    cv2.circle(mask, (190, 60), 25, 255, -1)
    mapping, rest = mapping_of(mask, "rigid"), REST.ravel()
    held = held_by(mapping, np.empty((0, 2)), np.empty(0, np.complex128))
    narrow = 0.4 * (REST.real + 0.5) - 0.5 + 1j * REST.imag
    free, pivots = held.free.copy(), held.pivots.copy()
    cut = int(mapping.index[-1].max())
    # Cut by the bottom: it neither turns nor leaves it.
    free[cut, [1, 3]], pivots[cut] = False, pivots[cut].real + 1j * (HEIGHT - 0.5)
    held = replace(held, free=free, pivots=pivots)
    centres = np.array([rest[body.nodes].mean() for body in mapping.bodies])
    t = 0.4 * (centres.real + 0.5) - 0.5 + 1j * centres.imag
    z = narrow.copy()
    for body, place in zip(mapping.bodies, t, strict=True):
        z.ravel()[body.nodes] = body.place(1, place)
    start = Solution(z, np.ones(len(t), np.complex128), t)
    assert find_folded_quads(z).any()
    job = unfold(mapping, narrow, start, shape=narrow, scales=np.ones(len(t)), constraints=held)
    found = run(on_one_thread(job))
    assert not find_folded_quads(found.z).any()
    assert residuals(mapping, found.z).max() < 1e-12
    assert (np.abs(found.alpha) < 1 + 1e-9).all()
    assert abs(found.alpha[cut].imag) == 0
    for number, side in enumerate(SIDES):
        across = (found.z - narrow)[side].imag if number < 2 else (found.z - narrow)[side].real
        assert np.abs(across).max() < 1e-9


def test_the_order_of_points_changes_nothing_and_runs_are_the_same() -> None:
    mapping, held, start = dragged(disc(), *DRAGS)
    one = unfolded(mapping, held, start)
    order = np.array([2, 0, 3, 1])
    other = unfolded(mapping, replace(held, probes=held.probes[order], to=held.to[order]), start)
    assert np.array_equal(one.z, other.z)
    assert np.array_equal(one.alpha, other.alpha)


def test_a_held_pose_is_kept_to_the_bit() -> None:
    mapping = mapping_of(disc())
    held = held_by(mapping, np.empty((0, 2)), np.empty(0, np.complex128))
    held = replace(held, free=np.zeros_like(held.free))
    rest = at_rest(mapping)
    alpha, t = rest.alpha * np.exp(0.6j), rest.t + 6 - 9j
    z = REST.copy()
    z.ravel()[mapping.bodies[0].nodes] = mapping.bodies[0].place(alpha[0], t[0])
    assert find_folded_quads(z).any()
    found = unfolded(mapping, held, Solution(z, alpha, t))
    assert not find_folded_quads(found.z).any()
    assert np.array_equal(found.alpha, alpha)
    assert np.abs(found.t - t).max() < 1e-9


def test_a_body_with_one_pin_turns_about_it_and_the_pin_stays() -> None:
    mapping = mapping_of(neighbours())
    held = held_by(mapping, np.empty((0, 2)), np.empty(0, np.complex128))
    free, pivots = held.free.copy(), held.pivots.copy()
    free[0, 2:], pivots[0] = False, 60 + 80j
    held, rest = replace(held, free=free, pivots=pivots), at_rest(mapping)
    t = rest.t + np.array([14 + 8j, 0, 0])
    z = REST.copy()
    for body, place in zip(mapping.bodies, t, strict=True):
        z.ravel()[body.nodes] = body.place(1, place)
    assert find_folded_quads(z).any()
    found = unfolded(mapping, held, replace(rest, z=z, t=t))
    assert not find_folded_quads(found.z).any()
    pin = found.t[0] + found.alpha[0] * (pivots[0] - rest.t[0])
    assert abs(pin - (pivots[0] + 14 + 8j)) < 1e-9


def test_points_that_cannot_all_be_had_yield_without_a_fold() -> None:
    # Two points that change places around a third, which stays: no map without folds has them.
    mapping, held, start = dragged(blank(), [(90, 90), (150, 90), (120, 90), (40, 40)], [60, -60, 0, 5 + 5j])
    found = unfolded(mapping, held, start)
    assert not find_folded_quads(found.z).any()
    assert misses(found.z, held)[3] < 1e-3


def test_fractions_grow_and_the_preview_does_not_fold() -> None:
    mapping, held, start = dragged(disc(), *DRAGS)
    steps: list[Progress] = []
    run(unfold(mapping, REST, start, shape=REST, scales=np.ones(1), constraints=held), steps.append)
    fractions = [step.fraction for step in steps]
    assert fractions == sorted(fractions)
    assert fractions[-1] < 1
    shown = [step.preview for step in steps if step.preview is not None]
    assert shown
    assert not find_folded_quads(as_complex(shown[0])).any()


def test_the_mapping_as_printed_is_unfolded_too() -> None:
    mapping = FeatureMapping(GRID, Features(find_features(GRID, on_the_edge()).labels), keep="rigid", method="per-quad")
    w = as_complex(make_warp("arc", WIDTH, HEIGHT, bend=70)(GRID.nodes))
    start = mapping.place(w)
    assert find_folded_quads(start.z).any()
    held = Constraints.none(mapping.bodies, REST)
    found = run(unfold(mapping, w, start, shape=w, scales=np.empty(0), constraints=held))
    assert not find_folded_quads(found.z).any()
    assert np.array_equal(found.z[GRID.outline], w[GRID.outline])


def test_points_that_a_way_leaves_off_their_targets_are_brought_there(monkeypatch: pytest.MonkeyPatch) -> None:
    mapping, held, start = dragged(disc(), [(30.0, 40.0), (205.0, 30.0), (150.0, 160.0)], [1 + 2j, -2 + 1j, 2.5j])
    level = GridLevel.of(mapping, REST, start, REST, held)
    centres = at_rest(mapping).t
    at_start, short = level.of_solution(start, centres), level.of_solution(at_rest(mapping), centres)
    ways = Ways(mapping, level, at_start, Goal(np.ones(1), at_start.alpha, at_start.place), centres)

    def find_short() -> Job[Map | None]:
        yield Progress(0.5)
        return short

    monkeypatch.setattr(ways, "_in_order", lambda *_: iter([find_short()]))
    found = run(on_one_thread(ways.find(None)))
    assert found is not None
    assert misses(short.z, held).min() > 2
    assert misses(found.z, held).max() < 1e-4
    assert not find_folded_quads(found.z.reshape(GRID.shape)).any()
