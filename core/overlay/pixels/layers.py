"""What the pieces of a registered cloth put at every pixel of the photo, and where the cloth ends."""

import cv2
import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.filters.bands import in_bands
from core.overlay.filters.distances import distance, within
from core.overlay.mesh import ClothMesh, around
from core.overlay.pixels.extension import Extension, extension_of
from core.overlay.pixels.filling import carried_on, parts_with, small_parts
from core.overlay.pixels.outline import beyond
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.constrained_registration import settle
from core.overlay.registration.region import LIMIT, clean, misfit, ring, without_specks
from core.overlay.registration.registration import LEAST_SHADING, ClothState
from core.overlay.tolerances import NEARBY_PX

Layers = tuple[Singles, Singles]
"""Texture coordinates (H, W, 2) and shading (H, W), NaN where there are none."""

LENIENCE = 1.6
"""Times the limit that a misfit may have in the middle of a piece."""
GLARE = 1.8
"""Brightness that the texel's brightest colour may have, over the photo's white: plain ground in more light than that
is not this cloth's."""
LEAST_PART = (2.0, 0.5)
"""Least area of a part of a piece, in lattice steps; the second where the cloth shows few texels."""
SCRAP = (0.5, 0.25)
"""What has so little of a texel's area, and is so much of its side away from larger parts, is no cloth."""


def explained(cloth: FittedCloth, found: Fit, pieces: list[ClothState]) -> list[Bools]:
    """Return the pixels (H, W) that each piece explains, as seen by the fit; they do not overlap.

    Every piece reaches one cell past its own; of two that explain a pixel the better one has it.
    """
    mesh, best, owner = cloth.mesh, np.full(cloth.valid.shape, LIMIT), np.full(cloth.valid.shape, -1)
    brightest = float(np.percentile(found.texel.pixels, 99.5))
    for number, piece in enumerate(pieces):
        box = mesh.box_of(piece.cells, 1 + round(2 * cloth.sigma_px / mesh.cell))
        at, valid = mesh.smooth_to_pixels(piece.values, box), cloth.valid[box]
        rho = np.maximum(at[..., 2], LEAST_SHADING)
        modelled = rho[..., None] * found.texel(at[..., :2])
        strict, mild = misfit(cloth.photo[box], modelled, rho, valid, found.tolerance, cloth.sigma_px / 2)
        # At the border a pattern that correlates may lie on half of a neighbourhood only; amid cloth is cloth.
        whole = without_specks(piece.cells, round(LEAST_PART[cloth.few] * (cloth.step_px / mesh.cell) ** 2))
        core = cv2.erode(np.pad(whole, 1, mode="edge").astype(np.uint8), np.ones((3, 3), np.uint8))[1:-1, 1:-1]
        bad = np.where(mesh.pixels_of(core > 0)[box], mild / LENIENCE, strict)
        near = mesh.pixels_of(whole | ring(whole, np.ones_like(whole), 1))[box] & valid
        near &= rho * brightest < GLARE
        better = clean(near & (bad < best[box]), cloth.sigma_px) & near
        owner[box][better], best[box][better] = number, bad[better]
    return [np.asarray(owner == number, np.bool_) for number in range(len(pieces))]


def painted(mesh: ClothMesh, pieces: list[ClothState], masks: list[Bools], valid: Bools) -> Layers:
    """Return coordinates (H, W, 2) and shading (H, W) of the pieces' pixels, NaN elsewhere.

    `masks` may be of a smaller picture than `mesh` and `valid` are.
    """
    layers = np.full((*valid.shape, 2), np.nan, np.float32), np.full(valid.shape, np.nan, np.float32)
    paint(layers, mesh, pieces, masks, valid)
    return layers


def paint(layers: Layers, mesh: ClothMesh, pieces: list[ClothState], masks: list[Bools], valid: Bools) -> None:
    """Put what `painted` returns where the layers have nothing yet."""
    for piece, mask in zip(pieces, masks, strict=True):
        inside = (mask if mask.shape == valid.shape else spread_mask(mask, valid.shape)) & valid & np.isnan(layers[1])
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


def carry_to_outline(
    layers: Layers,
    cloth: FittedCloth,
    found: Fit,
    mesh: ClothMesh,
    pieces: list[ClothState],
    masks: list[Bools],
    extension: Extension,
    photo: Floats | Singles,
) -> None:
    """Put coordinates and shading also where cloth is seen beyond the layers, up to its outline.

    Every so many pixels of `photo` (H, W, 3) are looked at as `cloth.photo` is smaller.
    """
    scale = -(-len(photo) // len(cloth.photo))
    valid = spread_mask(cloth.valid, layers[1].shape)
    few = slice(None, None, scale)
    seen: Layers = layers[0][few, few], layers[1][few, few]
    covered = np.asarray(np.isfinite(seen[1]), np.bool_)
    held, cloth_there = up_to_outline(seen, cloth, found, pieces, extension, photo[few, few].astype(np.float64))
    # What the mesh reaches has been registered; the rest has not.
    paint(layers, mesh, pieces, [mask & cloth_there for mask in held], valid)
    for piece, mine in zip(pieces, share_out(cloth_there & ~np.any(held, axis=0), masks), strict=True):
        if mine.any():
            wider, sound = carried_on(cloth.mesh, piece, mine, abs(float(np.linalg.det(cloth.basis))))
            wider = settle(cloth, found, wider, mine, covered)
            paint(layers, mesh, [wider], [mine & cloth.mesh.pixels_of(sound)], valid)
    carry_on(layers, extension, spread_mask(cloth_there, valid.shape) & valid, scale)


def up_to_outline(
    layers: Layers, cloth: FittedCloth, found: Fit, pieces: list[ClothState], extension: Extension, photo: Floats
) -> tuple[list[Bools], Bools]:
    """Return the pixels (H, W) near the layers' border that each piece's mesh reaches, and which there are cloth."""
    width = max(NEARBY_PX, cloth.sigma_px)
    uv, rho = (np.nan_to_num(layer.astype(np.float64)) for layer in layers)
    covered = np.asarray(np.isfinite(layers[1]), np.bool_)
    further = cloth.valid & ~covered & within(covered, width)
    rows, columns = np.nonzero(further)
    uv[rows, columns], rho[rows, columns] = extension.at(np.stack([columns, rows], -1).astype(np.float64))
    held = [further & cloth.mesh.pixels_of(piece.cells) for piece in pieces]
    for there, layer in zip(painted(cloth.mesh, pieces, held, cloth.valid), (uv, rho), strict=True):
        layer[np.any(held, axis=0)] = there[np.any(held, axis=0)]
    return held, beyond(photo, found.texel(uv), rho, covered, further, width, width)


def share_out(wanted: Bools, masks: list[Bools]) -> list[Bools]:
    """Return which of the wanted pixels (H, W) are nearest to each of the masks."""
    owner = np.stack([distance(mask) for mask in masks]).argmin(0)
    return [np.asarray(wanted & (owner == number), np.bool_) for number in range(len(masks))]


def carry_on(layers: Layers, extension: Extension, wanted: Bools, scale: int) -> None:
    """Put how the cloth goes on, as seen `scale` times smaller, at wanted pixels (H, W) that have nothing yet."""
    rows, columns = np.nonzero(wanted & np.isnan(layers[1]))
    places = np.stack([columns, rows], -1) / scale - (scale - 1) / (2 * scale)
    layers[0][rows, columns], layers[1][rows, columns] = extension.at(places)


def extension_from(cloth: FittedCloth, pieces: list[ClothState], masks: list[Bools]) -> Extension | None:
    """Return how the pieces' pixels go on, None if nothing of them is sound."""
    owner = np.full(cloth.valid.shape, -1)
    for number, mask in enumerate(masks):
        owner[mask] = number
    uv, rho = (layer.astype(np.float64) for layer in painted(cloth.mesh, pieces, masks, cloth.valid))
    return extension_of(uv, rho, owner, abs(float(np.linalg.det(cloth.basis))), cloth.sigma_px)


def scraps(covered: Bools, texel_px: float) -> Bools:
    """Return what of the covered pixels (H, W) is small and away from the rest; a texel has `texel_px` pixels."""
    small = small_parts(covered, SCRAP[0] * texel_px)
    near = within(covered & ~small, SCRAP[1] * np.sqrt(texel_px))
    return small & ~parts_with(near, small)


def spread_mask(mask: Bools, shape: tuple[int, ...]) -> Bools:
    """Return a mask of a smaller picture at the `shape` (H, W) of a larger one, its outline smooth."""
    scale = -(-shape[0] // mask.shape[0])
    wide = (mask.shape[1] * scale, mask.shape[0] * scale)
    soft = cv2.resize(mask.astype(np.float32), wide, interpolation=cv2.INTER_LINEAR)
    return np.asarray(soft[: shape[0], : shape[1]] > 0.5, np.bool_)
