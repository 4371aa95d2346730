"""Where on the canvas of an earlier frame one finds what the present frame shows."""

import cv2
import numpy as np

from app.render.scene import CanvasScene
from app.render.sources.source import Box
from core.arrays import Bools, Bytes, Floats, Points, Singles

STEPS = 8
"""Newton's steps towards a place, from where it lies in the present frame."""
NEAR_PX = 1.0
"""In framebuffer pixels: what was seen farther off is not found."""


def find_places(scene: CanvasScene, before: CanvasScene, part: Box) -> Points | None:
    """Return where what lies at the nodes of `scene` lay in `before` (R, C, 2), in framebuffer pixels.

    One of the two maps that make a scene has to be the same. None where something in `part` was not seen then, and for
    marks that tell of the map, which are to be drawn anew.
    """
    if scene.marks.heat is not None or not _same(scene.folded, before.folded) or scene.mask is not before.mask:
        return None
    if not _same(scene.owners, before.owners):
        return None
    now, then, here = scene.plain.rest, before.plain.rest, scene.in_framebuffer(scene.warped)
    low, high = _seen(before)
    needed = _between(here, np.maximum(part[:2], low), np.minimum(part[2:], high))
    needed = np.asarray(cv2.dilate(np.asarray(needed, np.uint8), np.ones((3, 3), np.uint8)) > 0)
    if now is then:
        places = before.in_framebuffer(before.warped)
    elif scene.warped is before.warped:
        found, off = _find_shown(then, now, scene.warped)
        if (off[needed] * (scene.view.zoom * scene.pixel_ratio) > NEAR_PX).any():
            return None
        places = before.in_framebuffer(found)
    else:
        return None
    shown = places[needed]
    return places if _between(shown, low, high).all() else None


def _between(points: Points, low: Points, high: Points) -> Bools:
    """Return which points (..., 2) lie between two corners (2,)."""
    x, y = points[..., 0], points[..., 1]
    return np.asarray((x >= low[0]) & (y >= low[1]) & (x <= high[0]) & (y <= high[1]))


def _seen(scene: CanvasScene) -> tuple[Points, Points]:
    """Return the first and the last framebuffer pixel (2,) that show the result."""
    size = np.rint(np.multiply(scene.view.size, scene.pixel_ratio))
    return np.array([scene.divider(int(size[0])), 0.0]) - 0.5, size - 0.5


def _find_shown(then: Points, now: Points, nodes: Points) -> tuple[Points, Floats]:
    """Return where the places `now` (R, C, 2) lie on a regular grid of `nodes` that has its nodes at places `then`.

    And how far off the places found there are (R, C).
    """
    corner, cell = nodes[0, 0], nodes[1, 1] - nodes[0, 0]
    slopes = np.stack([part for axis in (1, 0) for part in np.moveaxis(np.gradient(then, axis=axis), -1, 0)], axis=-1)
    table = np.concatenate([then, slopes], axis=-1).astype(np.float32)
    share = ((nodes - corner) / cell).astype(np.float32)
    wanted = now.astype(np.float32)
    for _ in range(STEPS):
        off, (xx, xy, yx, yy) = wanted - _read(table[..., :2], share), np.moveaxis(_read(table[..., 2:], share), -1, 0)
        area = xx * yy - xy * yx
        area = np.where(np.abs(area) < 1e-3, np.inf, area)
        step = np.stack([yy * off[..., 0] - yx * off[..., 1], xx * off[..., 1] - xy * off[..., 0]], axis=-1)
        share = share + np.clip(step / area[..., None], -4, 4)
    off = np.linalg.norm(wanted - _read(table[..., :2], share), axis=-1)
    return np.asarray(share, float) * cell + corner, np.asarray(off, float)


def _read(table: Singles, share: Singles) -> Singles:
    """Return the values of `table` (R, C, k) at fractions of its columns and rows (R, C, 2)."""
    return np.asarray(cv2.remap(table, share[..., 0], share[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE))


def _same(one: Bools | Bytes | None, other: Bools | Bytes | None) -> bool:
    return one is other or (one is not None and other is not None and np.array_equal(one, other))
