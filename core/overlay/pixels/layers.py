"""What the pieces of a registered cloth put at every pixel of the photo, and where the cloth ends."""

import cv2
import numpy as np

from core.arrays import Bools, Singles
from core.overlay.filters.bands import in_bands
from core.overlay.filters.shrinking import scale_between
from core.overlay.mesh import ClothMesh, around
from core.overlay.pixels.extension import Layers
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.region import LIMIT, clean, misfit, ring, without_specks
from core.overlay.registration.registration import LEAST_SHADING, ClothState

LENIENCE = 1.6
"""Times the limit that a misfit may have in the middle of a piece."""
GLARE = 1.8
"""Brightness that the texel's brightest colour may have, over the photo's white: plain ground in more light than that
is not this cloth's."""
LEAST_PART = (2.0, 0.5)
"""Least area of a part of a piece, in lattice steps; the second where the cloth shows few texels."""


def explained(cloth: FittedCloth, found: Fit, pieces: list[ClothState]) -> list[Bools]:
    """Return the pixels (H, W) that each piece explains, as seen by the fit; they do not overlap.

    Every piece reaches a quarter of a lattice step past its cells; of two that explain a pixel the better one has it.
    """
    past, mesh = cloth.quarter_step, cloth.mesh
    best, owner = np.full(cloth.valid.shape, LIMIT), np.full(cloth.valid.shape, -1)
    brightest = float(np.percentile(found.texel.pixels, 99.5))
    for number, piece in enumerate(pieces):
        box = mesh.box_of(piece.cells, past + round(2 * cloth.sigma_px / mesh.cell))
        at, valid = mesh.smooth_to_pixels(piece.values, box), cloth.valid[box]
        rho = np.maximum(at[..., 2], LEAST_SHADING)
        modelled = rho[..., None] * found.texel(at[..., :2])
        strict, mild = misfit(cloth.photo[box], modelled, rho, valid, found.tolerance, cloth.sigma_px / 2)
        # At the border a pattern that correlates may lie on half of a neighbourhood only; amid cloth is cloth.
        whole = without_specks(piece.cells, round(LEAST_PART[cloth.few] * (cloth.step_px / mesh.cell) ** 2))
        core = cv2.erode(np.pad(whole, 1, mode="edge").astype(np.uint8), np.ones((3, 3), np.uint8))[1:-1, 1:-1]
        bad = np.where(mesh.pixels_of(core > 0)[box], mild / LENIENCE, strict)
        near = mesh.pixels_of(whole | ring(whole, np.ones_like(whole), past))[box] & valid
        near &= rho * brightest < GLARE
        better = clean(near & (bad < best[box]), cloth.sigma_px) & near
        owner[box][better], best[box][better] = number, bad[better]
    return [np.asarray(owner == number, np.bool_) for number in range(len(pieces))]


def painted(mesh: ClothMesh, pieces: list[ClothState], masks: list[Bools], valid: Bools) -> Layers:
    """Return coordinates (H, W, 2) and shading (H, W) of the pieces' pixels, NaN elsewhere."""
    layers = np.full((*valid.shape, 2), np.nan, np.float32), np.full(valid.shape, np.nan, np.float32)
    paint(layers, mesh, pieces, masks, valid)
    return layers


def paint(layers: Layers, mesh: ClothMesh, pieces: list[ClothState], masks: list[Bools], valid: Bools) -> None:
    """Put what `painted` returns where the layers have nothing yet."""
    for piece, mask in zip(pieces, masks, strict=True):
        inside = mask & valid & np.isnan(layers[1])
        box = around(inside)
        paint_piece((layers[0][box], layers[1][box]), mesh, piece, inside[box], box)


def paint_piece(layers: Layers, mesh: ClothMesh, piece: ClothState, inside: Bools, box: tuple[slice, slice]) -> None:
    """Put a piece's coordinates and shading on the pixels (h, w) `inside` a box of the picture."""
    (uv, shading), (rows, columns) = layers, box

    def draw(_first: int, top: int, bottom: int, _last: int) -> None:
        at = mesh.smooth_to_pixels(piece.values, (slice(rows.start + top, rows.start + bottom), columns))
        part, own = slice(top, bottom), inside[top:bottom]
        np.copyto(uv[part], at[..., :2], "same_kind", where=own[..., None])
        np.copyto(shading[part], np.maximum(at[..., 2], LEAST_SHADING), "same_kind", where=own)

    in_bands(draw, inside.shape)


def spread_mask(mask: Bools, shape: tuple[int, ...]) -> Bools:
    """Return a mask of a smaller picture at the `shape` (H, W) of a larger one, its outline smooth."""
    return np.asarray(spread_plane(mask.astype(np.float32), shape) > 0.5, np.bool_)


def spread_plane(plane: Singles, shape: tuple[int, ...]) -> Singles:
    """Return a plane (h, w) or (h, w, C) of a smaller picture at the `shape` (H, W), linear between its pixels."""
    scale = scale_between(shape[0], len(plane))
    size = plane.shape[1] * scale, plane.shape[0] * scale
    return np.asarray(cv2.resize(plane, size, interpolation=cv2.INTER_LINEAR)[: shape[0], : shape[1]], np.float32)
