"""Perspective: maps of the plane that keep straight lines straight.

    p' = (H00 x + H01 y + H02, H10 x + H11 y + H12) / (H20 x + H21 y + 1)

They never fold where the denominator stays positive, which it does on a rectangle that goes to a convex quadrilateral.
"""

import numpy as np

from core.arrays import Floats, InputError, Points
from core.warps.shapes import Amount, Pair

FRAME = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""Corners of the unit frame, clockwise from the top left."""
CORNERS = ("top-left", "top-right", "bottom-right", "bottom-left")


def homography(source: Points, target: Points) -> Floats:
    """Return the 3x3 matrix that takes the four points `source` to `target`, both (4, 2)."""
    (x, y), (u, v) = source.T, target.T
    zero, one = np.zeros(4), np.ones(4)
    # u (h6 x + h7 y + 1) = h0 x + h1 y + h2, and the same for v.
    rows = np.concatenate(
        [
            np.column_stack([x, y, one, zero, zero, zero, -u * x, -u * y]),
            np.column_stack([zero, zero, zero, x, y, one, -v * x, -v * y]),
        ]
    )
    entries = np.linalg.solve(rows, np.concatenate([u, v]))
    return np.append(entries, 1.0).reshape(3, 3)


def project(matrix: Floats, x: Floats, y: Floats) -> Pair:
    """Apply a 3x3 projective matrix."""
    weight = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
    across = (matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2]) / weight
    return across, (matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2]) / weight


def is_convex(corners: Points) -> bool:
    """Return whether the quadrilateral (4, 2) is convex and turns as `FRAME` does."""
    ahead = np.roll(corners, -1, axis=0) - corners
    behind = np.roll(corners, 1, axis=0) - corners
    return bool((ahead[:, 0] * behind[:, 1] - ahead[:, 1] * behind[:, 0] > 1e-9).all())


def perspective(s: Floats, t: Floats, amount: Amount) -> Pair:
    """Move the four corners; bending narrows the upper side (below 0 the lower) by up to one half.

    The settings move a corner by per cent of the width and the height. Raises `InputError` if they leave no convex
    quadrilateral.
    """
    corners = FRAME.copy()
    for corner, name in zip(corners, CORNERS, strict=True):
        corner += [amount.settings[f"{name}-{axis}"] / 50 for axis in "xy"]
    rows = [0, 1] if amount.bend > 0 else [2, 3]
    left, right = sorted(rows, key=lambda i: FRAME[i, 0])
    corners[left, 0] += abs(amount.bend) / 2
    corners[right, 0] -= abs(amount.bend) / 2
    if not is_convex(corners):
        raise InputError("perspective: the four corners do not form a convex quadrilateral")
    return project(homography(FRAME, corners), s, t)


def distortion(horizontal: float, vertical: float) -> Floats:
    """Return the 3x3 matrix of the two distortions, each -1 to 1, on the unit frame.

    Horizontal distortion enlarges the right side to 1 + d and shrinks the left to 1 - d, d = horizontal / 2, as if the
    picture were turned about its upright axis; the width stays. Vertical distortion does so to the lower and the upper
    side, on the box around what the first one left. The denominators are at least 1 - |d| and 1 - |e|.
    """
    d, e = horizontal / 2, vertical / 2
    # s' = (s - d) / (1 - d s) keeps -1 and 1; t' = t (1 - d²) / (1 - d s) is t (1 + d) at s = 1, t (1 - d) at s = -1.
    across = np.array([[1, 0, -d], [0, 1 - d * d, 0], [-d, 0, 1]])
    down = np.array([[1 - e * e, 0, 0], [0, 1, -e], [0, -e, 1]])
    box = np.diag([1, 1 / (1 + abs(d)), 1])
    matrix: Floats = np.linalg.inv(box) @ down @ box @ across
    return matrix
