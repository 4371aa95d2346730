import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.arrays import Bytes
from core.grid import Grid, find_features
from core.rasters.components import Components
from core.rasters.raster import Raster


def painted(raster: Raster, mask: Bytes) -> Raster:
    """Return the raster of `mask`, with tiles of `raster` where they are the same."""

    def edit(tile: Bytes, box: tuple[int, int, int, int]) -> Bytes:
        new = mask[box[1] : box[3], box[0] : box[2]]
        return tile if np.array_equal(tile, new) else new.copy()

    return raster.edited((0, 0, raster.width_px, raster.height_px), edit)


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([(700, 530), (257, 1025), (513, 90), (40, 30)]))
def test_components_are_those_of_the_whole_by_number_while_the_mask_is_painted(
    seed: int, size: tuple[int, int]
) -> None:
    rng = np.random.default_rng(seed)
    grid, mask = Grid(*size, cell_px=3), np.zeros(size[::-1], np.uint8)
    found, raster = Components(*grid.pixels), Raster.filled(*size)
    assert not found.labels(raster).any()
    for value in (255, 255, 0, 200, 127, 255, 0):
        ends = rng.integers(0, size, (2, 2)).tolist()
        cv2.line(mask, ends[0], ends[1], value, int(rng.integers(1, 50)))
        mask[rng.integers(0, size[1], 40), rng.integers(0, size[0], 40)] = value
        raster = painted(raster, mask)
        assert np.array_equal(found.labels(raster), find_features(grid, mask).labels)


@pytest.mark.parametrize("places", [[(255, 255), (256, 256)], [(256, 255), (255, 256)], [(255, 9), (256, 9)]])
def test_pixels_across_a_border_are_one_component(places: list[tuple[int, int]]) -> None:
    mask = np.zeros((600, 600), np.uint8)
    mask[tuple(np.transpose(places))] = 255
    mask[100, 100] = 255
    labels = Components(np.arange(600), np.arange(600)).labels(Raster.from_array(mask))
    assert len({int(labels[place]) for place in places} - {0, int(labels[100, 100])}) == 1
    assert labels.max() == 2


def test_another_size_begins_anew_and_only_what_changed_is_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    mask = np.full((700, 900), 255, np.uint8)
    found, raster = Components(np.arange(0, 700, 50), np.arange(0, 900, 50)), Raster.from_array(mask)
    assert (found.labels(raster) == 1).all()
    searched, search = [], cv2.connectedComponents

    def counted(marked: Bytes, *, connectivity: int) -> object:
        searched.append(marked)
        return search(marked, connectivity=connectivity)

    monkeypatch.setattr(cv2, "connectedComponents", counted)
    mask[301, 301] = 0
    assert (found.labels(painted(raster, mask)) == 1).all()
    assert len(searched) == 1
    assert found.labels(Raster.filled(901, 700)).max() == 0
