"""Strips that the picture's edge cuts at both ends, where the outline has to give way."""

from typing import Literal

import cv2
import numpy as np
import pytest

from core.arrays import Bools, Bytes, Points
from core.grid import Grid, find_features
from core.mapping.approach import widened
from core.mapping.feature_mapping import FeatureMapping
from core.mapping.folds import folded_quads
from core.mapping.frames import Complexes, as_complex
from core.mapping.letting_go import LettingGo
from core.mapping.reeling import reeled
from core.mapping.release import around, crosses_itself, outer_nodes
from core.mapping.similarity import fit_residual
from core.mapping.stiffen import stiffen
from core.mapping.unfold import unfold
from core.progress import Progress, run
from core.warps.presets import make_warp

WIDTH, HEIGHT = 240, 160
COARSE, FINE = Grid(WIDTH, HEIGHT, cell_px=7.5), Grid(WIDTH, HEIGHT, cell_px=1.5)
Keep = Literal["similarity", "rigid"]


def strips(*rows: tuple[int, int]) -> Bytes:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    for top, bottom in rows:
        mask[top:bottom] = 255
    return mask


MIDDLE, FOUR = strips((60, 84)), strips((23, 35), (59, 71), (94, 106), (129, 141))


def mapped(grid: Grid, mask: Bytes, preset: str, bend: float, keep: Keep) -> tuple[FeatureMapping, Complexes]:
    mapping = FeatureMapping(grid, find_features(grid, mask), keep=keep)
    return mapping, as_complex(make_warp(preset, WIDTH, HEIGHT, bend=bend)(grid.nodes))


def is_whole(mapping: FeatureMapping, z: Complexes) -> bool:
    rest, labels = as_complex(mapping.grid.nodes), mapping.features.labels
    parts: list[Bools] = [labels == number for number in mapping.features.ids]
    shapes = max(fit_residual(rest[part], z[part], rigid=False) for part in parts)
    return not folded_quads(z).any() and not crosses_itself(z.ravel()[around(mapping.grid)]) and shapes < 1e-9


@pytest.mark.parametrize(
    ("mask", "preset", "bend", "keep", "stays"),
    [
        (MIDDLE, "arc", 90, "similarity", 0.85),
        (FOUR, "arc", -90, "similarity", 0.6),
        (FOUR, "arc", 90, "rigid", 0.6),
        (strips((131, 150)), "flag", 100, "similarity", 0.8),
        (strips((131, 150)), "arc", -90, "similarity", 0.6),
    ],
)
def test_what_is_beside_the_cuts_gives_way_and_a_first_mapping_is_shown(
    mask: Bytes, preset: str, bend: float, keep: Keep, stays: float
) -> None:
    mapping, w = mapped(FINE, mask, preset, bend, keep)
    outside, shown = outer_nodes(mapping), list[Points]()
    last = run(unfold(mapping, w), lambda step: shown.append(step.preview) if step.preview is not None else None).z
    assert shown
    assert all(is_whole(mapping, z) for z in [*map(as_complex, shown), last])
    for z in (as_complex(shown[-1]), last):
        assert (z == w)[outside].mean() > stays
    assert np.abs(last - as_complex(shown[-1])).max() < 0.2 * WIDTH


def test_a_first_mapping_is_shown_before_a_long_search_that_has_the_outline_at_w() -> None:
    poles = np.zeros((HEIGHT, WIDTH), np.uint8)
    poles[:, 47:61] = poles[:, 164:178] = 255
    mapping, w = mapped(FINE, poles, "arc-lower", -100, "rigid")
    outside, shown = outer_nodes(mapping), list[Complexes]()
    job = unfold(mapping, w)
    last = run(job, lambda step: shown.append(as_complex(step.preview)) if step.preview is not None else None).z
    assert is_whole(mapping, last)
    assert len(shown) == 2
    for z in [*shown, last]:
        assert not folded_quads(z).any()
        assert (z == w)[outside].all()


def specks() -> Bytes:
    rng, mask = np.random.default_rng(15), np.zeros((HEIGHT, WIDTH), np.uint8)
    for _ in range(45):
        centre = int(rng.uniform(8, WIDTH - 8)), int(rng.uniform(8, HEIGHT - 8))
        cv2.circle(mask, centre, int(rng.uniform(2.5, 5)), 255, -1)
    return mask


def test_features_too_close_for_a_coarser_grid_stiffen_from_where_it_takes_them() -> None:
    mapping, w = mapped(FINE, specks(), "swirl", 95, "rigid")
    letting_go = LettingGo(mapping, w, mapping.place(w), fits=True)
    shown = [as_complex(step.preview) for step in letting_go.finished() if step.preview is not None]
    assert shown
    assert is_whole(mapping, shown[0])
    assert (shown[0] == w)[outer_nodes(mapping)].all()


def test_what_is_found_first_does_not_end_the_search_for_better() -> None:
    mapping, w = mapped(FINE, strips((5, 21)), "arc", 90, "similarity")
    letting_go = LettingGo(mapping, w, mapping.place(w), fits=False)
    shown = [as_complex(step.preview) for step in letting_go.finished() if step.preview is not None]
    assert len(shown) > 1
    assert all(is_whole(mapping, z) for z in shown)
    outside = outer_nodes(mapping)
    before, after = ((z == w)[outside].mean() for z in (shown[0], shown[-1]))
    assert before < after


def test_features_that_cannot_be_brought_to_move_as_one_are_soon_given_up() -> None:
    mapping, w = mapped(COARSE, MIDDLE, "arc", 90, "similarity")
    outer = outer_nodes(mapping)
    beside = outer & widened(mapping.grid.outline & ~outer, 1)
    steps: list[Progress] = []
    assert run(stiffen(mapping, w, np.abs(mapping.place(w).alpha), released=beside), steps.append) is None
    assert 0 < len(steps) < 32


def test_features_that_fit_are_stiffened_with_the_outline_at_w() -> None:
    mapping, w = mapped(COARSE, strips((60, 84)), "arch", 20, "similarity")
    sizes = np.abs(mapping.place(w).alpha)
    for fits in (True, False):
        z = run(reeled(mapping, w, sizes, lightest=3.0, fits=fits)).z
        assert is_whole(mapping, z)
        assert (z == w)[outer_nodes(mapping)].all() == fits


def test_features_stiffen_where_outline_nodes_beside_them_are_let_go() -> None:
    mapping, w = mapped(COARSE, strips((113, 128)), "flag", 100, "similarity")
    sizes, outer = np.abs(mapping.place(w).alpha), outer_nodes(mapping)
    beside = np.zeros_like(outer)
    for rows in (slice(14, 15), slice(18, 19)):
        beside[rows, [0, -1]] = outer[rows, [0, -1]]
    assert beside.any()
    held = run(stiffen(mapping, w, sizes))
    freed = run(stiffen(mapping, w, sizes, released=beside))
    assert freed is not None
    assert is_whole(mapping, freed.z)
    assert (freed.z == w)[outer & ~beside].all()
    assert held is None or abs(held.alpha[0]) < abs(freed.alpha[0])


def test_the_way_down_never_reports_less_than_before() -> None:
    mapping, w = mapped(FINE, FOUR, "arc", -90, "similarity")
    steps: list[Progress] = []
    run(unfold(mapping, w), steps.append)
    done = [step.fraction for step in steps]
    assert done == sorted(done)
    assert 0 <= done[0] <= done[-1] <= 1
