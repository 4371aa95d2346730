"""Prints and tartans of large texels, and the canvas of a photo of one."""

from typing import Any

import cv2
import numpy as np

from core.arrays import Bools, Floats
from core.imaging import color
from core.imaging.image import Image
from core.overlay.detection.alignment import FlatPicture
from core.overlay.detection.seeding import flat_canvas
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.evidence import Evidence
from core.overlay.registration.registration import ClothState
from core.overlay.search.large_periods import find_large
from core.overlay.texel import Texel
from core.progress import run
from tests.core.overlay.overlay_scenes import Scene, make_scene

LARGE = np.array([[62.0, 6.0], [-5.0, 62.0]])
PRINT = np.array([[118.0, 10.0], [-12.0, 124.0]])


def sett(n: int = 96) -> Texel:
    """Return a texel of crossing stripes of several widths."""
    across, down = (np.full((n, 3), 0.85) for _ in range(2))
    for stripes, first in ((across, 0.05), (down, 0.1)):
        for width, colour in ((0.14, (0.1, 0.1, 0.3)), (0.2, (0.7, 0.2, 0.1)), (0.1, (0.2, 0.4, 0.2))):
            stripes[round(first * n) : round((first + width) * n)] = colour
            first += width + 0.12
    return Texel((across[None] + down[:, None]) / 2)


def print_of_blots(seed: int, n: int = 180) -> Texel:
    """Return a texel of scattered blots of several forms, no two alike."""
    rng = np.random.default_rng(seed)
    pixels = np.full((n, n, 3), 0.8)
    for _ in range(26):
        corners = rng.uniform(0, n, 2) + rng.uniform(4, 16, (7, 1)) * circle(7, rng.uniform(0.5, 1.0))
        colour = rng.uniform(0.1, 0.7, 3).tolist()
        for across in (-n, 0, n):
            for down in (-n, 0, n):
                cv2.fillPoly(pixels, [np.rint(corners + [across, down]).astype(np.int32)], colour)
    return Texel(pixels)


def bent_print() -> Scene:
    """Return four texels of a print, bent, so that the usual one is not quite `PRINT`."""
    return make_scene(print_of_blots(0), size=(240, 250), basis=PRINT, bend=3.0)


def usual_vectors(scene: Scene, inside: Bools | None = None) -> Floats:
    """Return the mean vectors (2, 2) of a texel, pixels, over the scene or what is `inside` (H, W) of it."""
    uv = np.where(True if inside is None else inside[..., None], scene.uv, np.nan)
    slopes = [np.nanmean(np.diff(uv, axis=axis), (0, 1)) for axis in (1, 0)]
    return np.asarray(np.linalg.inv(np.stack(slopes, -1)), np.float64)


def print_on_a_table() -> tuple[Image, Bools]:
    """Return a photo of a print of which four texels are seen, and where (H, W) it is."""
    photo = np.random.default_rng(2).normal((0.2, 0.3, 0.35), 0.01, (350, 370, 3))
    inside = np.zeros(photo.shape[:2], np.bool_)
    inside[50:290, 60:310] = True
    photo[inside] = bent_print().photo.reshape(-1, 3)
    return Image(color.quantise(np.clip(photo, 0, 1).astype(np.float32), np.uint8)), inside


def tartan(n: int = 120) -> Texel:
    """Return a texel of a wide and two thin crossing stripes on even ground, most of it."""
    stripes = np.tile([0.75, 0.19, 0.15], (n, 1))
    lines = ((0.1, 0.18, (0.12, 0.14, 0.12)), (0.55, 0.03, (0.9, 0.8, 0.3)), (0.72, 0.03, (0.9, 0.9, 0.9)))
    for first, width, colour in lines:
        stripes[round(first * n) : round((first + width) * n)] = colour
    return Texel((stripes[None] + stripes[:, None]) / 2)


def circle(count: int, squeeze: float) -> Floats:
    """Return points (count, 2) around the origin."""
    angle = 2 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angle), squeeze * np.sin(angle)], -1)


def canvas_of(photo: Floats) -> FlatPicture:
    return flat_canvas(photo, np.ones(photo.shape[:2], bool))


def painted(photo: Floats) -> FlatPicture:
    """Return the canvas of a photo that is cloth but for its outermost pixels."""
    return flat_canvas(photo, np.pad(np.ones((photo.shape[0] - 4, photo.shape[1] - 4), bool), 2))


def displaced_px(scene: Scene, cloth: FittedCloth, piece: ClothState) -> Floats:
    """Return how far (n,) the pixels of a piece are laid from where they are in a scene.

    What moves all copies alike cannot be told from the texel: places are compared with the same ones of other texels.
    """
    inside = cloth.mesh.pixels_of(piece.cells)
    steps = np.rint(np.linalg.solve(scene.basis, cloth.basis))
    off = cloth.mesh.to_pixels(piece.uv, piece.cells)[inside] @ steps.T - scene.uv[inside]
    place = np.floor(12 * (scene.uv[inside] % 1)).astype(int) @ [1, 12]
    count = np.bincount(place)
    off -= np.stack([np.bincount(place, column) / count for column in off.T], -1)[place]
    return np.asarray(np.linalg.norm(off @ scene.basis.T, axis=-1), np.float64)


def strokes(n: int = 150) -> Texel:
    """Return a texel of nine motifs of three thin strokes each."""
    rng, pixels = np.random.default_rng(0), np.full((n, n, 3), 0.25)
    for _ in range(9):
        middle, turn = rng.uniform(0, n, 2), rng.uniform(0, 2 * np.pi)
        ends = (
            circle(3, 1.0) @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]] * rng.uniform(5, 12, (3, 1))
        )
        for across in (-n, 0, n):
            for down in (-n, 0, n):
                points = np.rint(middle + [across, down] + np.insert(ends, [0, 1, 2], 0, axis=0)).astype(np.int32)
                cv2.polylines(pixels, [points], False, (0.8, 0.8, 0.75), 2)
    return Texel(pixels)


def find_likeliest(photo: Floats, canvas: FlatPicture, **known: Any) -> tuple[FittedCloth, Fit, Evidence]:
    """Return the likeliest cloth of large texels."""
    return run(find_large(photo, canvas, **known))[0]
