"""Poisson blending where a seam stays visible (DPD sec. 3.4), as a correction on top of the resampled picture.

The step across a seam is texture for the most part, different at every pixel, and a cut has hidden it already. What
shows is a step that is the same all along the seam: a difference of shading. It is the mean step m between two patches
over the n pixels of their seam, and it is real as far as it exceeds its standard error s / sqrt(n); only the excess is
removed, so that no detail is touched.
"""

import numpy as np

from core import poisson
from core.arrays import Floats, Ints, Singles

FADE_PX = 12.0
SURE = 2.0
"""Standard errors below which a mean step is taken for texture."""
SHORT = 6
"""Seams of fewer pixels are left alone."""
LARGEST = 0.15
"""A step above this is no shading but an edge of what the picture shows, and stays."""


def correction(picture: Singles, label: Ints) -> Singles | None:
    """Return what to add to `picture` (H, W, C) shown by patches `label` (H, W); None where no seam is visible.

    Label 0 is the plain deformation, which stays as it is: there the correction is 0, and all of the step at its
    border is made up for inside.
    """
    edges = [_edges(picture, label, axis) for axis in (1, 0)]
    seams = np.concatenate([edge[0] for edge in edges])
    steps = np.concatenate([edge[1] for edge in edges])
    visible = _visible_steps(seams, steps)
    if not np.abs(visible).any():
        return None
    outer = (seams == 0).any(axis=1)
    inside = (label > 0)[..., None]
    # A step m at the border of a half-plane makes -m/2 on one side and m/2 on the other: doubled inside, none outside.
    total = np.zeros(picture.shape, np.float32)
    for part, gain in ((outer, 2.0), (~outer, 1.0)):
        if np.abs(visible[part]).any():
            fields = _laid(edges, np.where(part[:, None], visible, 0), label.shape)
            total += np.float32(gain) * poisson.remove_steps(*fields, fade_px=FADE_PX)
    return np.asarray(total * inside)


def _edges(picture: Singles, label: Ints, axis: int) -> tuple[Ints, Floats, Ints]:
    """Return the pixel pairs along `axis` that seams part: labels (n, 2), steps (n, C), where the first lies (n,)."""
    last = label.shape[axis] - 1
    first, second = (np.take(label, range(a, a + last), axis) for a in (0, 1))
    where = np.flatnonzero(first != second)
    a, b = (np.take(picture, range(i, i + last), axis).reshape(-1, picture.shape[2])[where] for i in (0, 1))
    pairs = np.column_stack([first.reshape(-1)[where], second.reshape(-1)[where]])
    return pairs, (b - a).astype(np.float64), where


def _visible_steps(seams: Ints, steps: Floats) -> Floats:
    """Return the part of the mean step (n, C) along each pair's seam that exceeds what texture makes by chance."""
    turned = seams[:, 0] > seams[:, 1]
    sign = np.where(turned, -1.0, 1.0)[:, None]
    ordered = np.where(turned[:, None], seams[:, ::-1], seams)
    _, group, count = np.unique(ordered, axis=0, return_inverse=True, return_counts=True)
    group = group.reshape(-1)
    mean = _grouped(steps * sign, group, len(count)) / count[:, None]
    square = _grouped(steps**2, group, len(count)) / count[:, None]
    error = np.sqrt(np.maximum((square - mean**2).sum(axis=1), 0) / count)
    size = np.maximum(np.linalg.norm(mean, axis=1), 1e-12)
    excess = np.where((count < SHORT) | (size > LARGEST), 0, np.maximum(1 - SURE * error / size, 0))
    return np.asarray((mean * excess[:, None])[group] * sign)


def _grouped(values: Floats, group: Ints, number: int) -> Floats:
    return np.column_stack([np.bincount(group, values[:, i], number) for i in range(values.shape[1])])


def _laid(edges: list[tuple[Ints, Floats, Ints]], steps: Floats, shape: tuple[int, int]) -> tuple[Singles, Singles]:
    """Return the steps at their places: between right neighbours (H, W-1, C), between lower ones (H-1, W, C)."""
    channels, split = steps.shape[1], len(edges[0][0])
    right = np.zeros((shape[0] * (shape[1] - 1), channels), np.float32)
    below = np.zeros(((shape[0] - 1) * shape[1], channels), np.float32)
    right[edges[0][2]], below[edges[1][2]] = steps[:split], steps[split:]
    return right.reshape(shape[0], shape[1] - 1, channels), below.reshape(shape[0] - 1, shape[1], channels)
