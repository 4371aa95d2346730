"""Affine alignment of a patch of lattice space with many places of a picture at once.

A frame (p, A) maps a place q of lattice space, in texels from a vertex, to the picture: x = p + A q. A template holds
the expected values at a raster of places q. Values are compared after their mean per channel and their norm are taken
out, so that shading and haze do not count. The update is inverse compositional (Baker and Matthews 2004): with the
template's steps J(q) = dT/d(d, D) of T(q + d + D q), projected off the template itself and off constants,

    (d, D) = (J^T J)^-1 J^T (I(p + A q) - T(q)),   A <- A (1 + D)^-1,   p <- p - A d.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Points, Singles

DAMPING = 1e-3
"""Of the Gauss-Newton matrix's own diagonal: keeps weakly textured templates from jumping."""
STILL = (2e-3, 1e-2)
"""Shift, in texels, and change of the vectors under which a frame has come to rest."""


@dataclass(frozen=True)
class Frames:
    """K places in a picture with the lattice's vectors there."""

    points: Points
    """(K, 2), pixels."""
    bases: Floats
    """(K, 2, 2), pixels a texel; columns are the two lattice vectors."""
    scores: Floats
    """(K,), correlation with the template, -1 to 1."""

    def __getitem__(self, which: Ints | Bools) -> "Frames":
        """Return the frames that an index array or mask picks."""
        return Frames(self.points[which], self.bases[which], self.scores[which])

    def __len__(self) -> int:
        return len(self.points)


@dataclass(frozen=True)
class Template:
    """Expected values on a raster of lattice space around a vertex."""

    places: Points
    """(M, 2), texels from the vertex, row by row."""
    values: Singles
    """(M, C), mean of each channel zero, norm one."""
    steps: Singles
    """(6, M C), from an error to (d, D), D row by row."""


def raster(reach: float, count: int) -> Points:
    """Return (count², 2) places of a square raster from -reach to reach texels."""
    t = (np.arange(count) + 0.5) / count * 2 * reach - reach
    return np.stack(np.meshgrid(t, t), -1).reshape(-1, 2)


def make_template(values: Singles, reach: float) -> Template:
    """Return the template of `values` (n, n, C) on `raster(reach, n)`."""
    n, _, channels = values.shape
    places = raster(reach, n)
    flat, norm, _ = normalised(values.reshape(1, n * n, channels), np.ones((1, n * n), np.float32))
    spacing = 2 * reach / n
    dy, dx = (np.gradient(values, spacing, axis=axis).reshape(n * n, channels) for axis in (0, 1))
    x, y = places[:, :1], places[:, 1:]
    slopes = np.stack([dx, dy, dx * x, dx * y, dy * x, dy * y]).astype(np.float64) / max(float(norm[0]), 1e-9)
    slopes -= slopes.mean(1, keepdims=True)
    J = slopes.reshape(6, -1)
    t = flat[0].reshape(-1).astype(np.float64)
    J = J - np.outer(J @ t, t)
    H = J @ J.T
    steps = np.linalg.solve(H + DAMPING * np.diag(np.diag(H)) + 1e-9 * np.eye(6), J)
    return Template(places, flat[0], steps.astype(np.float32))


def normalised(values: Singles, weights: Singles) -> tuple[Singles, Singles, Singles]:
    """Take mean and norm out of patches (K, M, C) under weights (K, M); return patches, norms and valid shares (K,)."""
    total = weights.sum(1)
    mean = np.einsum("km,kmc->kc", weights, values) / np.maximum(total, 1e-6)[:, None]
    centred = values - mean[:, None]
    if total.min(initial=0) < weights.shape[1]:
        centred *= weights[..., None]
    norms = np.sqrt(np.einsum("kmc,kmc->k", centred, centred))
    centred /= np.maximum(norms, 1e-6)[:, None, None]
    return centred, norms, total / weights.shape[1]


def sample(image: Singles, at: Points) -> Singles:
    """Return `image` (H, W, C) at positions (K, M, 2), bilinear; zero outside."""
    x, y = (np.ascontiguousarray(at[..., k], np.float32) for k in (0, 1))
    step = 30000  # cv2.remap takes at most 32767 rows
    rows = [
        cv2.remap(image, x[k : k + step], y[k : k + step], cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        for k in range(0, len(x), step)
    ]
    out = np.concatenate(rows) if rows else np.empty((0, at.shape[1]), np.float32)
    return np.asarray(out, np.float32).reshape(*at.shape[:2], -1)


@dataclass(frozen=True)
class Canvas:
    """A flattened picture and where it may be looked at."""

    image: Singles
    """(H, W, C)."""
    valid: Singles
    """(H, W, 1), one inside, zero outside."""

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        return self.image.shape[0], self.image.shape[1]

    def everywhere(self) -> "Canvas":
        """Return the canvas without its limits."""
        return Canvas(self.image, np.ones_like(self.valid))

    def patches(self, points: Points, bases: Floats, places: Points) -> tuple[Singles, Singles]:
        """Return values (K, M, C) and weights (K, M) at places (M, 2) of frames (K, ...)."""
        at = points[:, None] + places @ np.swapaxes(bases, 1, 2)
        return sample(self.image, at), (sample(self.valid, at)[..., 0] > 0.5).astype(np.float32)


def expected(template: Template, weights: Singles) -> Singles:
    """Return the template's values (K or 1, M, C) normalised under the weights (K, M) of patches."""
    if weights.min(initial=1) > 0:
        return template.values[None]
    return normalised(np.broadcast_to(template.values, (*weights.shape, template.values.shape[1])), weights)[0]


def correlate(canvas: Canvas, template: Template, points: Points, bases: Floats) -> Floats:
    """Return the correlation (K,) of the template with frames; frames half outside score -1."""
    values, weights = canvas.patches(points, bases, template.places)
    patches, _, share = normalised(values, weights)
    scores = np.einsum("kmc,kmc->k", np.broadcast_to(expected(template, weights), patches.shape), patches)
    return np.where(share > 0.5, scores.astype(np.float64), -1.0)


def align(canvas: Canvas, template: Template, frames: Frames, *, rounds: int = 12) -> Frames:
    """Return the frames moved to where the template fits best, with their scores."""
    points, bases = frames.points.copy(), frames.bases.copy()
    moving = np.arange(len(points))
    for _ in range(rounds):
        values, weights = canvas.patches(points[moving], bases[moving], template.places)
        patches, _, _ = normalised(values, weights)
        # Both are zero where a weight is: what lies outside says nothing.
        error = (patches - expected(template, weights)).reshape(len(moving), -1)
        change = (error @ template.steps.T).astype(np.float64)
        shift = np.clip(change[:, :2], -0.12, 0.12)
        turn = np.clip(change[:, 2:], -0.2, 0.2)
        bases[moving] = bases[moving] @ np.linalg.inv(np.eye(2) + turn.reshape(-1, 2, 2))
        points[moving] -= np.einsum("kij,kj->ki", bases[moving], shift)
        moving = moving[(np.abs(shift).max(1) > STILL[0]) | (np.abs(turn).max(1) > STILL[1])]
        if not len(moving):
            break
    return Frames(points, bases, correlate(canvas, template, points, bases))


def search(canvas: Canvas, template: Template, frames: Frames, *, reach: float = 0.25, count: int = 7) -> Frames:
    """Return the frames moved to the best of count² shifts up to `reach` texels."""
    coarse = thinned(template)
    shifts = np.linspace(-reach, reach, count)
    moves = np.stack(np.meshgrid(shifts, shifts), -1).reshape(-1, 2)
    at = frames.points[:, None] + moves @ np.swapaxes(frames.bases, 1, 2)
    bases = np.repeat(frames.bases, len(moves), 0)
    scores = correlate(canvas, coarse, at.reshape(-1, 2), bases).reshape(len(frames), -1)
    best = scores.argmax(1) if len(frames) else np.empty(0, np.int64)
    rows = np.arange(len(frames))
    return Frames(at[rows, best], frames.bases, scores[rows, best])


def thinned(template: Template) -> Template:
    """Return the template with every second place in both directions, for searching."""
    n = round(len(template.places) ** 0.5)
    keep = np.zeros((n, n), bool)
    keep[::2, ::2] = True
    kept = keep.ravel()
    flat, _, _ = normalised(template.values[None, kept], np.ones((1, int(kept.sum())), np.float32))
    return Template(template.places[kept], flat[0], template.steps[:, :0])
