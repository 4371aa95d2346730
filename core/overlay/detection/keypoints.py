"""Lattice vectors from keypoints that look alike (NRT sec. 3.1).

SIFT descriptors are grouped by mean shift; the points of a group repeat with the pattern. Around a point near the
group's middle, of all pairs of vectors to its eight nearest neighbours the most perpendicular one is taken.
"""

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.overlay.detection.basis import reduce
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.lattice import LEAST_VERTICES
from core.overlay.detection.sift import grey_levels

BANDWIDTH = 0.55
"""Radius of the flat kernel, over the length of a descriptor."""
STARTS = 200
"""Most descriptors from which a mean shift starts; the rest join the modes that these lead to."""
SUPPORT = 0.6
"""Of every proposal: keypoints come without a correlation, and with a middling one it is growth that decides."""


def alike_keypoints(image: Singles, valid: Bools, rng: "np.random.Generator", *, groups: int = 6) -> list[Points]:
    """Return the largest groups of keypoints (n, 2) that look alike in a flattened `image` (H, W, 3)."""
    points, descriptors = detect(image, valid)
    if len(points) < LEAST_VERTICES:
        return []
    labels = cluster(descriptors, rng)
    members = [points[labels == label] for label in np.argsort(-np.bincount(labels))[:groups]]
    return [group for group in members if len(group) >= LEAST_VERTICES]


def propose_from_keypoints(groups: list[Points]) -> list[Proposal]:
    """Return the proposals of groups of keypoints that look alike, the largest first."""
    return [proposal for group in groups for proposal in vectors_at(group)]


def detect(image: Singles, valid: Bools) -> tuple[Points, Floats]:
    """Return SIFT keypoints (n, 2) and their descriptors (n, 128) of length one."""
    keypoints, descriptors = cv2.SIFT_create(nfeatures=3000, contrastThreshold=0.03).detectAndCompute(  # type: ignore[attr-defined]
        grey_levels(image, valid), valid.astype(np.uint8)
    )
    if descriptors is None:
        return np.empty((0, 2)), np.empty((0, 128))
    points = np.array([k.pt for k in keypoints], np.float64)
    lengths = np.linalg.norm(descriptors, axis=1, keepdims=True)
    return points, np.asarray(descriptors / np.maximum(lengths, 1e-9), np.float64)


def cluster(descriptors: Floats, rng: "np.random.Generator", *, rounds: int = 12) -> Ints:
    """Return the group (n,) of each descriptor by mean shift with a flat kernel, seeded at up to `STARTS` of them."""
    points = descriptors.astype(np.float32)
    modes = points[rng.permutation(len(points))[:STARTS]]
    for _ in range(rounds):
        # |a - b|² = 2 - 2 a·b does not hold for the modes, which are means: their own lengths stay in.
        near = (distances(modes, points) < BANDWIDTH**2).astype(np.float32)
        moved = near @ points / np.maximum(near.sum(1), 1)[:, None]
        still = float(np.abs(moved - modes).max()) < 1e-3
        modes = moved
        if still:
            break
    modes = distinct(modes, (distances(modes, points) < BANDWIDTH**2).sum(1))
    return np.asarray(distances(points, modes).argmin(1), np.int64)


def distances(a: Singles, b: Singles) -> Singles:
    """Return squared distances (n, m)."""
    return np.asarray((a**2).sum(1)[:, None] - 2 * a @ b.T + (b**2).sum(1), np.float32)


def distinct(modes: Singles, sizes: Ints) -> Singles:
    """Return one of every set of modes within half a bandwidth of each other, the fullest first."""
    kept: list[Singles] = []
    for k in np.argsort(-sizes):
        if not kept or distances(modes[k][None], np.array(kept)).min() > (BANDWIDTH / 2) ** 2:
            kept.append(modes[k])
    return np.array(kept, np.float32)


def vectors_at(members: Points, *, places: int = 2) -> list[Proposal]:
    """Return the most perpendicular pair of vectors to the eight nearest neighbours of points near the middle."""
    middle = np.median(members, axis=0)
    found: list[Proposal] = []
    for point in members[np.argsort(np.linalg.norm(members - middle, axis=1))[:places]]:
        away = np.linalg.norm(members - point, axis=1)
        nearest = np.argsort(away, kind="stable")[1:9]
        near, lengths = members[nearest] - point, away[nearest]
        near, lengths = near[lengths > 4], lengths[lengths > 4]
        if len(near) < 2:
            continue
        cosine = np.abs(near @ near.T) / np.outer(lengths, lengths)
        i, j = divmod(int(cosine.argmin()), len(near))
        if cosine[i, j] < 0.85:
            found.append(Proposal(point, reduce(np.stack([near[i], near[j]], -1)), SUPPORT))
    return found
