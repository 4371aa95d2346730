"""Masks of objects, told from their ground by their colours, within a rectangle or under rough paint.

By GrabCut (C. Rother, V. Kolmogorov and A. Blake 2004).
"""

import cv2
import numpy as np

from core.arrays import Bools, Bytes, InputError, Ints, Points, Singles
from core.imaging.image import Image
from core.imaging.proxy import proxy, scale_for
from core.progress import Job, Progress

PIXELS = 150_000
"""Objects are cut out in pictures of so many pixels."""
ROUNDS, LEARNING_ROUNDS = 5, 2
NEAR, FAR = 8.0, 30.0
"""An object ends so near what is painted as half the width of that, but within these bounds, in pixels."""
CORE = 0.7
"""What is painted belongs to the object for certain at this share of that distance from its edge."""
LEAST_PART = 0.02
"""Parts of an object, and holes in it, that are smaller, as shares of what is painted, are taken for noise."""
LEAST_KEPT = 0.5
"""Share of what is painted that an object takes up at least."""
RIM = 0.05
"""Samples of ground along the picture's border reach so far into it, as a share of its shorter side."""
GROWS = 1.03
"""Times as large as a part of it an object is at least, where there is more of it."""


def object_within(image: Image, low: Points, high: Points, ground: Singles | None = None) -> Job[Bytes]:
    """Return the mask (H, W), 0 to 255, of the object within a rectangle from `low` to `high` (2,).

    Where that reaches the picture's border it may hold all there is of a part of the ground, such as the sky, and no
    ground beside it has those colours. Samples are then taken from inside: how much every place is `ground` (h, w), 0
    to 1, says which. Raises `InputError` where the rectangle holds too little, or everything.
    """
    scale = scale_for(image, PIXELS)
    picture = proxy(image, scale)
    limit = np.array(picture.shape[1::-1]) - 1
    left, top = np.clip(np.floor(low * scale), 0, limit).astype(int).tolist()
    right, bottom = np.clip(np.ceil(high * scale), 0, limit).astype(int).tolist()
    if right - left < 4 or bottom - top < 4:
        raise InputError("the rectangle is too small to hold an object")
    labels = np.full(picture.shape[:2], cv2.GC_BGD, np.uint8)
    labels[top : bottom + 1, left : right + 1] = cv2.GC_PR_FGD
    certain = np.zeros(labels.shape, bool)
    if ground is not None:
        box = (left + right) / 2, (top + bottom) / 2, (right - left) / 2, (bottom - top) / 2
        certain = _sample_ground(labels, box, ground)
    if (labels == cv2.GC_PR_FGD).all():
        raise InputError("the rectangle leaves no ground around the object")
    inside = yield from _cut(picture, labels.copy(), certain)
    if certain.any() and not inside.any():  # what was taken for certain is of the object itself
        inside = yield from _cut(picture, labels)
    return _enlarge(inside, image)


def _sample_ground(labels: Bytes, box: tuple[float, ...], ground: Singles) -> Bools:
    """Label what of a box is probably ground by where it lies (h, w), and return what is so for certain at first.

    That speaks for ground along the picture's border, where it is more `ground` than not, and in the corners of the
    box, outside the ellipse in it. Where both do it is certain. The box is given by its centre and half its sides.
    """
    y, x = np.ogrid[: labels.shape[0], : labels.shape[1]]
    in_corner = ((x - box[0]) / box[2]) ** 2 + ((y - box[1]) / box[3]) ** 2 > 1
    rim = max(round(RIM * min(labels.shape)), 1)
    at_border = cv2.resize(ground, labels.shape[::-1]) > 0.5
    at_border[rim:-rim, rim:-rim] = False
    inside = labels == cv2.GC_PR_FGD
    if not (inside & ~in_corner & ~at_border).any():
        at_border[:] = False  # a narrow box along the border
    labels[inside & (in_corner | at_border)] = cv2.GC_PR_BGD
    return np.asarray(inside & in_corner & at_border)


def object_under(image: Image, painted: Bytes, *, may_be_far: bool = False) -> Job[Bytes]:
    """Return the mask (H, W), 0 to 255, of the objects over which somebody has painted (H, W) roughly.

    What is far from the paint is ground, for certain unless an object `may_be_far` from what is a guess only. Raises
    `InputError` where nothing, or too much, is painted, and where no object stands out.
    """
    scale = scale_for(image, PIXELS)
    picture = proxy(image, scale)
    size = picture.shape[1::-1]
    marked = np.asarray(cv2.resize(painted, size, interpolation=cv2.INTER_AREA)) > 127
    if not marked.any():
        raise InputError("paint over an object first, roughly")
    far = cv2.GC_PR_BGD if may_be_far else cv2.GC_BGD
    labels = _labels(marked, far)
    if not (labels == far).any():
        raise InputError("too much is painted: no ground is left around the object")
    inside = yield from _cut(picture, labels)
    inside = _without_noise(inside, marked)
    if (inside & marked).sum() < LEAST_KEPT * marked.sum():
        raise InputError("what is painted looks like what is around it: no object was found")
    return _enlarge(inside, image)


def whole_object(image: Image, known: Bools) -> Job[Bools]:
    """Return where (H, W) an object is of which a part (H, W) is known, however far that reaches.

    What is far from the known part is its ground to begin with, but none for certain: it may have the object's colours.
    Raises `InputError` where hardly more stands out.
    """
    try:
        inside = known | ((yield from object_under(image, as_bytes(known), may_be_far=True)) > 127)
    except InputError:  # It does not stand out from its ground, or there is no ground.
        inside = known
    if inside.sum() < GROWS * known.sum():
        raise InputError("no more stands out from the ground than is found already")
    return inside


def as_bytes(inside: Bools) -> Bytes:
    """Return a mask (H, W), 0 and 255."""
    return np.where(inside, 255, 0).astype(np.uint8)


def _labels(marked: Bools, far: int) -> Bytes:
    """Return for GrabCut what is object or ground (h, w), for certain or probably, by what is painted (h, w)."""
    depth = cv2.distanceTransform(marked.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
    away, nearest = cv2.distanceTransformWithLabels((~marked).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
    nearest_part: Ints = np.asarray(nearest, np.int64)
    half_widths = np.zeros(nearest_part.max() + 1)
    np.maximum.at(half_widths, nearest_part[marked], depth[marked])
    half_width = np.minimum(half_widths, FAR)[nearest_part]
    labels = np.full(marked.shape, far, np.uint8)
    labels[away <= np.maximum(half_width, NEAR)] = cv2.GC_PR_BGD
    labels[marked] = cv2.GC_PR_FGD
    labels[marked & (depth >= CORE * half_width)] = cv2.GC_FGD
    return labels


def _cut(picture: Bytes, labels: Bytes, ground: Bools | None = None) -> Job[Bools]:
    """Return which pixels (h, w) belong to the object, by labels of GrabCut's, which are changed.

    What is `ground` (h, w) is so for certain while the colours of both are learnt, and only probably from then on.
    """
    back, front = np.zeros((1, 65)), np.zeros((1, 65))
    cv2.setRNGSeed(0)
    for round_number in range(ROUNDS):
        yield Progress(round_number / ROUNDS, "cutting out")
        if ground is not None and round_number in (0, LEARNING_ROUNDS):
            labels[ground] = cv2.GC_PR_BGD if round_number else cv2.GC_BGD
        mode = cv2.GC_INIT_WITH_MASK if round_number == 0 else cv2.GC_EVAL
        cv2.grabCut(picture, labels, None, back, front, 1, mode)  # type: ignore[call-overload]  # no rectangle
    return np.isin(labels, (cv2.GC_FGD, cv2.GC_PR_FGD))


def _without_noise(inside: Bools, marked: Bools) -> Bools:
    """Leave out small parts of an object (h, w), and fill small holes, measured by what is painted (h, w)."""
    least = LEAST_PART * marked.sum()
    for side, neighbours in ((True, 8), (False, 4)):
        is_side = (inside == side).astype(np.uint8)
        _, pieces, found, _ = cv2.connectedComponentsWithStats(is_side, connectivity=neighbours)
        small = found[:, cv2.CC_STAT_AREA] < least
        small[0] = False
        inside = inside ^ small[pieces]
    return inside


def _enlarge(inside: Bools, image: Image) -> Bytes:
    """Return a mask as large as the picture, soft where it is enlarged."""
    values = inside.astype(np.uint8) * 255
    return np.asarray(cv2.resize(values, image.size_px, interpolation=cv2.INTER_LINEAR), np.uint8)
