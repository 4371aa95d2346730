"""The last move of the labelling: what is regrown, wherever it costs more than the plain deformation, is given back."""

from collections import deque
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np

from core.arrays import Bools, Ints, Singles
from core.retexture.sampling import Kernel, read
from core.retexture.stretch import AROUND_PX, stretch_cost, structure
from core.retexture.synthesis.candidate_pool import nearest, within
from core.retexture.synthesis.graph_cut import GrownPicture
from core.retexture.synthesis.pixel_adjacency import find_adjacency

BAND = 128
"""Rows worked on at a time."""


def retract(
    canvas: GrownPicture, picture: Singles, plain: Singles, usable: Bools | None, asked: Bools | None = None
) -> None:
    """Let a canvas show the plain deformation again wherever that costs less than what was regrown.

    `plain` (H, W, 2) are the places of the `picture` (H, W, c) that the deformation shows. Where these lie outside the
    picture, or not where it is `usable` (H, W; None for everywhere), what was regrown stays, and so it does where that
    was `asked` for (H, W; None for nowhere).
    """
    if not (canvas.label > 0).any():
        return
    window = _around(canvas.label > 0)
    label, shown, deformed = canvas.label[window], canvas.place[window], plain[window]
    # A rim of a pixel, which shows the plain deformation already, makes the seam to it one of the pairs.
    regrown = cv2.dilate((label > 0).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    y, x = np.nonzero(regrown)
    pixel = (y + window[0].start) * canvas.label.shape[1] + x + window[1].start
    cover = find_adjacency(np.zeros(len(pixel), np.int64), pixel, canvas.label.shape)
    costs = _stretch_costs(picture, shown, deformed, label)
    place = deformed[regrown]
    allowed = within(np.rint(place), canvas.label.shape)
    if usable is not None:
        allowed &= usable.reshape(-1)[nearest(place, usable.shape)]
    if asked is not None:
        allowed &= ~asked[window][regrown]
    colour = read(picture, place, Kernel.CUBIC)
    canvas.merge(cover, np.zeros(len(pixel), np.int32), colour, place, allowed, (costs[0][regrown], costs[1][regrown]))


def _around(mask: Bools) -> tuple[slice, slice]:
    """Return the rows and columns that hold a mask (H, W), and one more all around."""
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    return slice(max(rows[0] - 1, 0), rows[-1] + 2), slice(max(columns[0] - 1, 0), columns[-1] + 2)


def _stretch_costs(picture: Singles, shown: Singles, plain: Singles, label: Ints) -> tuple[Singles, Singles]:
    """Return what the stretches cost (h, w) of the places `shown` (h, w, 2) and of the `plain` ones."""
    low = np.minimum(shown.min(axis=(0, 1)), plain.min(axis=(0, 1))).astype(int)
    high = np.maximum(shown.max(axis=(0, 1)), plain.max(axis=(0, 1))).astype(int)
    start = np.clip(low - AROUND_PX, 0, np.array(picture.shape[1::-1]) - 1)
    stop = np.maximum(high + AROUND_PX, start + 1)
    tensor, origin = structure(picture[start[1] : stop[1], start[0] : stop[0]]), start.astype(np.float32)
    costs = np.empty((2, *label.shape), np.float32)

    def fill(top: int) -> None:
        # A row more on either side: a stretch is the step from a neighbour.
        first, last = max(top - 1, 0), min(top + BAND + 1, len(label))
        part, own = slice(first, last), slice(top - first, top - first + BAND)
        for cost, place, of in ((costs[0], shown, label), (costs[1], plain, None)):
            same = np.zeros_like(label[part]) if of is None else of[part]
            cost[top : top + BAND] = stretch_cost(tensor, place[part] - origin, same)[own]

    with ThreadPoolExecutor(2) as pool:
        deque(pool.map(fill, range(0, len(label), BAND)), maxlen=0)
    return costs[0], costs[1]
