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
from core.retexture.patches import PatchShape

DRIFT_ALONG, DRIFT_ACROSS = 0.02, 0.05
"""Costs of the outermost candidates."""
DRIFT_RIM = 1.0
"""The same where the plain deformation takes over: there the corresponding place joins it without a seam."""
MISSING = 4.0
"""Cost of a candidate that lies wholly where no texture may be taken from."""
CHANCE = 0.02
"""Size of the noise that decides between equals."""
FORBIDDEN = 1e3


@dataclass(frozen=True, eq=False)
class Pool:
    """What is known of the candidates of one patch."""

    colours: Singles
    """(K', J', c) of the source grid."""
    uses: Singles
    """(K', J') how often the source grid's places are shown."""
    unusable: Singles
    """(K', J') 1 where no texture may be taken from."""
    variance: float


def costs(pool: Pool, shown: Singles, weight: Singles, needed: Singles, variety: float) -> Floats:
    """Return the costs (2 search_across + 1, 2 search_along + 1) but for the drift.

    `shown` (K, J, c), `weight` (K, J) and `needed` (K, J) belong to the target grid: colours, where they count, and
    which nodes the patch may be used at.
    """
    total = np.zeros(np.subtract(pool.colours.shape[:2], shown.shape[:2]) + 1)
    if weight.sum() > 8:
        mask = np.repeat(weight[..., None], shown.shape[2], axis=2)
        squares = cv2.matchTemplate(pool.colours, shown, cv2.TM_SQDIFF, mask=mask)
        total += squares / (float((weight**2).sum()) * pool.variance)
    if pool.unusable.any():
        total += MISSING * cv2.matchTemplate(pool.unusable, needed, cv2.TM_CCORR) / max(float(needed.sum()), 1.0)
    rows, columns = shown.shape[:2]
    mean_use = cv2.boxFilter(pool.uses, -1, (columns, rows), anchor=(0, 0), borderType=cv2.BORDER_REPLICATE)
    return np.asarray(total + variety * np.asarray(mean_use)[: total.shape[0], : total.shape[1]])


def drift(shape: PatchShape, offset: float, inner: float) -> Floats:
    """Return what it costs candidates (2 search_across + 1, 2 search_along + 1) to lie off the corresponding place.

    A patch that holds the curve keeps its distance from it, and no other may take the curve with it. `inner` is the
    share of texture's own scale, see `region.Region`.
    """
    along = np.arange(-shape.search_along, shape.search_along + 1) / max(shape.search_along, 1)
    across = np.arange(-shape.search_across, shape.search_across + 1)
    beside = (across[:, None] / max(shape.search_across, 1)) ** 2
    cost = DRIFT_ALONG * along**2 + DRIFT_ACROSS * beside + DRIFT_RIM * (1 - inner) * (along**2 + beside)
    room = abs(offset) - shape.rib - 1
    inward = -np.sign(offset) * across
    held = (across != 0) if room < 0 and abs(offset) <= shape.rib + 1 else inward > max(room, 0)
    cost[held] += FORBIDDEN
    return np.asarray(cost)
