"""Pictures of the stages: keypoints, seeds, the lattice and the mesh on the photo."""

import colorsys
import itertools
from collections.abc import Sequence

import cv2
import numpy as np

from core.arrays import Bytes, Floats, Points
from core.overlay.composition import finite
from core.overlay.detection.lattice import Lattice, neighbour_rows
from core.overlay.detection.stages import Stage

LINE, DOT = (0, 255, 64), (255, 64, 0)
COLOURS = [tuple(round(255 * level) for level in colorsys.hsv_to_rgb(k / 6, 1, 1)) for k in range(6)]
"""Of groups of keypoints, the largest first."""
ZOOM = 2
DIM = 0.7


def stage_picture(photo: Floats, stage: Stage) -> Bytes:
    """Return a picture (h, w, 3) of what a stage knows, on the photo (H, W, 3) it works on."""
    if stage.uv is not None:
        return coordinate_lines(photo, stage.uv)
    if stage.lattice is not None:
        return lattice_lines(photo, stage.lattice)
    return seed_boxes(photo, stage.seeds) if stage.seeds else keypoint_groups(photo, stage.groups)


def keypoint_groups(photo: Floats, groups: Sequence[Points]) -> Bytes:
    """Return the photo, enlarged and dimmed, with keypoints (n, 2), those of a group in one colour."""
    canvas = levels(enlarge(photo) * DIM)
    for points, colour in zip(groups, itertools.cycle(COLOURS)):
        for place in on_enlarged(points):
            cv2.circle(canvas, place, 3, colour, 1, cv2.LINE_AA)
    return canvas


def seed_boxes(photo: Floats, seeds: Sequence[tuple[Points, Floats]]) -> Bytes:
    """Return the photo, enlarged and dimmed, with the texel that each seed proposes, the best one's last."""
    canvas = levels(enlarge(photo) * DIM)
    for point, basis in reversed(seeds):
        across, down = basis.T / 2
        corners = on_enlarged(np.stack([point - across - down, point + across - down]))
        corners += on_enlarged(np.stack([point + across + down, point - across + down]))
        colour = DOT if point is seeds[0][0] else LINE
        cv2.polylines(canvas, [np.array(corners)], True, colour, 1, cv2.LINE_AA)
    return canvas


def lattice_lines(photo: Floats, lattice: Lattice) -> Bytes:
    """Return the photo, enlarged and dimmed, with the lattice's steps and vertices."""
    canvas = levels(enlarge(photo) * DIM)
    at = on_enlarged(lattice.frames.points)
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
    covered = finite(uv).astype(np.uint8)
    shown = cv2.resize(covered, size, interpolation=cv2.INTER_NEAREST) > 0
    fine = cv2.resize(np.nan_to_num(uv).astype(np.float32), size, interpolation=cv2.INTER_LINEAR)
    texel = np.floor(fine)
    edge = np.zeros(shown.shape, bool)
    edge[:, 1:] |= (texel[:, 1:] != texel[:, :-1]).any(-1)
    edge[1:] |= (texel[1:] != texel[:-1]).any(-1)
    out = levels(enlarge(photo) * np.where(shown, 1.0, 0.35)[..., None])
    out[edge & shown] = LINE
    return out


def on_enlarged(points: Points) -> list[tuple[int, int]]:
    """Return where points (n, 2) of the photo are in the enlarged one."""
    return [(round(ZOOM * float(x + 0.5)), round(ZOOM * float(y + 0.5))) for x, y in points]


def enlarge(photo: Floats) -> Floats:
    """Return the photo `ZOOM` times as large."""
    size = photo.shape[1] * ZOOM, photo.shape[0] * ZOOM
    return np.asarray(cv2.resize(photo, size, interpolation=cv2.INTER_LINEAR), np.float64)


def levels(values: Floats) -> Bytes:
    """Return 0 to 1 as 0 to 255."""
    return np.rint(255 * np.clip(values, 0, 1)).astype(np.uint8)
