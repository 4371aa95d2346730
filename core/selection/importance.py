"""What of a picture stands out, as a proposal of what to keep when it gets another shape.

By robust background detection (W. Zhu, S. Liang, Y. Wei and J. Sun, "Saliency optimization from robust background
detection", 2014). The picture is cut into small cells of one colour each. Ground is what hangs together, by colour,
with much of the picture's border for its size; an object is what differs from the ground near it.
"""

from dataclasses import dataclass

import cv2
import numpy as np
import scipy

from core.arrays import Bools, Bytes, Floats, InputError, Ints, Singles
from core.imaging.image import Image
from core.imaging.proxy import proxy, scale_for
from core.masks.object_masks import object_under
from core.progress import Job, Progress
from core.selection.features import MARKED
from core.selection.refining import fill_holes, smooth

PIXELS, CELLS = 60_000, 300
"""Pictures are looked at with about so many pixels, cut into so many cells."""
COMPACTNESS = 20.0
"""Of cells: how much their shape counts beside their colour."""
ROUNDS, LEAST_CELL_PERCENT = 10, 25
ALIKE, GROUND, NEAR = 10.0, 1.0, 0.25
"""Deviations of the paper: of colours in CIELAB, of shares of the border, of distances over the longer side."""
SMOOTHING = 0.01
"""Outlines are smoothed over this share of the picture's diagonal."""
LEAST_PART = 0.05
"""Parts that are smaller than this share of the largest one are left out."""


@dataclass(frozen=True, eq=False)
class _Cells:
    """The cells of a picture (h, w)."""

    number: Ints
    """Of the cell of every pixel (h, w)."""
    colour: Floats
    """Mean colours (n, 3) in CIELAB."""
    place: Floats
    """Mean places (n, 2), over the longer side."""
    on_border: Bools
    touches: Bools
    """Which cells (n, n) lie side by side; all those on the border do."""


def importance(image: Image) -> Job[Singles]:
    """Return how much each place (h, w) stands out, 0 to 1, at about `PIXELS` pixels."""
    yield Progress(0.0, "looking for what stands out")
    cells, apart, ground = _find_ground(image)
    yield Progress(0.7, "looking for what stands out")
    near = np.exp(-(scipy.spatial.distance.cdist(cells.place, cells.place, "sqeuclidean")) / (2 * NEAR**2))
    contrast = (apart * near) @ ground * (1 - ground)
    found = (contrast / max(contrast.max(), 1e-9))[cells.number].astype(np.float32)
    deviation = SMOOTHING * float(np.hypot(*found.shape))
    return np.asarray(cv2.GaussianBlur(found, (0, 0), deviation, borderType=cv2.BORDER_REPLICATE), np.float32)


def groundness(image: Image) -> Singles:
    """Return how much each place (h, w) is ground, 0 to 1, at about `PIXELS` pixels."""
    cells, _, ground = _find_ground(image)
    return np.asarray(ground[cells.number], np.float32)


def _find_ground(image: Image) -> tuple[_Cells, Floats, Floats]:
    """Return the cells of a picture, how far their colours are apart (n, n), and how much each is ground (n,)."""
    cells = _cut(proxy(image, scale_for(image, PIXELS)))
    apart = scipy.spatial.distance.cdist(cells.colour, cells.colour)
    return cells, apart, _groundness(cells, apart)


def propose_objects(image: Image, found: Singles, share: float) -> Job[Bytes]:
    """Return the mask (H, W) of the objects to which the most important places belong: about `share` of the picture.

    What is important ends where colours alike begin, mostly within an object; so it is cut out, as if somebody had
    painted it roughly. Where no object stands out it is what `propose` returns.
    """
    rough = propose(found, share, image.size_px)
    try:
        return (yield from object_under(image, rough))
    except InputError:
        return rough


def propose(found: Singles, share: float, size_px: tuple[int, int]) -> Bytes:
    """Return the mask (H, W) of the most important places: about `share` of the picture, 0 to 1, in few whole parts."""
    if share <= 0:
        return np.zeros(size_px[::-1], np.uint8)
    least = np.quantile(found, max(1 - share, 0.0))
    rough = np.where(found >= least, 255, 0).astype(np.uint8)
    whole = fill_holes(smooth(rough, SMOOTHING * float(np.hypot(*rough.shape))))
    count, parts, stats, _ = cv2.connectedComponentsWithStats((whole > MARKED).astype(np.uint8), connectivity=8)
    if count > 1:
        areas = stats[1:, cv2.CC_STAT_AREA]
        kept = 1 + np.flatnonzero(areas >= LEAST_PART * areas.max())
        whole = np.where(np.isin(parts, kept), whole, 0).astype(np.uint8)
    return np.asarray(cv2.resize(whole, size_px, interpolation=cv2.INTER_LINEAR), np.uint8)


def _cut(picture: Bytes) -> _Cells:
    """Cut a picture (h, w, 3) into cells by SLIC."""
    height, width = picture.shape[:2]
    side = max(round(float(np.sqrt(height * width / CELLS))), 4)
    # SLIC needs a border around a cell at least: a sliver of a picture is made wider by its own edge.
    room = [(max(2 * side - length, 0), 0) for length in (height, width)]
    padded = np.pad(picture, (*room, (0, 0)), mode="edge")
    tool = cv2.ximgproc.createSuperpixelSLIC(
        cv2.cvtColor(padded, cv2.COLOR_RGB2LAB), cv2.ximgproc.SLIC, side, COMPACTNESS
    )
    tool.iterate(ROUNDS)
    tool.enforceLabelConnectivity(LEAST_CELL_PERCENT)
    labels = np.asarray(tool.getLabels())[room[0][0] :, room[1][0] :]
    number = np.unique(labels, return_inverse=True)[1].reshape(labels.shape)
    sizes = np.bincount(number.ravel())
    lab = cv2.cvtColor(picture.astype(np.float32) / 255, cv2.COLOR_RGB2LAB)
    y, x = np.mgrid[:height, :width] / max(height, width)
    means = [np.bincount(number.ravel(), values.ravel()) / sizes for values in (*np.moveaxis(lab, 2, 0), x, y)]
    on_border = np.zeros(len(sizes), bool)
    on_border[np.concatenate([number[0], number[-1], number[:, 0], number[:, -1]])] = True
    touches = np.outer(on_border, on_border)
    for a, b in ((number[:, 1:], number[:, :-1]), (number[1:], number[:-1])):
        touches[a, b] = touches[b, a] = True
    np.fill_diagonal(touches, False)
    return _Cells(number, np.stack(means[:3], axis=1), np.stack(means[3:], axis=1), on_border, touches)


def _groundness(cells: _Cells, apart: Floats) -> Floats:
    """Return how much each cell (n,) is ground, 0 to 1, given how far colours are apart (n, n).

    Distances go from cell to cell, those up to the usual one between neighbours for nothing. With S how much two cells
    hang together, a cell has the area Σ S, of which Σ S over the border's cells is border.
    """
    nearest = np.where(cells.touches, apart, np.inf).min(axis=1)
    usual = float(nearest[np.isfinite(nearest)].mean()) if np.isfinite(nearest).any() else 0.0
    steps = np.where(cells.touches, np.maximum(apart - usual, 0) + 1e-4, 0)
    way = scipy.sparse.csgraph.dijkstra(scipy.sparse.csr_array(steps))
    together = np.exp(-(way**2) / (2 * ALIKE**2))
    share = together[:, cells.on_border].sum(axis=1) / np.sqrt(together.sum(axis=1))
    return np.asarray(1 - np.exp(-(share**2) / (2 * GROUND**2)))
