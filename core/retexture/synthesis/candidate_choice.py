"""The pool of candidates of a patch, and the choice among them (DPD sec. 3.4).

A candidate is the target grid shifted by (j, k) within the larger source grid. With A the colours that the canvas shows
at the target grid, m where it shows synthesised ones, and B the source grid's colours, the candidate costs

    c(j, k) = sum m^2 |A - B(j, k)|^2 / (sum m^2  v)  +  w u(j, k)  +  drift

v is the variance of B, so that the terms compare on any picture, u how often the candidate's pixels are shown already.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Floats, Singles
from core.retexture.synthesis.patches import PatchShape

DRIFT_ALONG, DRIFT_ACROSS = 0.02, 0.05
"""Costs of the outermost candidates."""
DRIFT_RIM = 1.0
"""The same where the plain deformation takes over: there the corresponding place joins it without a seam."""
STRETCH = 4.0
"""Cost of the square of a candidate's stretch on its way back to the corresponding place: by a half, it costs half of
what colours that have nothing in common do."""
MISSING = 4.0
"""Cost of a candidate that lies wholly where no texture may be taken from."""
CHANCE = 0.02
"""Size of the noise that decides between equals."""
FORBIDDEN = 1e3
LEAST = 8
"""Colours that count less than so many nodes decide nothing."""


@dataclass(frozen=True, eq=False)
class Pool:
    """What is known of the candidates of n patches."""

    colours: Singles
    """(n, K', J', c + 1) of the source grids, with the sums of their squares for a last channel."""
    uses: Singles
    """(n, K', J') how often the source grids' places are shown."""
    unusable: Singles
    """(n, K', J') 1 where no texture may be taken from."""
    variance: Floats
    """(n,)."""


def costs(pool: Pool, shown: Singles, weight: Singles, needed: Singles, variety: float) -> Floats:
    """Return the costs (n, 2 search_across + 1, 2 search_along + 1) but for the drift.

    `shown` (n, K, J, c), `weight` (n, K, J) and `needed` (n, K, J) belong to the target grids: colours, where they
    count, and which nodes the patches may be used at.
    """
    rows, columns = shown.shape[1:3]
    total = variety * _means(pool.uses, rows, columns).astype(np.float64)
    # The sum of m^2 |A - B|^2, multiplied out: m^2 |A|^2, and a correlation of (-2 m^2 A, m^2) with (B, |B|^2).
    template = np.empty((*shown.shape[:3], shown.shape[3] + 1), np.float32)
    counted, weighed = template[..., -1], template[..., :-1]
    np.multiply(weight, weight, out=counted)
    np.multiply((-2 * counted)[..., None], shown, out=weighed)
    own = np.einsum("nkjc,nkjc->n", weighed, shown) / -2
    scale = counted.sum(axis=(1, 2)) * pool.variance
    for i in np.flatnonzero(weight.sum(axis=(1, 2)) > LEAST):
        total[i] += (own[i] + cv2.matchTemplate(pool.colours[i], template[i], cv2.TM_CCORR)) / scale[i]
    for i in np.flatnonzero(pool.unusable.any(axis=(1, 2))):
        missing = cv2.matchTemplate(pool.unusable[i], needed[i], cv2.TM_CCORR)
        total[i] += MISSING * missing / max(float(needed[i].sum()), 1.0)
    return total


def _means(values: Singles, rows: int, columns: int) -> Singles:
    """Return the means over every window of `rows` x `columns` of arrays (n, K', J')."""
    count, high, wide = values.shape
    beside = np.ascontiguousarray(values.transpose(1, 0, 2)).reshape(high, count * wide)
    mean = cv2.boxFilter(beside, -1, (columns, rows), anchor=(0, 0), borderType=cv2.BORDER_REPLICATE)
    mean = np.asarray(mean, np.float32).reshape(high, count, wide).transpose(1, 0, 2)
    return mean[:, : high - rows + 1, : wide - columns + 1]


def weigh_drift(shape: PatchShape, offset: Floats, free: Floats, slope: Floats) -> Floats:
    """Return what it costs candidates (n, 2 search_across + 1, 2 search_along + 1) to lie off the corresponding place.

    A patch that holds the curve keeps its distance (n,) from it, and no other may take the curve with it. `free` (n,)
    is how far it may be chosen freely, see `region.Region`, and `slope` (n,) which share of the way back to the
    corresponding place it goes from a pixel to the next, at most.
    """
    along = np.arange(-shape.search_along, shape.search_along + 1)
    across = np.arange(-shape.search_across, shape.search_across + 1)[:, None]
    ahead, beside = (along / max(shape.search_along, 1)) ** 2, (across / max(shape.search_across, 1)) ** 2
    rim = DRIFT_RIM * (1 - free)[:, None, None]
    cost = DRIFT_ALONG * ahead + DRIFT_ACROSS * beside + rim * (ahead + beside)
    cost += STRETCH * slope[:, None, None] ** 2 * (along**2 + across**2)
    room = (np.abs(offset) - shape.rib - 1)[:, None, None]
    inward = -np.sign(offset)[:, None, None] * across
    return np.asarray(cost + FORBIDDEN * np.where(room < 0, across != 0, inward > room))
