"""Which part of the canvas a stroke of the brush, or a drag, changes: the rest of it is kept."""

from dataclasses import replace

import numpy as np

from app.render.scene import CanvasScene
from app.render.sources.source import Box
from core.arrays import Bools, Bytes, Points

MARGIN_PX = 2.0
"""What is blended reaches so far beyond its place, in pixels of the canvas."""
MASK_MARGIN_PX = 16.0
"""And so far in pixels of the picture, whose mask may be kept smaller."""
STILL_PX = 0.125
"""What moves by less, in framebuffer pixels, is not seen to move."""


def find_painted(scene: CanvasScene, before: CanvasScene | None) -> Box | None:
    """Return the framebuffer pixels outside which `scene` looks as `before`; None where that may be nowhere.

    They are known where both differ in nothing but the mask, its colours, the folded cells and the frame's right and
    lower side.
    """
    if before is None or scene.mask is None or before.mask is None or not scene.shows_same_picture(before):
        return None
    framed, marks = _box_of_frames(scene, before), _nodes_of_marks(replace(scene, frame=before.frame), before)
    if framed is None or marks is None:
        return None
    boxes = [box for box in (framed, _box_around(marks, scene)) if box[0] < box[2]]
    if not boxes:
        return 0, 0, 0, 0
    left, top, right, bottom = zip(*boxes, strict=True)
    return min(left), min(top), max(right), max(bottom)


def _box_of_frames(scene: CanvasScene, before: CanvasScene) -> Box | None:
    """Return the framebuffer pixels that are in one frame only; None where the checks in it have moved."""
    if scene.frame == before.frame:
        return 0, 0, 0, 0
    if scene.frame is None or before.frame is None or scene.frame[:2] != before.frame[:2]:
        return None
    start, ends = np.array(scene.frame[:2]), np.array([scene.frame[2:], before.frame[2:]])
    stays = ends[0] == ends[1]
    first = np.where(stays, start, ends.min(axis=0)) if stays.any() else start
    low, high = scene.in_framebuffer(np.stack([first, ends.max(axis=0)]))
    left, top = np.floor(low - MARGIN_PX).astype(int).tolist()
    right, bottom = np.ceil(high + MARGIN_PX).astype(int).tolist()
    return left, top, right, bottom


def find_moved(scene: CanvasScene, before: CanvasScene | None) -> Box | None:
    """Return the same where the map differs, too: what moves by less than `STILL_PX` looks as before.

    Of a regrown picture, what it was regrown from is compared.
    """
    if before is None:
        return None
    now, then = scene.plain, before.plain
    if not replace(scene, image=now.image).fills_same_place(replace(before, image=then.image)):
        return None
    if (
        scene.before_rest is not before.before_rest
        or now.rest.shape != then.rest.shape
        or scene.overlay is not before.overlay
    ):
        return None
    marks = _nodes_of_marks(scene, before)
    if marks is None:
        return None
    moved = _moved(now.rest, then.rest, scene) | _moved(scene.warped, before.warped, scene)
    return _box_around(_corners(_any_corner(moved | marks)), scene, before)


def _moved(now: Points, then: Points, scene: CanvasScene) -> Bools:
    """Return which nodes (R, C) are seen to move."""
    if now is then:
        return np.zeros(now.shape[:2], bool)
    far = np.abs(now - then) > STILL_PX / (scene.view.zoom * scene.pixel_ratio)
    return np.asarray(far[..., 0] | far[..., 1])


def _nodes_of_marks(scene: CanvasScene, before: CanvasScene) -> Bools | None:
    """Return the nodes (R, C) of all quads whose mask, its colour or fold differs; None where other marks differ."""
    same_shapes = _shape(scene.folded) == _shape(before.folded) and _shape(scene.owners) == _shape(before.owners)
    alike = replace(scene, mask=before.mask, folded=before.folded, owners=before.owners)
    if not (same_shapes and (scene.mask is None) == (before.mask is None) and alike.shows_same_marks(before)):
        return None
    return _nodes_of_mask(scene, before) | _nodes_of_folds(scene, before) | _nodes_of_owners(scene, before)


def _box_around(nodes: Bools, *scenes: CanvasScene) -> Box:
    """Return the framebuffer pixels that hold `nodes` (R, C) in all `scenes`, and what is blended beside them."""
    if not nodes.any():
        return 0, 0, 0, 0
    sides = [scene.warped[nodes] for scene in scenes]
    sides += [scenes[0].rest[nodes]] if scenes[0].compare == "split" else []
    # NumPy is many times slower along the short axis of points.
    corners = np.array([[choose(side[:, k]) for k in (0, 1)] for side in sides for choose in (np.min, np.max)])
    places = scenes[0].in_framebuffer(corners)
    left, top = np.floor(places.min(axis=0) - MARGIN_PX).astype(int).tolist()
    right, bottom = np.ceil(places.max(axis=0) + MARGIN_PX).astype(int).tolist()
    return left, top, right, bottom


def _nodes_of_mask(scene: CanvasScene, before: CanvasScene) -> Bools:
    """Return the nodes (R, C) of every quad in which the mask differs."""
    if scene.mask is None or scene.mask is before.mask:
        return np.zeros(scene.rest.shape[:2], bool)
    quads = np.zeros((scene.rest.shape[0] - 1, scene.rest.shape[1] - 1), bool)
    x, y = np.moveaxis(scene.rest, -1, 0)
    for (left, top, right, bottom), _ in scene.mask.changed_boxes(before.mask):
        across = _any_corner(x > left - MASK_MARGIN_PX) & _any_corner(x < right + MASK_MARGIN_PX)
        quads |= across & _any_corner(y > top - MASK_MARGIN_PX) & _any_corner(y < bottom + MASK_MARGIN_PX)
    return _corners(quads)


def _nodes_of_folds(scene: CanvasScene, before: CanvasScene) -> Bools:
    """Return the nodes (R, C) of every quad that is folded in one scene only."""
    if scene.folded is None or before.folded is None or scene.folded is before.folded:
        return np.zeros(scene.rest.shape[:2], bool)
    return _corners(scene.folded != before.folded)


def _nodes_of_owners(scene: CanvasScene, before: CanvasScene) -> Bools:
    """Return the nodes (R, C) of every quad with a corner that has another colour."""
    if scene.owners is None or before.owners is None or scene.owners is before.owners:
        return np.zeros(scene.rest.shape[:2], bool)
    return _corners(_any_corner(scene.owners != before.owners))


def _any_corner(nodes: Bools) -> Bools:
    """Return the quads (R - 1, C - 1) of which a corner is marked in `nodes` (R, C)."""
    across = nodes[:, :-1] | nodes[:, 1:]
    return np.asarray(across[:-1] | across[1:])


def _corners(quads: Bools) -> Bools:
    """Return the corners (R, C) of the marked `quads` (R - 1, C - 1)."""
    nodes = np.zeros((quads.shape[0] + 1, quads.shape[1] + 1), bool)
    for rows in (slice(None, -1), slice(1, None)):
        for columns in (slice(None, -1), slice(1, None)):
            nodes[rows, columns] |= quads
    return nodes


def _shape(folded: Bools | Bytes | None) -> tuple[int, ...] | None:
    return None if folded is None else folded.shape
