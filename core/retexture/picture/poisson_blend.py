"""Poisson blending where a seam stays visible (DPD sec. 3.4), as a correction on top of the resampled picture.

The step across a seam is what both patches would show of one pixel, the one that ends before it carried on by its own
last step; an edge of the picture that both continue is none. It is texture for the most part, different at every pixel,
and a cut has hidden it already. What shows is a step that is the same all along a stretch of the seam: a difference of
shading. It is the mean step m over the n pixels of the stretch, and it is real as far as it exceeds its standard error
s / sqrt(n); only the excess is removed, so that no detail is touched.
"""

from typing import NamedTuple, TypeAlias

import numpy as np

from core.arrays import Floats, Ints, Singles
from core.linalg import poisson
from core.retexture.picture.seam_antialiasing import SHARE
from core.retexture.sampling import Kernel, read

FADE_PX = 12.0
TILE_PX = 768
"""Corrections are solved for in tiles of this side, and some more around, since they fade."""
SURE = 2.0
"""Standard errors below which a mean step is taken for texture."""
STRETCH_PX = 24
"""Steps are averaged over the seam between two patches within squares of this side."""
SHORT = 6
"""Stretches of fewer pixels are left alone."""
LARGEST = 0.3
"""A step above this is no shading but different things that the patches show, and stays."""
STEPS = ((0, 1), (1, 0))
"""Down and right, from a pixel to the neighbours that it is compared with."""
Numbers: TypeAlias = tuple[Ints, Ints]
"""Rows and columns of n pixels."""


class Edges(NamedTuple):
    """n pairs of neighbouring pixels that a seam parts."""

    labels: Ints
    """(n, 2)."""
    steps: Floats
    """(n, C) from the first to the second."""
    y: Ints
    x: Ints
    """(n,) where the first pixel lies."""


def correction(source: Singles, place: Singles, label: Ints) -> Singles | None:
    """Return what to add to the picture (H, W, C) that patches `label` (H, W) show; None where no seam is visible.

    They show the `place`s (H, W, 2) of a `source` (H', W', C). Label 0 is the plain deformation, which stays as it is:
    there the correction is 0, and all of the step at its border is made up for inside.
    """
    edges = [_edges(source, place, label, down, right) for down, right in STEPS]
    split = len(edges[0].labels)
    seams = np.concatenate([edge.labels for edge in edges])
    stretch = np.concatenate([_stretch(edge, label.shape[1]) for edge in edges])
    visible = _visible_steps(seams, stretch, np.concatenate([edge.steps for edge in edges]))
    if not np.abs(visible).any():
        return None
    # A step m at the border of a half-plane makes -m/2 on one side and m/2 on the other: doubled inside, none outside.
    outer = (seams == 0).any(axis=1)
    visible = np.where(outer[:, None], 2 * visible, visible)
    total = np.zeros((*label.shape, source.shape[2]), np.float32)
    for y in range(0, label.shape[0], TILE_PX):
        for x in range(0, label.shape[1], TILE_PX):
            tile = (y, x, min(y + TILE_PX, label.shape[0]), min(x + TILE_PX, label.shape[1]))
            _fill_tile(total, tile, edges, (visible[:split], visible[split:]))
    return _softened(np.asarray(total * (label > 0)[..., None]), label, edges)


def _softened(change: Singles, label: Ints, edges: list[Edges]) -> Singles:
    """Mix corrections (H, W, C) across seams as the colours are mixed there, see `seam_antialiasing`."""
    mixed = change.copy()
    for edge, (down, right) in zip(edges, STEPS, strict=True):
        one, other = (edge.y, edge.x), (edge.y + down, edge.x + right)
        part = np.float32(SHARE) * (change[other] - change[one])
        mixed[one] += part * (label[one] > 0)[:, None]
        mixed[other] -= part * (label[other] > 0)[:, None]
    return mixed


def _fill_tile(
    total: Singles, tile: tuple[int, int, int, int], edges: list[Edges], steps: tuple[Floats, Floats]
) -> None:
    """Write into a tile (top, left, bottom, right) what the steps in and around it ask for."""
    margin = int(4 * FADE_PX)
    y0, x0 = max(tile[0] - margin, 0), max(tile[1] - margin, 0)
    y1, x1 = min(tile[2] + margin, total.shape[0]), min(tile[3] + margin, total.shape[1])
    fields = [np.zeros((y1 - y0, x1 - x0, total.shape[2]), np.float32) for _ in edges]
    for field, edge, step in zip(fields, edges, steps, strict=True):
        here = (edge.y >= y0) & (edge.y < y1 - 1) & (edge.x >= x0) & (edge.x < x1 - 1)
        field[edge.y[here] - y0, edge.x[here] - x0] = step[here]
    if not any(field.any() for field in fields):
        return
    change = poisson.remove_steps(fields[0][:, :-1], fields[1][:-1], fade_px=FADE_PX)
    inner = change[tile[0] - y0 : tile[2] - y0, tile[1] - x0 : tile[3] - x0]
    total[tile[0] : tile[2], tile[1] : tile[3]] = inner


def _edges(source: Singles, place: Singles, label: Ints, down: int, right: int) -> Edges:
    """Return the pairs of pixels and their lower, or right, neighbours that seams part."""
    height, width = label.shape
    y, x = np.nonzero(label[: height - down, : width - right] != label[down:, right:])
    first, second = (y, x), (y + down, x + right)
    shown = [read(source, place[at], Kernel.CUBIC) for at in (first, second)]
    # What the second patch would show of the first pixel, and the first one of the second.
    carried = _carry_on(place, label, second, (down, right)), _carry_on(place, label, first, (-down, -right))
    beyond = [read(source, at, Kernel.CUBIC) for at in carried]
    steps = (beyond[0] - shown[0] + shown[1] - beyond[1]).astype(np.float64) / 2
    return Edges(np.column_stack([label[first], label[second]]), steps, y, x)


def _carry_on(place: Singles, label: Ints, at: Numbers, step: tuple[int, int]) -> Singles:
    """Return the places (n, 2) that patches would show a `step` before pixels `at`, where they end."""
    here = place[at]
    y, x = (np.clip(at[i] + step[i], 0, label.shape[i] - 1) for i in (0, 1))
    own = (label[y, x] == label[at])[:, None]
    unit = np.array([step[1], step[0]], np.float32)
    return np.asarray(here - np.where(own, place[y, x] - here, unit), np.float32)


def _stretch(edges: Edges, width: int) -> Ints:
    """Return the number (n,) of the square of `STRETCH_PX` that each pair lies in."""
    return edges.y // STRETCH_PX * (width // STRETCH_PX + 1) + edges.x // STRETCH_PX


def _visible_steps(seams: Ints, stretch: Ints, steps: Floats) -> Floats:
    """Return the part of the mean step (n, C) along each pair's `stretch` of a seam that texture does not make."""
    turned = seams[:, 0] > seams[:, 1]
    sign = np.where(turned, -1.0, 1.0)[:, None]
    ordered = np.where(turned[:, None], seams[:, ::-1], seams)
    labels = int(seams.max(initial=0)) + 1
    number = (stretch * labels + ordered[:, 0]) * labels + ordered[:, 1]
    group, count = _groups(number)
    mean = _grouped(steps * sign, group, len(count)) / count[:, None]
    square = _grouped(steps**2, group, len(count)) / count[:, None]
    error = np.sqrt(np.maximum((square - mean**2).sum(axis=1), 0) / count)
    size = np.maximum(np.linalg.norm(mean, axis=1), 1e-12)
    excess = np.where((count < SHORT) | (size > LARGEST), 0, np.maximum(1 - SURE * error / size, 0))
    return np.asarray((mean * excess[:, None])[group] * sign)


def _groups(number: Ints) -> tuple[Ints, Ints]:
    """Return which group of equal `number`s (n,) each belongs to, and how many belong to each of the groups."""
    order = np.argsort(number, kind="stable")
    first = np.diff(number[order], prepend=-1) != 0
    group = np.empty_like(order)
    group[order] = np.cumsum(first) - 1
    return group, np.bincount(group)


def _grouped(values: Floats, group: Ints, number: int) -> Floats:
    return np.column_stack([np.bincount(group, values[:, i], number) for i in range(values.shape[1])])
