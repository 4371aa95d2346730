"""The vectors of a lattice from how far apart alike keypoints lie: votes of pairs, a Hough transform [Ballard 1981].

Where a pattern repeats, the vectors between keypoints that look alike gather at those of its lattice, however large a
texel is and however few of them are seen. Folds and perspective change a vector in proportion to its length, so votes
are counted over its direction and the logarithm of its length, and compared with those for vectors around it.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from operator import itemgetter

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.overlay.detection.basis import keep_distinct, reduce, spans
from core.overlay.detection.sift import detect_keypoints
from core.overlay.neighbours import STEPS

ALIKE = 0.5
"""Most distance of alike descriptors."""
SAME_SIZE = 1.4
"""Most ratio of the sizes of alike keypoints."""
BLOCK_PX = 16
"""Pairs of keypoints that both lie so close are of one motif, and one vote."""
BIN = 0.02
"""Side of a bin: radians, and natural logarithm of a length."""
WIDTH, AROUND = 0.05, 0.3
"""Widths of the Gaussian windows in which votes are counted, and over which their usual number is taken."""
PEAKS = 30
LIKELY, SURE = 12.0, 20.0
"""Standard deviations by which the votes for a lattice surpass the usual number, for it to be tried, and to be certain;
for either of its directions half of the former, since neighbouring votes are of the same motif. Large prints and
tartans have 15 to 80; of the pictures to refuse one has 21, and shows too few texels, the others 11 at most. In photos
that are enlarged first the former have 21 to 80, and the latter, but for those that show too few texels, 18 at most."""


@dataclass(frozen=True)
class Pairs:
    """Alike keypoints: places (n, 2), and the rows (m,) of the first and second of each pair."""

    points: Points
    first: Ints
    second: Ints

    @property
    def vectors(self) -> Points:
        """From the first to the second (m, 2), pixels."""
        return self.points[self.second] - self.points[self.first]


@dataclass(frozen=True)
class Votes:
    """Votes for vectors by bins: rows of length, from `least_px` on, columns of direction, 0 to pi."""

    seen: Singles
    usual: Singles
    least_px: float

    @cached_property
    def surplus(self) -> Singles:
        """Standard deviations over the usual number."""
        return surplus(self.seen, self.usual)

    def vector(self, row: int, column: int) -> Points:
        """Return the vector (2,) in the middle of a bin, pixels."""
        angle, length = (column + 0.5) / self.seen.shape[1] * np.pi, self.least_px * np.exp((row + 0.5) * BIN)
        return np.array([length * np.cos(angle), length * np.sin(angle)])

    def near(self, vector: Points) -> Floats:
        """Return the votes and their usual number (2,) at the best bin within a window's width of a vector."""
        row = int(np.log(float(np.linalg.norm(vector)) / self.least_px) / BIN)
        column = int(np.arctan2(vector[1], vector[0]) % np.pi / np.pi * self.seen.shape[1])
        reach = round(WIDTH / BIN)
        if not 0 <= row < len(self.seen):
            return np.zeros(2)
        rows = np.arange(max(row - reach, 0), min(row + reach + 1, len(self.seen)))
        spot = np.ix_(rows, np.arange(column - reach, column + reach + 1) % self.seen.shape[1])
        best = self.surplus[spot].argmax()
        return np.array([self.seen[spot].flat[best], self.usual[spot].flat[best]], np.float64)


def surplus(seen: Singles, usual: Singles) -> Singles:
    """Return by how many standard deviations votes surpass their usual number; one vote may always be chance."""
    return np.asarray((seen - usual) / np.sqrt(usual + 1), np.float32)


def find_alike(image: Singles, valid: Bools, least_px: float, *, least_size_px: float = 0.0) -> Pairs:
    """Return the pairs of alike keypoints of a flattened `image` (H, W, 3), `least_px` apart or more.

    They are not so far apart that the cloth could not show the vector between them twice. Keypoints are of a diameter
    of `least_size_px` or more.
    """
    keypoints = detect_keypoints(image, valid, upright=True)
    keypoints = keypoints[keypoints.sizes >= least_size_px]
    points, sizes, roots = keypoints.points, keypoints.sizes, keypoints.descriptors
    alike = np.triu(2 - 2 * roots @ roots.T < ALIKE**2, 1)
    first, second = np.nonzero(alike)
    x, y = np.ascontiguousarray(points.T)
    away = np.sqrt((x[second] - x[first]) ** 2 + (y[second] - y[first]) ** 2)
    most_px = float(np.linalg.norm(np.ptp(np.nonzero(valid), axis=1))) / 2 if valid.any() else 0.0
    kept = (away > least_px) & (away < most_px) & (np.abs(np.log(sizes[second] / sizes[first])) < np.log(SAME_SIZE))
    return Pairs(points, first[kept], second[kept])


def count_votes(pairs: Pairs, least_px: float) -> Votes:
    """Return the votes of pairs for vectors of `least_px` and more."""
    places = (pairs.points // BLOCK_PX).astype(np.int64)
    block = places @ np.array([1, int(places.max(initial=0)) + 1])
    vectors = first_of_each(pairs, block, int(block.max(initial=0)) + 1).vectors
    rows = (np.log(np.linalg.norm(vectors, axis=1) / least_px) / BIN).astype(np.int64)
    shape = int(rows.max(initial=0)) + 1, round(np.pi / BIN)
    columns = (np.arctan2(vectors[:, 1], vectors[:, 0]) % np.pi / np.pi * shape[1]).astype(np.int64) % shape[1]
    votes = np.zeros(shape, np.float32)
    np.add.at(votes, (rows, columns), 1)
    window = 2 * np.pi * (WIDTH / BIN) ** 2
    return Votes(window * blurred(votes, WIDTH / BIN), window * blurred(votes, AROUND / BIN), least_px)


def first_of_each(pairs: Pairs, block: Ints, count: int) -> Pairs:
    """Return the first pair of every two of `count` blocks, where keypoints (n,) lie in these blocks."""
    ends = block[pairs.first] * count + block[pairs.second]
    first = np.full(count**2, -1, np.int32)
    # Of several values for one place the last one stays.
    first[ends[::-1]] = np.arange(len(ends), dtype=np.int32)[::-1]
    kept = first[first >= 0]
    return Pairs(pairs.points, pairs.first[kept], pairs.second[kept])


def blurred(votes: Singles, sigma: float) -> Singles:
    """Return a Gaussian blur of votes by length and direction; opposite directions are the same."""
    reach = min(round(4 * sigma), votes.shape[1])
    padded = np.pad(np.pad(votes, ((0, 0), (reach, reach)), mode="wrap"), ((reach, reach), (0, 0)))
    return np.asarray(cv2.GaussianBlur(padded, (0, 0), sigma)[reach:-reach, reach:-reach], np.float32)


def find_bases(votes: Votes) -> list[tuple[float, Floats]]:
    """Return the vectors (2, 2), columns, of distinct lattices that are likely to repeat, and how sure each is.

    That is the surplus of their votes, and the surest comes first.
    """
    likely: list[tuple[float, Floats]] = []
    for a, b in combinations(find_peaks(votes), 2):
        basis = np.stack([a, b], -1)
        if not spans(basis):
            continue
        basis = reduce(basis)
        counts = np.array([votes.near(basis @ step) for step in STEPS], np.float32)
        whole, *each = (surplus(*counts[used].sum(0)) for used in (STEPS.any(1), STEPS[:, 0] != 0, STEPS[:, 1] != 0))
        if whole > LIKELY and min(each) > LIKELY / 2:
            likely.append((float(whole), basis))
    likely.sort(key=itemgetter(0), reverse=True)
    kept = {id(basis) for basis in keep_distinct(basis for _, basis in likely)}
    return [(sure, basis) for sure, basis in likely if id(basis) in kept]


def find_peaks(votes: Votes) -> list[Points]:
    """Return the vectors that votes surpass their usual number most for."""
    over, reach = votes.surplus, round(2 * WIDTH / BIN)
    highest = cv2.dilate(np.pad(over, ((0, 0), (reach, reach)), mode="wrap"), np.ones((2 * reach + 1, 2 * reach + 1)))
    rows, columns = np.nonzero((over == highest[:, reach:-reach]) & (over > 1))
    order = np.argsort(-over[rows, columns])[:PEAKS]
    return [
        votes.vector(row, column) for row, column in zip(rows[order].tolist(), columns[order].tolist(), strict=True)
    ]
