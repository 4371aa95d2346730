"""Warps that come as a picture: an ST map or a displacement says for every pixel of the result where it comes from.

The map goes from the result to the picture; a warp goes the other way. Between the centres of four pixels the map is
bilinear, and the place where it meets a point is found by Newton's method from the nearest pixel on. Where the map says
nothing of a point, it is continued from its nearest cell as an affine map.
"""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np
import scipy

from core.arrays import Bools, Floats, InputError, Ints, Points, Singles, readonly
from core.imaging.image import Image
from core.imaging.reading import load
from core.linalg.pairs import solve_pairs
from core.warps.warp import Warp

Kind: TypeAlias = Literal["st", "displacement"]
_STARTS = 250_000
"""From so many cells at most the nearest one to a point is chosen."""
_ROUNDS = 40
_STEP = 8.0
"""No step of Newton's method is longer than so many cells."""
_DONE_PX = 1e-6
_LEAST_SLOPE = 0.1
"""An ST map says where a picture is magnified or shrunk by less than ten times, at most of its pixels."""


@dataclass(frozen=True, eq=False)
class WarpMap:
    """A map from the result to the picture, as it was read."""

    places: Singles
    """(H, W, 2): where the pixel of the result comes from, as a share of the picture's width and height from the top
    left corner on; NaN where nothing comes."""

    def __post_init__(self) -> None:
        places = np.asarray(self.places)
        if places.ndim != 3 or places.shape[2] != 2 or min(places.shape) < 2:
            raise InputError(f"a warp map is (height, width, 2), 2 x 2 pixels at least, not {places.shape}")
        object.__setattr__(self, "places", readonly(places.astype(np.float32)))
        if not self._cells.any():
            raise InputError("a warp map that covers nothing")

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the result."""
        return self.places.shape[1], self.places.shape[0]

    @cached_property
    def _cells(self) -> Bools:
        """Which cells (H - 1, W - 1) between four pixels are covered."""
        known: Bools = np.asarray(np.isfinite(self.places).all(axis=2))
        found: Bools = known[:-1, :-1] & known[:-1, 1:] & known[1:, :-1] & known[1:, 1:]
        return found

    def warp(self, size_px: tuple[int, int]) -> Warp:
        """Return the warp for a picture of `size_px`, to pixels of the result."""

        def warp(points: Points) -> Points:
            share = ((points + 0.5) / size_px).reshape(-1, 2)
            return self._met(share).reshape(points.shape)

        return warp

    def _met(self, share: Points) -> Points:
        """Return where in the result (n, 2) the map has each of the shares (n, 2)."""
        places = self.places.astype(np.float64)
        cell = self._nearest(share)
        at = cell.astype(np.float64) + 0.5
        for _ in range(_ROUNDS):
            inside = np.clip(at - cell, 0, 1)
            value, across, down = _affine(places, cell, inside)
            beyond = at - cell - inside
            step = solve_pairs(across, down, share - value - across * beyond[:, :1] - down * beyond[:, 1:])
            long = np.abs(step).max(axis=1, keepdims=True)
            at = at + step * np.minimum(1, _STEP / np.maximum(long, _STEP))
            cell = self._entered(cell, at)
            if long.max(initial=0) < _DONE_PX:
                break
        return at

    def _nearest(self, share: Points) -> Ints:
        """Return the (column, row) of the covered cell whose corner the map has nearest to each of the shares."""
        row, column = self._cells.nonzero()
        every = max(1, -(-len(row) // _STARTS))
        row, column = row[::every], column[::every]
        _, found = scipy.spatial.cKDTree(self.places[row, column].astype(np.float64)).query(share)
        return np.stack([column[found], row[found]], axis=1)

    def _entered(self, cell: Ints, at: Points) -> Ints:
        """Return the cells that `at` lies in, those before where that is not covered."""
        height, width = self._cells.shape
        new = np.clip(np.floor(at), 0, [width - 1, height - 1]).astype(np.int64)
        return np.where(self._cells[new[:, 1], new[:, 0]][:, None], new, cell)


def _affine(places: Points, cell: Ints, inside: Points) -> tuple[Points, Points, Points]:
    """Return the map's value (n, 2) at places within cells, 0 to 1 each way, and its derivatives across and down."""
    x, y = cell.T
    u, v = inside[:, :1], inside[:, 1:]
    a, b, c, d = places[y, x], places[y, x + 1], places[y + 1, x], places[y + 1, x + 1]
    across, down = (b - a) * (1 - v) + (d - c) * v, (c - a) * (1 - u) + (d - b) * u
    return a * (1 - u) * (1 - v) + b * u * (1 - v) + c * (1 - u) * v + d * u * v, across, down


def warp_map_of(st_map: Path | None, displacement: Path | None) -> WarpMap | None:
    """Return the warp map in one of two files, None without."""
    if st_map is not None:
        return read_warp_map(st_map)
    return None if displacement is None else read_warp_map(displacement, "displacement")


def read_warp_map(path: Path, kind: Kind = "st") -> WarpMap:
    """Return the warp map in the float picture `path`.

    `st`: R and G are shares of the picture with the origin at the bottom left, as `core.interchange.stmap` writes them.
    `displacement`: R and G are pixels, to the right and up, from a pixel of the result to where it comes from; a result
    of the picture's own size. Alpha of a half or less says that nothing comes.

    Raises `InputError` that names the file where it is none of the two.
    """
    try:
        return warp_map_in(load(path), kind)
    except InputError as fault:
        raise InputError(str(fault) if str(path) in str(fault) else f"{path}: {fault}") from None


def warp_map_in(image: Image, kind: Kind = "st") -> WarpMap:
    """Return the warp map that a float picture holds; raise `InputError` where it holds none."""
    if not image.linear or image.channels < 3:
        raise InputError("a warp map is a float picture with red and green, such as an EXR file")
    height, width = image.pixels.shape[:2]
    values: Floats = image.pixels[..., :2].astype(np.float64)
    y, x = np.mgrid[0:height, 0:width]
    if kind == "st":
        places = np.stack([values[..., 0], 1 - values[..., 1]], axis=-1)
    else:
        places = np.stack([(x + 0.5 + values[..., 0]) / width, (y + 0.5 - values[..., 1]) / height], axis=-1)
    if image.has_alpha:
        places[image.pixels[..., -1] <= 0.5] = np.nan
    return WarpMap(places.astype(np.float32))


def is_st_map(image: Image) -> bool:
    """Return whether a picture is an ST map and nothing to look at: red grows to the right, green up, blue is 0."""
    if not image.linear or image.channels < 3 or image.pixels[..., 2].any() or min(image.size_px) < 2:
        return False
    values = image.pixels[..., :2].astype(np.float64)
    across, up = np.median(np.diff(values[..., 0], axis=1)), np.median(-np.diff(values[..., 1], axis=0))
    slopes = across * image.width_px, up * image.height_px
    return all(_LEAST_SLOPE < slope < 1 / _LEAST_SLOPE for slope in slopes)
