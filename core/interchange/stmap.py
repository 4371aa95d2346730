"""ST maps: a warp as a picture, as compositing programs exchange it.

Float32 EXR of the output's size. R and G say where a pixel's colour comes from, as shares of the source's width and
height with the origin at the bottom left: the identity is R = (i + 0.5) / W and G = 1 - (j + 0.5) / H for column i and
row j from the top. A is the coverage: 1 where the picture comes, 0 elsewhere, where R and G are 0.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from core.arrays import Floats, Ints, Points, Singles
from core.canvas import Canvas
from core.imaging.images import Image, writing_rows

_BAND_ROWS = 256
_CHUNK = 2_000_000
"""Pixels to test against triangles at a time."""
_SLACK = 1e-9
"""How far outside a triangle, as a share of it, a pixel's centre may lie, so that no seam stays uncovered."""


def write_st_map(
    rest: Points, warped: Points, source_px: tuple[int, int], canvas: Canvas, place: Path, *, named: Path
) -> None:
    """Write the ST map that `st_map_rows` yields to `place`; faults name the file `named`, which it is to become."""
    sample = Image(np.zeros((1, 1, 4), np.float32), linear=True)
    with writing_rows(sample, canvas.size, place, named=named) as append:
        for band in st_map_rows(rest, warped, source_px, canvas):
            append(band)


def st_map_rows(rest: Points, warped: Points, source_px: tuple[int, int], canvas: Canvas) -> Iterator[Singles]:
    """Yield the rows (h, W, 4) of the ST map of a warped grid from the top down, drawn as triangles like the picture.

    `rest` (R, C, 2) are pixels of the source of `source_px`, (width, height), `warped` those of `canvas`. Channels are
    R, G, B = 0 and A. Where the grid lies twofold, its upright side is seen.
    """
    at, to = _triangles(rest), _triangles(warped)
    area = _cross(to[:, 1] - to[:, 0], to[:, 2] - to[:, 0])
    order = np.argsort(area > 0, kind="stable")
    at, to, area = at[order], to[order], area[order]
    share = (at + 0.5) / source_px
    for top in range(0, canvas.height_px, _BAND_ROWS):
        band: Singles = np.zeros((min(_BAND_ROWS, canvas.height_px - top), canvas.width_px, 4), np.float32)
        for number, p in _pixels_near(to - [0, top], area, band.shape[1], band.shape[0]):
            a, b, c = (to[number] - [0, top]).swapaxes(0, 1)
            u = _cross(p - a, c - a) / area[number]
            v = _cross(b - a, p - a) / area[number]
            hit = np.minimum(np.minimum(u, v), 1 - u - v) >= -_SLACK
            number, p, u, v = number[hit], p[hit], u[hit, None], v[hit, None]
            a, b, c = share[number].swapaxes(0, 1)
            place = a + u * (b - a) + v * (c - a)
            band[p[:, 1], p[:, 0], 0] = place[:, 0]
            band[p[:, 1], p[:, 0], 1] = 1 - place[:, 1]
            band[p[:, 1], p[:, 0], 3] = 1
        yield band


def _triangles(nodes: Points) -> Points:
    """Return the corners (2M, 3, 2) of the triangles, each quad cut from its top left to its bottom right."""
    a, b, c, d = nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, 1:], nodes[1:, :-1]
    return np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)], axis=2).reshape(-1, 3, 2)


def _pixels_near(corners: Points, area: Floats, width: int, height: int) -> Iterator[tuple[Ints, Ints]]:
    """Yield numbers (n,) of triangles and pixels (n, 2) of the frame within their boxes, later triangles later."""
    last = [width - 1, height - 1]
    low = np.clip(np.ceil(corners.min(axis=1) - 1e-6), 0, last).astype(np.int64)
    high = np.clip(np.floor(corners.max(axis=1) + 1e-6), -1, last).astype(np.int64)
    span = np.maximum(high - low + 1, 0)
    count = np.where(area != 0, span[:, 0] * span[:, 1], 0)
    ends = np.cumsum(count)
    first = 0
    while first < len(count) and ends[-1] > (done := ends[first] - count[first]):
        after = max(first + 1, int(np.searchsorted(ends, done + _CHUNK)))
        number = np.repeat(np.arange(first, after), count[first:after])
        place = np.arange(len(number)) - (ends - count)[number] + done
        x, y = low[number, 0] + place % span[number, 0], low[number, 1] + place // span[number, 0]
        if len(number):
            yield number, np.stack([x, y], axis=-1)
        first = after


def _cross(a: Points, b: Points) -> Floats:
    area: Floats = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return area
