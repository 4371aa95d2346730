"""What the hand says about features: which points they hold, and the similarity that these ask for.

A feature with one point has its place there, and turns about it; with two or more, or a ring, it has the similarity
that is closest to them in the least-squares sense, a ring as the points that it stands for; a rigid one keeps its size,
an upright one does not turn.
One that a straight frame cuts does so as far as it can slide.
"""

from dataclasses import dataclass

import numpy as np

from core.arrays import Bools, Floats, Ints, Points
from core.grid import Grid
from core.mapping.features.limits import Limits
from core.mapping.features.similarity import Body
from core.mapping.handles.probes import RING, Probes
from core.mapping.jacobians import Complexes, as_complex
from core.mapping.tolerances import LEAST_SHARE, ROUNDING

_ONE_PLACE_PX = 0.5
"""Points of a feature closer than this say where it is, but not how it is turned."""
_SMALLEST = 0.05
"""Share of its size to which two points shrink a feature at most."""


def find_owners(index: Ints, grid: Grid, at: Points) -> Ints:
    """Return the body (k,) that holds each point of the picture (k, 2), -1 for the background.

    `index` (R, C) is the body of each node, -1 for none.
    """
    nodes, weights = grid.weights_at(at)
    bodies = index.ravel()[nodes]
    share = np.stack([np.where(bodies == bodies[:, [k]], weights, 0).sum(axis=1) for k in range(4)], axis=1)
    share[bodies < 0] = 0
    best = share.argmax(axis=1)
    found = np.take_along_axis(bodies, best[:, None], axis=1)[:, 0]
    return np.where(share.max(axis=1, initial=0) >= LEAST_SHARE, found, -1)


@dataclass(frozen=True)
class Hold:
    """The points that hold one body."""

    body: int
    points: Ints
    """Their numbers."""
    arms: Complexes
    """Where they are on the picture, from the body's centroid."""
    rings: Ints
    """Numbers of the rings around some of them."""
    radius: Floats
    """Of these."""

    @property
    def is_one_place(self) -> bool:
        """Whether they say where the body is, but not how it is turned."""
        return not self.rings.size and bool(np.abs(self.arms - self.arms[0]).max() < _ONE_PLACE_PX)

    @property
    def arm(self) -> complex:
        """The middle of the points."""
        return complex(self.arms.mean())

    def fit(self, places: Complexes, turned: Complexes, alpha: complex, limits: Limits) -> tuple[complex, complex]:
        """Return the (α, t) of the body closest to its points at `places` (k,) and its rings with α as `turned` (m,).

        α is now `alpha`.
        """
        p, q, share = self.arms - self.arms.mean(), places - places.mean(), RING * self.radius**2
        found = complex((np.vdot(p, q) + share @ turned) / (np.vdot(p, p) + share.sum()))
        if not limits.turns:
            found = complex(max(found.real, np.finfo(float).tiny))
        now = abs(alpha)
        # What has given way without handles need not come back within its limits.
        size = now if limits.fix_size else max(abs(found), _SMALLEST * now)
        size = min(max(size, min(limits.least, now)), max(limits.most, now))
        found = size * found / abs(found) if found else alpha
        return found, complex(places.mean() - found * self.arms.mean())

    def slide(
        self, places: Complexes, turned: Complexes, alpha: complex, t: complex, free: Bools, pivot: complex
    ) -> tuple[complex, complex]:
        """Return the (α, t) closest to `places` (k,), `turned` (m,) of a body with few freedoms: size, move along x, y.

        It scales about the arm `pivot`. Its size changes only where two points, or a ring, ask for it.
        """
        size, arm = free[0] and not self.is_one_place, np.sqrt(RING) * self.radius
        one, none = np.ones_like(self.arms), np.zeros(len(arm))
        columns = [
            np.concatenate([alpha * (self.arms - pivot), alpha * arm]),
            np.concatenate([one, none]),
            np.concatenate([1j * one, none]),
        ]
        open_ = [bool(size), bool(free[2]), bool(free[3])]
        rest = np.concatenate([places - (alpha * self.arms + t), (turned - alpha) * arm])
        chosen = [as_column(c) for c, is_open in zip(columns, open_, strict=True) if is_open]
        if not chosen:
            return alpha, t
        found = np.zeros(3)
        found[open_] = np.linalg.lstsq(np.stack(chosen, axis=1), as_column(rest), rcond=None)[0]
        grown = max(1 + found[0], _SMALLEST)
        return alpha * grown, t + alpha * pivot * (1 - grown) + complex(found[1], found[2])


def as_column(z: Complexes) -> Floats:
    """Return complex numbers (k,) as a real column (2 k,)."""
    return np.concatenate([z.real, z.imag])


def find_holds(bodies: list[Body], rest: Complexes, owners: Ints, probes: Probes) -> list[Hold]:
    """Return the holds of all bodies that probes with these `owners` (k,) hold; rest is (R, C)."""
    places = as_complex(probes.at)
    found = []
    for i in np.unique(owners[owners >= 0]):
        points, rings = (np.flatnonzero((owners == i) & (probes.are_rings == ringed)) for ringed in (False, True))
        middle = rest.ravel()[bodies[i].nodes].mean()
        found.append(Hold(int(i), points, places[points] - middle, rings, probes.radius[rings]))
    return found


def sample_rim(body: Body, shape: tuple[int, int], blocks: float) -> Complexes:
    """Return points (k,) spread over the rim of a body, from its centroid: of each block the furthest node of the rim.

    Blocks are squares around the centroid, `blocks` of them along the body's diameter: mirrored or turned by a right
    angle, a body has the mirrored or turned points. Nodes of the frame of the grid, of `shape`, are left out, if others
    are left.
    """
    rows, columns = shape
    row, column = np.divmod(body.nodes, columns)
    inner = (row > 0) & (column > 0) & (row < rows - 1) & (column < columns - 1)
    top, left = row.min() - 1, column.min() - 1
    own = np.zeros((row.max() - top + 2, column.max() - left + 2), bool)
    own[row - top, column - left] = True
    around = (own[row - top + down, column - left + right] for down, right in ((1, 0), (-1, 0), (0, 1), (0, -1)))
    rim = ~np.all(list(around), axis=0)
    chosen = rim & inner
    arms = body.arms[chosen if chosen.any() else slice(None)]
    side = 2 * np.abs(body.arms).max() / blocks
    block = np.stack([np.rint(arms.real / side), np.rint(arms.imag / side)], axis=1)
    number = np.unique(block, axis=0, return_inverse=True)[1].ravel()
    furthest = np.zeros(number.max() + 1)
    np.maximum.at(furthest, number, np.abs(arms))
    # Of nodes that are equally far the mean is taken.
    out = np.abs(arms) >= (1 - ROUNDING) * furthest[number]
    count = np.bincount(number[out])
    x, y = (np.bincount(number[out], part[out]) for part in (arms.real, arms.imag))
    return np.asarray((x + 1j * y) / count, np.complex128)
