"""Stored error budgets of the mapping: what the features cost the rest of the picture; 1 % worse fails."""

import cv2
import numpy as np
import pytest

from core.arrays import Bytes, Floats
from core.grid import Grid, find_features
from core.mapping.folds import find_folded_quads
from core.mapping.jacobians import Complexes, as_complex, linear_parts
from core.mapping.options import Keep, MappingOptions
from core.mapping.warping import warp_grid
from core.warps.presets import make_warp

WIDTH, HEIGHT = 240, 180
GRID = Grid(WIDTH, HEIGHT, cell_px=4)
ALLOWED = 1.01


def disc() -> Bytes:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    cv2.circle(mask, (150, 80), 40, 255, -1)
    return mask


def neighbours() -> Bytes:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    mask[40:110, 30:80] = mask[60:150, 95:130] = 255
    cv2.ellipse(mask, (190, 90), (40, 20), 60, 0, 360, 255, -1)
    return mask


def cut() -> Bytes:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    cv2.circle(mask, (60, 0), 40, 255, -1)
    cv2.circle(mask, (WIDTH, 120), 45, 255, -1)
    return mask


MASKS = {mask.__name__: mask() for mask in (disc, neighbours, cut)}
BUDGETS: dict[tuple[str, str, float, Keep], tuple[float, float]] = {
    ("disc", "swirl", 30, "similarity"): (0.30355, 0.05641),
    ("disc", "arc", 40, "similarity"): (0.19557, 0.01791),
    ("disc", "arc", 40, "rigid"): (0.16449, 0.01301),
    ("disc", "squeeze", 45, "rigid"): (0.18220, 0.01245),
    ("disc", "flag", 50, "similarity"): (0.23743, 0.02738),
    ("neighbours", "swirl", 30, "similarity"): (0.49478, 0.12857),
    ("neighbours", "arc", 40, "similarity"): (0.38012, 0.05404),
    ("neighbours", "arc", 40, "rigid"): (0.32222, 0.06173),
    ("neighbours", "squeeze", 45, "rigid"): (0.24743, 0.03608),
    ("neighbours", "flag", 50, "similarity"): (0.42028, 0.08532),
    ("cut", "swirl", 30, "similarity"): (0.21316, 0.02531),
    ("cut", "arc", 40, "similarity"): (0.31651, 0.02746),
    ("cut", "arc", 40, "rigid"): (0.30983, 0.03595),
    ("cut", "squeeze", 45, "rigid"): (0.14393, 0.01139),
    ("cut", "flag", 50, "similarity"): (0.34141, 0.04208),
}
"""Deviation and distortion by mask, preset, bend and what features keep."""


def deviation(z: Complexes, w: Complexes, outside: Floats) -> float:
    """Return the RMS difference of the background's edges from those of W, in cells."""
    far = sum(np.abs(np.diff(z - w, axis=a)[: -1 if a else None, : None if a else -1]) ** 2 for a in (0, 1))
    return float(np.sqrt((far * outside).sum() / outside.sum()) / GRID.cell[0])


def distortion(z: Complexes, w: Complexes, outside: Floats) -> float:
    """Return the mean of tr(JᵀJ) / (2 det J) - 1 over the background, J taking W's quads to the result's."""
    here, there = linear_parts(GRID, w), linear_parts(GRID, z)
    det = np.abs(here.similar) ** 2 - np.abs(here.opposite) ** 2
    similar = (there.similar * here.similar.conj() - there.opposite * here.opposite.conj()) / det
    opposite = (there.opposite * here.similar - there.similar * here.opposite) / det
    a, b = np.abs(similar) ** 2, np.abs(opposite) ** 2
    return float(((a + b) / (a - b) * outside).sum() / outside.sum() - 1)


@pytest.mark.parametrize(("name", "preset", "bend", "keep"), BUDGETS)
def test_features_cost_the_background_no_more_than_they_did(name: str, preset: str, bend: float, keep: Keep) -> None:
    features = find_features(GRID, MASKS[name])
    plain = make_warp(preset, WIDTH, HEIGHT, bend=bend)(GRID.nodes)
    warped = warp_grid(GRID, features, plain, options=MappingOptions(keep=keep)).warped
    z, w, labels = as_complex(warped), as_complex(plain), features.labels
    outside = (np.maximum.reduce([labels[:-1, :-1], labels[:-1, 1:], labels[1:, 1:], labels[1:, :-1]]) == 0) * 1.0
    found = deviation(z, w, outside), distortion(z, w, outside)
    allowed = BUDGETS[name, preset, bend, keep]
    assert not find_folded_quads(z).any()
    assert found[0] <= allowed[0] * ALLOWED
    assert found[1] <= allowed[1] * ALLOWED
