"""Affine alignment of a patch of lattice space with many places of a picture at once.

A frame (p, A) maps a place q of lattice space, in texels from a vertex, to the picture: x = p + A q. A template holds
the expected values at a raster of places q. Values are compared after their mean per channel and their norm are taken
out, so that shading and haze do not count. The update is inverse compositional (Baker and Matthews 2004): with the
template's steps J(q) = dT/d(d, D) of T(q + d + D q), projected off the template itself and off constants,

    (d, D) = (J^T J)^-1 J^T (I(p + A q) - T(q)),   A <- A (1 + D)^-1,   p <- p - A d.
"""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.overlay.detection.normalised_correlation import Forms, Windows
from core.overlay.detection.sift import Keypoints, detect_fine_keypoints
from core.overlay.filters.sampling import remap
from core.overlay.filters.smoothing import LIGHT_PX, shrink_ground

DAMPING = 1e-3
"""Of the Gauss-Newton matrix's own diagonal: keeps weakly textured templates from jumping."""
STILL = (2e-3, 1e-2)
"""Shift, in texels, and change of the vectors under which a frame has come to rest."""
REACH, FINEST = 0.25, 1 / 12
"""Texels from where it is predicted to where a vertex is searched, and between the places that are looked at."""


@dataclass(frozen=True)
class PatchFrames:
    """K places in a picture with the lattice's vectors there."""

    points: Points
    """(K, 2), pixels."""
    bases: Floats
    """(K, 2, 2), pixels a texel; columns are the two lattice vectors."""
    scores: Floats
    """(K,), correlation with the template, -1 to 1."""

    def __getitem__(self, which: Ints | Bools) -> "PatchFrames":
        """Return the frames that an index array or mask picks."""
        return PatchFrames(self.points[which], self.bases[which], self.scores[which])

    def __len__(self) -> int:
        return len(self.points)


@dataclass(frozen=True)
class Template:
    """Expected values on a raster of lattice space around a vertex."""

    reach: float
    """Texels from the vertex to the raster's sides."""
    values: Singles
    """(n, n, C), mean of each channel zero, norm one."""

    @cached_property
    def places(self) -> Points:
        """(n², 2), texels from the vertex, row by row."""
        return raster(self.reach, len(self.values))

    @cached_property
    def likeness(self) -> Forms:
        """What tells how much a patch is like the template."""
        return Forms(self.values.reshape(1, len(self.places), -1))

    @cached_property
    def steps(self) -> Forms:
        """The same, and what gives (d, D), D row by row, from the difference."""
        return Forms(np.concatenate([self.likeness.values, steps_of(self.values, self.reach)]))

    @cached_property
    def windows(self) -> Windows:
        """The template at places up to `REACH` texels away; its own are further apart than those of the raster."""
        count = min(round(2 * self.reach / FINEST), 36)
        return Windows(self.resized(count).values, max(1, round(REACH * count / (2 * self.reach))))

    def resized(self, count: int) -> "Template":
        """Return the template on a raster of count² places."""
        if count == len(self.values):
            return self
        kind = cv2.INTER_AREA if count < len(self.values) else cv2.INTER_LINEAR
        return make_template(np.asarray(cv2.resize(self.values, (count, count), interpolation=kind)), self.reach)


def raster(reach: float, count: int) -> Points:
    """Return (count², 2) places of a square raster from -reach to reach texels."""
    t = (np.arange(count) + 0.5) / count * 2 * reach - reach
    return np.stack(np.meshgrid(t, t), -1).reshape(-1, 2)


def make_template(values: Singles, reach: float) -> Template:
    """Return the template of `values` (n, n, C) on `raster(reach, n)`."""
    return Template(reach, unit(values))


def unit(values: Singles) -> Singles:
    """Return values (n, n, C) with the mean of each channel zero and the norm one."""
    centred = values - values.mean((0, 1))
    return np.asarray(centred / max(float(np.linalg.norm(centred)), 1e-6), np.float32)


def steps_of(values: Singles, reach: float) -> Singles:
    """Return the steps (6, n², C) from a difference to (d, D), D row by row, for a template's values (n, n, C)."""
    n, _, channels = values.shape
    places = raster(reach, n)
    dy, dx = (np.gradient(values, 2 * reach / n, axis=axis).reshape(n * n, channels) for axis in (0, 1))
    x, y = places[:, :1], places[:, 1:]
    slopes = np.stack([dx, dy, dx * x, dx * y, dy * x, dy * y]).astype(np.float64)
    slopes -= slopes.mean(1, keepdims=True)
    J = slopes.reshape(6, -1)
    t = values.reshape(-1).astype(np.float64)
    J = J - np.outer(J @ t, t)
    H = J @ J.T
    steps = np.linalg.solve(H + DAMPING * np.diag(np.diag(H)) + 1e-9 * np.eye(6), J)
    return np.asarray(steps, np.float32).reshape(6, n * n, channels)


@dataclass(frozen=True)
class FlatPicture:
    """A flattened picture and where it may be looked at."""

    image: Singles
    """(H, W, C)."""
    valid: Singles
    """(H, W, 1), one inside, zero outside."""

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        return self.image.shape[0], self.image.shape[1]

    @cached_property
    def keypoints(self) -> Keypoints:
        """Keypoints inside."""
        return detect_fine_keypoints(self.image, np.asarray(self.valid[..., 0] > 0, np.bool_))

    @cached_property
    def _outside(self) -> Ints:
        """Number (H + 1, W + 1) of pixels outside, above and to the left of each corner of a pixel."""
        return np.asarray(cv2.integral((self.valid[..., 0] <= 0).astype(np.uint8)), np.int64)

    @cached_property
    def _centred(self) -> Singles:
        """The image less its mean colour: what is compared has numbers near zero."""
        mean = cv2.mean(self.image, (self.valid[..., 0] > 0).astype(np.uint8))[: self.image.shape[2]]
        return np.asarray(self.image - np.array(mean, np.float32), np.float32)

    @cached_property
    def of_motifs(self) -> "FlatPicture":
        """The same picture with its ground shrunk."""
        inside = np.asarray(self.valid[..., 0] > 0, np.bool_)
        return FlatPicture(shrink_ground(self.image, inside, LIGHT_PX), self.valid)

    def everywhere(self) -> "FlatPicture":
        """Return the canvas without its limits."""
        return FlatPicture(self.image, np.ones_like(self.valid))

    def patches(self, points: Points, bases: Floats, places: Points) -> tuple[Singles, Singles | None]:
        """Return values (K, M, C), but for the mean colour, at places (M, 2) of frames (K, ...), and weights (K, M).

        A weight is one inside, zero outside; there are none where all are inside.
        """
        across = np.concatenate([places.T, np.ones((1, len(places)))]).astype(np.float32)
        x, y = (np.concatenate([bases[:, k], points[:, k, None]], 1).astype(np.float32) @ across for k in (0, 1))
        values = remap(self._centred, x, y)
        cut = np.flatnonzero(~self._whole(points, bases, float(np.abs(places).max(initial=0))))
        if not len(cut):
            return values, None
        weights = np.ones(x.shape, np.float32)
        weights[cut] = remap(self.valid, x[cut], y[cut])[..., 0] > 0.5
        return values, weights

    def _whole(self, points: Points, bases: Floats, reach: float) -> Bools:
        """Return which squares (K,) that reach so many texels lie within boxes that are wholly inside."""
        half = reach * np.abs(bases).sum(2)
        low, high = np.floor(points - half), np.ceil(points + half) + 1
        whole = (low >= 0).all(1) & (high <= self.shape[::-1]).all(1)
        (left, top), (right, bottom) = (ends[whole].astype(np.int64).T for ends in (low, high))
        count = self._outside
        whole[whole] = count[bottom, right] - count[top, right] - count[bottom, left] + count[top, left] == 0
        return np.asarray(whole, np.bool_)


def correlate(canvas: FlatPicture, template: Template, points: Points, bases: Floats) -> Floats:
    """Return the correlation (K,) of the template with frames; frames half outside score -1."""
    return template.likeness.compared(*canvas.patches(points, bases, template.places))[0]


def align(canvas: FlatPicture, template: Template, frames: PatchFrames, *, rounds: int = 12) -> PatchFrames:
    """Return the frames moved to where the template fits best, with their scores."""
    points, bases = frames.points.copy(), frames.bases.copy()
    moving = np.arange(len(points))
    for _ in range(rounds):
        if not len(moving):
            break
        patches = canvas.patches(points[moving], bases[moving], template.places)
        _, change = template.steps.compared(*patches)
        shift = np.clip(change[:, :2], -0.12, 0.12)
        turn = np.clip(change[:, 2:], -0.2, 0.2)
        bases[moving] = bases[moving] @ np.linalg.inv(np.eye(2) + turn.reshape(-1, 2, 2))
        points[moving] -= np.einsum("kij,kj->ki", bases[moving], shift)
        moving = moving[(np.abs(shift).max(1) > STILL[0]) | (np.abs(turn).max(1) > STILL[1])]
    return PatchFrames(points, bases, correlate(canvas, template, points, bases))


def search(canvas: FlatPicture, template: Template, frames: PatchFrames) -> PatchFrames:
    """Return the frames moved to the best of several shifts up to `REACH` texels."""
    windows = template.windows
    spacing = 2 * template.reach / len(windows.template)
    scores = windows.scores(
        *canvas.patches(frames.points, frames.bases, raster(spacing * windows.side / 2, windows.side))
    )
    best = scores.argmax(1)
    count = 2 * windows.shifts + 1
    moves = raster(spacing * count / 2, count)[best]
    points = frames.points + np.einsum("kij,kj->ki", frames.bases, moves)
    return PatchFrames(points, frames.bases, scores[np.arange(len(frames)), best])
