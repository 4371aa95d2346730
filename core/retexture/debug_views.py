"""What the editor shows of a retexture: curved grids of patches, seams and the compression field."""

import cv2
import numpy as np

from core.arrays import Bytes, Points
from core.curves.bezier import Curve
from core.retexture.deformation.coordinates import DirectionField, SpineCurves, trace
from core.retexture.result import Retexture
from core.retexture.synthesis.patches import PatchShape

EVERY = 4
"""One line of a grid is kept of so many."""
MOST_GRIDS = 800
MARGIN_PX = 8
MOST_COMPRESSION = 3.0


def patch_grids(found: Retexture, lines: list[Curve], shape: PatchShape) -> Points:
    """Return the target grids of the patches that are to be seen, thinned to every fourth node: (n, K, J, 2).

    `lines` are all that steers them: targets, and where passive curves have gone.
    """
    rib, spine = EVERY * max(shape.rib // EVERY, 1), EVERY * max(shape.spine // EVERY, 1)
    places, headings = visible_origins(found)
    if not lines or not len(places):
        return np.empty((0, 2 * rib // EVERY + 1, 2 * spine // EVERY + 1, 2))
    reach = spine + rib + MARGIN_PX
    low, high = places.min(axis=0) - reach, places.max(axis=0) + reach
    field = DirectionField(SpineCurves(lines), (*low.tolist(), *high.tolist()))
    grids = trace(field, places, headings, spine=spine, rib=rib)
    return np.asarray(grids[:, ::EVERY, ::EVERY], np.float64)


def visible_origins(found: Retexture) -> tuple[Points, Points]:
    """Return places and headings (n, 2) of the patches that the result shows, some of them where they are many."""
    if not found.origins:
        return np.empty((0, 2)), np.empty((0, 2))
    places = np.concatenate([origins.target for origins in found.origins])
    headings = np.concatenate([origins.heading for origins in found.origins])
    numbers = np.unique(found.label) - 1
    # A preview may show the first patches of a batch that is not counted yet.
    numbers = numbers[(numbers >= 0) & (numbers < len(places))]
    some = numbers[:: max(1, -(-len(numbers) // MOST_GRIDS))]
    return places[some], headings[some]


def seams(found: Retexture) -> Bytes:
    """Return the seams as a mask (H, W), wide enough to be seen."""
    lines = found.seams.astype(np.uint8) * 255
    wide = max(1, round(max(lines.shape) / 1000))
    return np.asarray(cv2.dilate(lines, np.ones((wide + 1, wide + 1), np.uint8)), np.uint8)


def compression(found: Retexture) -> Bytes:
    """Return the compression at every pixel (H, W), as a logarithm: 0 where there is none, 255 from 3 on."""
    if not found.compression.size:
        return np.zeros(found.label.shape, np.uint8)
    field = np.log(found.compression) / np.log(MOST_COMPRESSION)
    dense = found.grid.at_pixels(np.clip(field, 0, 1)[..., None])[..., 0]
    return np.asarray(np.rint(255 * dense), np.uint8)
