import cv2
import numpy as np
import pytest

from core.document.document import Document
from core.document.feature import Feature
from core.document.map_solver import settle_map
from core.grid import Grid, find_features
from core.imaging.images import Image
from core.mapping.result import Warped
from core.progress import run
from core.rasters.raster import Raster
from core.selection.features import number_area
from core.selection.nodes import MarkedNodes

SIZE = 300, 200


def area(left: int, right: int) -> np.ndarray:
    inside = np.zeros(SIZE[::-1], bool)
    inside[60:140, left:right] = True
    return inside


def raster(inside: np.ndarray) -> Raster:
    return Raster.from_array(np.where(inside, 255, 0).astype(np.uint8))


def bent(numbers: Raster | None, features: tuple[Feature, ...] = ()) -> Warped:
    image = Image(np.full((*SIZE[::-1], 3), 128, np.uint8))
    document = Document.of(image).with_warp(preset="arc", bend=60.0, cell_px=5.0)
    mask = raster(area(60, 140) | area(200, 250))
    return run(settle_map(document.changed(mask=mask, numbers=numbers, features=features)))


def test_without_numbers_features_are_the_components() -> None:
    grid, mask = Grid(*SIZE), raster(area(60, 140) | area(200, 250))
    assert np.array_equal(MarkedNodes(grid).features(mask, None).labels, find_features(grid, mask.array).labels)


def test_numbers_come_first_and_what_has_none_is_parted_as_ever() -> None:
    grid, mask = Grid(*SIZE, cell_px=5.0), raster(area(60, 140) | area(200, 250))
    nodes = MarkedNodes(grid)
    assert nodes.features(mask, None).ids.tolist() == [1, 2]
    numbers = number_area(None, area(100, 140), 4)
    found = nodes.features(mask, numbers)
    assert found.ids.tolist() == [4, 256, 257]
    assert nodes.features(mask, numbers) is found
    assert nodes.features(mask, numbers, frozenset({4})).ids.tolist() == [256, 257]
    assert nodes.features(Raster.filled(*SIZE), numbers).ids.tolist() == []


def test_the_answer_while_painting_is_that_from_scratch() -> None:
    grid, rng = Grid(600, 500, cell_px=9.0), np.random.default_rng(1)
    nodes, mask, numbers = MarkedNodes(grid), np.zeros((500, 600), np.uint8), np.zeros((500, 600), np.uint8)
    for _ in range(12):
        centre = int(rng.integers(600)), int(rng.integers(500))
        cv2.circle(mask, centre, int(rng.integers(10, 60)), (int(rng.choice([0, 255, 255])),), -1)
        cv2.circle(numbers, centre, int(rng.integers(5, 60)), (int(rng.integers(0, 4)),), -1)
        now = Raster.from_array(mask), Raster.from_array(np.where(mask > 127, numbers, 0).astype(np.uint8))
        assert np.array_equal(nodes.features(*now).labels, MarkedNodes(grid).features(*now).labels)


def test_features_that_touch_are_two_and_far_parts_are_one() -> None:
    joined = number_area(None, area(60, 140) | area(200, 250), 1)
    parted = number_area(number_area(None, area(60, 100), 1), area(100, 140), 2)
    for numbers, ids in ((joined, [1]), (parted, [1, 2, 256])):
        found = bent(numbers)
        assert [feature.id for feature in found.features] == ids
        assert max(feature.residual for feature in found.features) < 1e-9
        assert not found.folded.any()
    assert bent(None).features[0].angle_deg != pytest.approx(bent(joined).features[0].angle_deg, abs=1.0)


def test_a_feature_that_is_not_kept_is_bent_with_the_rest() -> None:
    numbers = number_area(number_area(None, area(60, 140), 1), area(200, 250), 2)
    found = bent(numbers, (Feature(1, kept=False),))
    assert [feature.id for feature in found.features] == [2]
    inside = MarkedNodes(Grid(*SIZE, cell_px=5.0)).features(raster(area(60, 140)), None).labels > 0
    assert np.abs(found.warped - found.plain)[inside].max() < np.abs(bent(numbers).warped - found.plain)[inside].max()
