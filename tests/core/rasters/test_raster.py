import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from core.arrays import Bytes, InputError
from core.rasters.raster import TILE_PX, Box, Raster

sizes = st.tuples(st.integers(1, 300), st.integers(1, 300))


@given(sizes.flatmap(lambda size: arrays(np.uint8, size, elements=st.sampled_from([0, 255]), fill=st.just(0))))
def test_an_array_comes_back_as_it_was(values: Bytes) -> None:
    raster = Raster.from_array(values)
    assert (raster.width_px, raster.height_px) == values.shape[::-1]
    assert np.array_equal(raster.array, values)
    assert np.array_equal(raster.inverted.array, 255 - values)
    assert raster.is_empty == (not values.any())


@given(sizes, st.tuples(*[st.integers(-50, 350)] * 4))
def test_an_edit_shares_every_tile_outside_its_box(size: tuple[int, int], corners: Box) -> None:
    box = (*np.minimum(corners[:2], corners[2:]).tolist(), *np.maximum(corners[:2], corners[2:]).tolist())
    before = Raster.filled(*size, 7)
    after = before.edited(box, lambda tile, at: tile + 1)
    for (x0, y0, x1, y1), tile in after.changed_boxes(before):
        assert x0 < box[2]
        assert x1 > box[0]
        assert y0 < box[3]
        assert y1 > box[1]
        assert (tile == 8).all()
    x0, y0 = max(box[0], 0), max(box[1], 0)
    assert (after.array[y0 : box[3], x0 : box[2]] == 8).all() if x0 < box[2] and y0 < box[3] else True


def test_a_tile_returned_as_it_was_is_shared() -> None:
    raster = Raster.from_array(np.arange(TILE_PX * 2 * TILE_PX, dtype=np.int64).astype(np.uint8).reshape(TILE_PX, -1))
    same = raster.edited((0, 0, 10, 10), lambda tile, at: tile)
    assert not list(same.changed_boxes(raster))


def test_flat_tiles_are_one_array() -> None:
    raster = Raster.from_array(np.zeros((4 * TILE_PX, 4 * TILE_PX), np.uint8))
    assert len({id(tile) for row in raster.tiles for tile in row}) == 1


def test_tiles_cannot_be_written_to() -> None:
    raster = Raster.filled(200, 200)
    with pytest.raises(ValueError, match="read-only"):
        raster.tiles[0][0][0, 0] = 1


def test_a_mask_of_another_kind_is_refused() -> None:
    with pytest.raises(InputError, match="8 bit"):
        Raster.from_array(np.zeros((3, 3), np.float32))
