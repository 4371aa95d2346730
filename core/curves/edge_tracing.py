"""Curves along a picture's edges: a path that clings to them, outlines of masks and objects, and suggestions.

All of them look at the picture in encoded 8-bit colour, made smaller where it is large, and answer in its own pixels.
"""

import cv2
import numpy as np
import scipy

from core.arrays import Bytes, InputError, Points
from core.curves.bezier import Curve
from core.curves.fitting import fit
from core.imaging.image import Image
from core.imaging.proxy import proxy, scale_for
from core.masks.object_masks import object_within
from core.progress import Job, Progress

REACH_PX = 220
"""The path is sought so far around where it begins and ends, in pixels as they are looked at."""
SUGGESTION_PIXELS = 250_000
"""Edges are suggested in pictures of so many pixels."""
BLUR_PX = 1.6
"""Finer edges than this are texture, not features."""
SHORTEST = 0.07
"""Suggested edges are as long as this share of the picture's longer side at least."""
APART_PX = 9.0
"""Two suggestions that run closer together are one."""
ALIKE = 0.4
"""Share of a suggestion's points that may lie beside another one."""
TOLERANCE_PX = 2.5
"""Suggestions keep so close to their edges, in pixels as they are looked at."""
OUTLINE_TOLERANCE_PX = 1.5
WOBBLE_PX = 3.0
"""Lines of pixels are smoothed so far along: a feature is what goes through, not its fringe."""
SAMPLE_STEP = 4
END_PX = 6
"""Chains turn aside where they end; so much of them is left out."""
LEAST_AREA = 1e-3
"""Parts of a mask that are smaller, as shares of the picture, have no outline of their own."""


class Scissors:
    """Paths along edges (E. N. Mortensen and W. A. Barrett, "Intelligent scissors for image composition", 1995)."""

    def __init__(self, image: Image, *, scale: float = 1.0) -> None:
        """Look at `image` at `scale`, 1 at most: edges too fine to be seen there are not followed."""
        self._image, self._scale = image, min(scale, 1.0)
        self._last = np.array([image.width_px - 1, image.height_px - 1])
        self._begin = np.zeros(2)
        self._corner, self._far = np.zeros(2), np.zeros(2)
        """First and last pixel of the window that is looked at."""
        self._size = (1, 1)
        self._tool = cv2.segmentation.IntelligentScissorsMB()
        self._tool.setEdgeFeatureCannyParameters(32, 100)
        self._tool.setGradientMagnitudeMaxLimit(200)

    def begin(self, place: Points) -> Points:
        """Let paths begin at a place (2,) of the picture; return the place nearest to it that they can begin at."""
        self._begin = np.clip(np.rint(place), 0, self._last)
        self._look_towards(self._begin)
        return self._begin

    def path_to(self, place: Points) -> Points:
        """Return the path (n, 2) from where it began to a place (2,), or to the picture's edge before it."""
        end = np.clip(np.rint(place), 0, self._last)
        if (end < self._corner).any() or (end > self._far).any():
            self._look_towards(end)
        path = np.asarray(self._tool.getContour(self._pixel(place)), float).reshape(-1, 2)
        return np.asarray((smooth(path) + 0.5) / self._scale - 0.5 + self._corner)

    def _look_towards(self, end: Points) -> None:
        """Seek paths in a window that has the beginning and `end` (2,) well inside."""
        reach = np.ceil(REACH_PX / self._scale)
        low = np.maximum(np.minimum(self._begin, end) - reach, 0).astype(int)
        high = np.minimum(np.maximum(self._begin, end) + reach, self._last).astype(int)
        window = self._image.with_pixels(self._image.pixels[low[1] : high[1] + 1, low[0] : high[0] + 1])
        picture = proxy(window, self._scale)
        self._corner, self._far, self._size = low.astype(float), high, (picture.shape[1], picture.shape[0])
        self._tool.applyImage(picture)
        self._tool.buildMap(self._pixel(self._begin))

    def _pixel(self, place: Points) -> tuple[int, int]:
        """Return the pixel of the window, as it is looked at, nearest to a place (2,) of the picture."""
        x, y = np.rint((place - self._corner + 0.5) * self._scale - 0.5)
        return int(np.clip(x, 0, self._size[0] - 1)), int(np.clip(y, 0, self._size[1] - 1))


def smooth(line: Points, *, closed: bool = False) -> Points:
    """Return a line of pixels (n, 2) without its wobble; an open one keeps its ends."""
    if closed:
        return np.asarray(scipy.ndimage.gaussian_filter1d(line.astype(float), WOBBLE_PX, axis=0, mode="wrap"))
    # Turned about its ends, the line goes on as it comes: the ends stay, and no hook is made there.
    reach = min(int(4 * WOBBLE_PX), len(line) - 1)
    before, after = 2 * line[0] - line[reach:0:-1], 2 * line[-1] - line[-2 : -2 - reach : -1]
    longer = np.concatenate([before, line, after]).astype(float)
    smoothed = scipy.ndimage.gaussian_filter1d(longer, WOBBLE_PX, axis=0, mode="nearest")
    return np.asarray(smoothed[reach : reach + len(line)])


def outlines(mask: Bytes) -> list[Curve]:
    """Return closed curves around the parts of a mask (H, W) over 127, the largest first; tiny parts have none."""
    found, _ = cv2.findContours((mask > 127).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    lines = [line.reshape(-1, 2).astype(float) for line in found]
    areas = [cv2.contourArea(line.astype(np.float32)) for line in lines]
    order = sorted(range(len(lines)), key=lambda i: -areas[i])
    least = max(LEAST_AREA * mask.size, 30.0)
    kept = [smooth(lines[i], closed=True) for i in order if areas[i] >= least]
    return [fit(line, tolerance=OUTLINE_TOLERANCE_PX, closed=True) for line in kept]


def object_outline(image: Image, low: Points, high: Points) -> Job[Curve]:
    """Return the outline of the object within a rectangle from `low` to `high` (2,).

    Raises `InputError` where nothing stands out in it.
    """
    found = outlines((yield from object_within(image, low, high)))
    if not found:
        raise InputError("nothing stands out in the rectangle")
    return found[0]


def suggestions(image: Image, *, count: int = 12) -> Job[list[Curve]]:
    """Return curves along the picture's most prominent edges, the most prominent first.

    Edges are linked into chains by edge drawing (C. Topal and C. Akinlar 2012) and ranked by contrast times length.
    """
    scale = scale_for(image, SUGGESTION_PIXELS)
    yield Progress(0.0, "looking for edges")
    picture = np.asarray(cv2.GaussianBlur(proxy(image, scale), (0, 0), BLUR_PX), np.uint8)
    steps = [cv2.Sobel(picture.astype(np.float32), -1, *order, ksize=3).max(axis=2) for order in ((1, 0), (0, 1))]
    contrast = np.hypot(*steps)
    chains = [line[END_PX:-END_PX] for chain in _chains(picture) for line in _gentle(chain)]
    shortest = SHORTEST * max(picture.shape[:2])
    chains = [chain for chain in chains if len(chain) >= shortest and not _runs_along_border(chain, picture.shape)]
    yield Progress(0.5, "choosing edges")
    rank = [float(contrast[chain[:, 1], chain[:, 0]].mean() * np.sqrt(len(chain)) * _span(chain)) for chain in chains]
    chosen: list[Points] = []
    for number in np.argsort(rank)[::-1]:
        line = chains[number].astype(float)
        if len(chosen) < count and not _runs_along(line, chosen):
            chosen.append(line)
    return [fit((smooth(line) + 0.5) / scale - 0.5, tolerance=TOLERANCE_PX / scale) for line in chosen]


def _chains(picture: Bytes) -> list[Points]:
    """Return edges as chains of pixels (n, 2)."""
    drawing = cv2.ximgproc.createEdgeDrawing()
    parameters = cv2.ximgproc.EdgeDrawing.Params()
    parameters.MinPathLength = 20
    parameters.GradientThresholdValue = 12
    parameters.NFAValidation = False
    drawing.setParams(parameters)
    drawing.detectEdges(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))
    return [np.asarray(chain).reshape(-1, 2).astype(int) for chain in drawing.getSegments()]


def _gentle(chain: Points) -> list[Points]:
    """Cut a chain where it turns back on itself: features bend gently."""
    reach = 12
    if len(chain) <= 2 * reach:
        return [chain]
    ahead = chain[2 * reach :] - chain[reach:-reach]
    behind = chain[reach:-reach] - chain[: -2 * reach]
    sizes = np.maximum(np.hypot(*ahead.T) * np.hypot(*behind.T), 1e-9)
    sharp = (ahead * behind).sum(axis=1) / sizes < 0.2
    cuts = np.flatnonzero(sharp[1:] & ~sharp[:-1]) + reach + 1
    return list(np.split(chain, cuts))


def _span(chain: Points) -> float:
    """Return the length of the diagonal of a chain's box: a curl is no feature."""
    return float(np.hypot(*np.ptp(chain, axis=0)))


def _runs_along_border(chain: Points, shape: tuple[int, ...]) -> bool:
    """Return whether a good part of a chain lies beside the border of a picture of `shape`: a frame is no feature."""
    inner = np.minimum(chain, np.array([shape[1], shape[0]]) - 1 - chain).min(axis=1)
    return float(np.mean(inner < APART_PX)) > ALIKE


def _runs_along(line: Points, chosen: list[Points]) -> bool:
    """Return whether a good part of a line lies beside lines that are chosen already."""
    if not chosen:
        return False
    away, _ = scipy.spatial.cKDTree(np.concatenate(chosen)).query(line[::SAMPLE_STEP])
    return float(np.mean(away < APART_PX)) > ALIKE
