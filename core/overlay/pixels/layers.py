"""What the pieces of a registered cloth put at every pixel of the photo, and where the cloth ends."""

import cv2
import numpy as np

from core.arrays import Bools
from core.overlay.filters.bands import in_bands
from core.overlay.mesh import ClothMesh, around
from core.overlay.pixels.extension import Layers
from core.overlay.registration.registration import LEAST_SHADING, ClothState


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


def spread_mask(mask: Bools, shape: tuple[int, ...]) -> Bools:
    """Return a mask of a smaller picture at the `shape` (H, W) of a larger one, its outline smooth."""
    scale = -(-shape[0] // mask.shape[0])
    wide = (mask.shape[1] * scale, mask.shape[0] * scale)
    soft = cv2.resize(mask.astype(np.float32), wide, interpolation=cv2.INTER_LINEAR)
    return np.asarray(soft[: shape[0], : shape[1]] > 0.5, np.bool_)
