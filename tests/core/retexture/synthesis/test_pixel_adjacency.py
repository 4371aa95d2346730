"""Which pixels of patches are neighbours."""

import numpy as np
import pytest

from core.arrays import Ints
from core.retexture.synthesis.candidate_pool import AT_ONCE_PX, in_parts
from core.retexture.synthesis.patches import Covered
from core.retexture.synthesis.pixel_adjacency import find_adjacency

HEIGHT, WIDTH = 20, 24


def blob(seed: int, left: int, top: int, side: int) -> Ints:
    """Return the numbers of some pixels, about four of five, of a square in the picture."""
    taken = np.zeros((HEIGHT, WIDTH), bool)
    taken[top : top + side, left : left + side] = np.random.default_rng(seed).random((side, side)) < 0.8
    return np.flatnonzero(taken)


def pairs_around(pixels: Ints) -> tuple[set[tuple[int, int, int]], set[tuple[int, int]]]:
    """Return the pairs that one finds pixel by pixel: both pixels and the seam; the pixel inside and the seam."""
    inner, outer, inside = set(), set(), set(pixels.tolist())
    for plane, step in ((0, 1), (1, WIDTH)):
        for p in range(HEIGHT * WIDTH):
            y, x = divmod(p, WIDTH)
            q, seam = p + step, plane * HEIGHT * WIDTH + p
            if (x if plane == 0 else y) == (WIDTH if plane == 0 else HEIGHT) - 1:
                continue
            if {p, q} <= inside:
                inner.add((p, q, seam))
            elif {p, q} & inside:
                outer.add((p if p in inside else q, seam))
    return inner, outer


@pytest.mark.parametrize(
    "patches", [[blob(0, 0, 0, 8), blob(1, 14, 10, 10)], [blob(2, 4, 4, 14)]], ids=["two in the corners", "one inside"]
)
def test_neighbours_within_a_round_and_beyond_its_patches(patches: list[Ints]) -> None:
    pixels = np.concatenate(patches)
    number = np.repeat(3 + np.arange(len(patches)), [len(p) for p in patches])
    cover = find_adjacency(number, pixels, (HEIGHT, WIDTH))
    inner, outer = pairs_around(pixels)
    np.testing.assert_array_equal(cover.pixel, pixels)
    one, other = pixels[cover.one].tolist(), pixels[cover.other].tolist()
    assert sorted(zip(one, other, cover.seam.tolist(), strict=True)) == sorted(inner)
    assert sorted(zip(pixels[cover.edge].tolist(), cover.edge_seam.tolist(), strict=True)) == sorted(outer)


def test_patches_take_their_pixels_along_into_another_order() -> None:
    at = np.arange(14, dtype=np.float32).reshape(7, 2)
    covered = Covered(np.array([0, 0, 1, 1, 1, 3, 3]), np.arange(10, 17), at)
    turned = covered.of(np.array([3, 2, 0]))
    assert turned.patch.tolist() == [0, 0, 2, 2]
    assert turned.pixel.tolist() == [15, 16, 10, 11]
    np.testing.assert_array_equal(turned.at, at[[5, 6, 0, 1]])


def test_large_rounds_are_laid_in_parts() -> None:
    few, many = np.arange(3), np.arange(3, 23)
    pixels = np.where(np.arange(23) < 3, 100, AT_ONCE_PX // 5)
    found = in_parts([few, many], pixels)
    np.testing.assert_array_equal(found[0], few)
    np.testing.assert_array_equal(np.concatenate(found[1:]), many)
    assert [int(pixels[part].sum()) for part in found[1:]] == 4 * [5 * (AT_ONCE_PX // 5)]
    assert [part.tolist() for part in in_parts([np.arange(2)], np.full(2, 9 * AT_ONCE_PX))] == [[0], [1]]
