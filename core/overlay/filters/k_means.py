"""Groups of alike values, found by k-means (Lloyd 1982), the same ones each time."""

import cv2
import numpy as np

from core.arrays import Floats, Ints, Singles


def find_groups(values: Floats | Singles, most: int) -> tuple[Ints, Singles]:
    """Return the group (n,) of each of values (n, d), and the means (k, d) of the groups, `most` at most."""
    count = min(most, len(values))
    main = np.linalg.svd(values - values.mean(0), full_matrices=False)[2][0]
    # Groups of one size along the direction of most change, to begin with.
    labels = np.empty((len(values), 1), np.int32)
    labels[np.argsort(values @ main, kind="stable"), 0] = np.arange(len(values)) * count // len(values)
    rule = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 30, 1e-4)
    found = cv2.kmeans(values.astype(np.float32), count, labels, rule, 1, cv2.KMEANS_USE_INITIAL_LABELS)
    return np.asarray(found[1].ravel(), np.int64), np.asarray(found[2], np.float32)
