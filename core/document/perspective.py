"""Perspective by its corners: where they lie, in place of the settings that take them there."""

import numpy as np

from core.arrays import InputError, Points
from core.document.document import Document
from core.warps.presets import PRESETS
from core.warps.projective import CORNERS, FRAME, is_convex

PRESET = "perspective"


def has_corners(document: Document) -> bool:
    """Return whether a perspective, and no outline upon it, says where the picture's corners go."""
    return document.warp.preset == PRESET and document.outline is None


def with_corners(document: Document, corners: Points) -> Document:
    """Return the document whose perspective takes the picture's corners to normalised places on the canvas.

    `corners` (4, 2) run clockwise from the top left and are taken as far as the settings reach. Bend, distortions and
    axis go into the corners, which say the same. Raises `InputError` if the corners form no convex quadrilateral.
    """
    usual = (FRAME + 1) / 2
    reach = {parameter.name: (parameter.low, parameter.high) for parameter in PRESETS[PRESET].settings}
    low, high = np.array([[reach[f"{name}-{axis}"] for axis in "xy"] for name in CORNERS]).transpose(2, 0, 1)
    moves = np.clip(100 * (corners - usual), low, high)
    if not is_convex(usual + moves / 100):
        raise InputError("perspective: the four corners do not form a convex quadrilateral")
    values = {f"{name}-{axis}": float(moves[k, i]) for k, name in enumerate(CORNERS) for i, axis in enumerate("xy")}
    return document.with_warp(preset=PRESET, bend=0.0, horizontal=0.0, vertical=0.0, vertical_axis=False, values=values)
