"""Pictures of the stages: the lattice and the mesh on the photo."""

import cv2
import numpy as np

from core.arrays import Bytes, Floats
from core.overlay.lattice import Lattice, neighbour_rows
from core.overlay.stages import Stage

LINE, DOT = (0, 255, 64), (255, 64, 0)
ZOOM = 2


def stage_picture(photo: Floats, stage: Stage) -> Bytes:
    """Return a picture (h, w, 3) of what a stage knows, on the photo (H, W, 3) it works on."""
    if stage.uv is not None:
        return coordinate_lines(photo, stage.uv)
    return lattice_lines(photo, stage.lattice) if stage.lattice is not None else levels(photo)


def lattice_lines(photo: Floats, lattice: Lattice) -> Bytes:
    """Return the photo, enlarged and dimmed, with the lattice's steps and vertices."""
    canvas = levels(enlarged(photo) * 0.7)
    at = [(round(ZOOM * float(x + 0.5)), round(ZOOM * float(y + 0.5))) for x, y in lattice.frames.points]
    for row, near in enumerate(neighbour_rows(lattice.keys)[:, :2].tolist()):
        for other in near:
            if other >= 0:
                cv2.line(canvas, at[row], at[other], LINE, 1, cv2.LINE_AA)
    for place in at:
        cv2.circle(canvas, place, 2, DOT, -1, cv2.LINE_AA)
    return canvas


def coordinate_lines(photo: Floats, uv: Floats) -> Bytes:
    """Return the photo, enlarged, dimmed outside, with lines where texture coordinates (H, W, 2) are whole."""
    size = photo.shape[1] * ZOOM, photo.shape[0] * ZOOM
    covered = np.asarray(np.isfinite(uv).all(-1), np.uint8)
    shown = cv2.resize(covered, size, interpolation=cv2.INTER_NEAREST) > 0
    fine = cv2.resize(np.nan_to_num(uv).astype(np.float32), size, interpolation=cv2.INTER_LINEAR)
    texel = np.floor(fine)
    edge = np.zeros(shown.shape, bool)
    edge[:, 1:] |= (texel[:, 1:] != texel[:, :-1]).any(-1)
    edge[1:] |= (texel[1:] != texel[:-1]).any(-1)
    out = levels(enlarged(photo) * np.where(shown, 1.0, 0.35)[..., None])
    out[edge & shown] = LINE
    return out


def enlarged(photo: Floats) -> Floats:
    """Return the photo `ZOOM` times as large."""
    size = photo.shape[1] * ZOOM, photo.shape[0] * ZOOM
    return np.asarray(cv2.resize(photo, size, interpolation=cv2.INTER_LINEAR), np.float64)


def levels(values: Floats) -> Bytes:
    """Return 0 to 1 as 0 to 255."""
    return np.rint(255 * np.clip(values, 0, 1)).astype(np.uint8)
