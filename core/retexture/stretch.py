"""What it costs a pixel that the map which it shows stretches the source there.

With J the Jacobian of the map from the result to the source, s_i its stretches, the lengths in the source of what is a
pixel long in the result, and u_i the directions in the source that they belong to, J J' = sum s_i^2 u_i u_i'. With T
the structure tensor of the source at the place shown, the sum of the products g g' of its channels' gradients, a pixel
costs

    STRETCH sum_i (log s_i)^2 u_i' T u_i:

the squared difference of colours that a stretch makes some way off what stays in place, there the gradient times the
displacement, to first order. Neither flat colour nor an edge that is stretched along itself costs anything. Colours are
encoded RGB from 0 to 1, as in the costs of seams.
"""

import cv2
import numpy as np

from core.arrays import Ints, Singles
from core.retexture.sampling import read

STRETCH = 30.0
"""What a stretch counts against the costs of seams."""
PRESSED = 0.1
"""What is pressed together stays sharp, and costs this share of what costs as much magnified."""
NEAR_PX = 2.0
"""Gradients are averaged over about so far."""
AROUND_PX = round(4 * NEAR_PX)
MOST = 2.0
"""Logarithm of the largest stretch that is told from smaller ones."""


def stretch_cost(tensor: Singles, place: Singles, label: Ints) -> Singles:
    """Return what it costs to show `place`s (h, w, 2) of a source with a structure `tensor` (H, W, 3), by `label`s."""
    right, down = steps(place, label)
    xx, xy, yy = np.moveaxis(read(tensor, place), -1, 0)
    square = right * right + down * down
    mixed = right[..., 0] * right[..., 1] + down[..., 0] * down[..., 1]
    mean, half = (square[..., 0] + square[..., 1]) / 2, (square[..., 0] - square[..., 1]) / 2
    radius = np.hypot(half, mixed)
    most, least = (_squared_log(mean + sense * radius) for sense in (1, -1))
    along = (half * (xx - yy) + 2 * mixed * xy) / np.maximum(radius, np.float32(1e-6))
    return np.asarray(np.float32(STRETCH / 2) * ((most + least) * (xx + yy) + (most - least) * along), np.float32)


def structure(picture: Singles) -> Singles:
    """Return the structure tensor (H, W, 3) of a picture (H, W, c): xx, xy and yy, per px^2."""
    tensor = np.zeros((*picture.shape[:2], 3), np.float32)
    for plane in np.moveaxis(picture, -1, 0):
        x, y = (cv2.Scharr(plane, cv2.CV_32F, *axis, scale=1 / 32) for axis in ((1, 0), (0, 1)))
        for part, (one, other) in enumerate(((x, x), (x, y), (y, y))):
            tensor[..., part] += one * other
    return np.asarray(cv2.GaussianBlur(tensor, (0, 0), NEAR_PX, dst=tensor), np.float32)


def steps(place: Singles, label: Ints) -> tuple[Singles, Singles]:
    """Return by how much places (H, W, 2) change for a pixel to the right and a pixel down (H, W, 2), within labels.

    Where a label is only a pixel wide it is taken not to be stretched.
    """
    found = []
    for axis in (1, 0):
        step = np.zeros_like(place)
        step[..., 1 - axis] = 1
        same = np.diff(label, axis=axis) == 0
        by = np.diff(place, axis=axis)
        # The step from the pixel before, and over it, where there is one, that to the next.
        for part in (slice(1, None), slice(None, -1)):
            there = step[:, part] if axis else step[part]
            np.copyto(there, by, where=same[..., None])
        found.append(step)
    return found[0], found[1]


def _squared_log(square: Singles) -> Singles:
    """Return the squared logarithms of stretches from their squares."""
    log = np.log(np.maximum(square, np.float32(1e-6))) / 2
    return np.asarray(np.clip(log, -MOST, MOST) ** 2, np.float32)
