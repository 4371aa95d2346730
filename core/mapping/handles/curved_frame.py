"""A frame that W bends: features that it cuts go where they fit between its nodes.

Frame nodes outside features are held by W, a feature's nodes by its similarity z = α p + t, p from their centroid.
Seen from the feature, a frame node at W lies at q = (W - t) / α. A change of the similarity, of 1 / α by the complex
share ω, moves all that is seen by ω q + σ. Of a corner between two nodes a, b of the feature and one of the frame,
twice the area,

    Im conj(b - a) (q - a + ω q + σ),

is therefore linear in (ω, σ), and so is that every such corner has some room. Of all such changes the one is taken that
moves the feature's nodes least, Σ |ω p + σ|² = |ω|² Σ |p|² + n |σ|²: a least-distance problem [Lawson and Hanson 1974,
ch. 23]. A rigid feature turns and moves only, if that is enough; an upright one never turns. What is shown while
something moves is therefore what stays.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from core.arrays import Floats, Ints
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.features.similarity import Body
from core.mapping.jacobians import Complexes
from core.mapping.tolerances import LITTLE, ROUNDING

LEAST = 0.5
"""Share of its size that a feature is to keep; where it would have to be smaller, the frame gives way beside it."""
_ROUNDS = 5
"""Times that a turn, which is linear for small angles only, is taken anew."""


@dataclass(frozen=True, eq=False)
class Cut:
    """A feature that the frame cuts, and the corners (k,) that it has with frame nodes outside features."""

    number: int
    body: Body
    a: Complexes
    b: Complexes
    """The corners' nodes in the feature, from its centroid."""
    outside: Ints
    """And on the frame; clockwise from a."""
    room: Floats
    """Twice the area that each is to have, in pixels of the picture."""

    def fit(self, w: Complexes, alpha: complex, t: complex) -> tuple[complex, complex]:
        """Return the (α, t) closest to a given one with room in every corner for W (N,).

        That is the given one, too, where there is no other, or only one that is too small.
        """
        found, place = alpha, t
        for _ in range(_ROUNDS):
            lacks, q = self._lacks(w, found, place)
            if not found or (lacks <= ROUNDING * self.room).all():
                return found, place
            change = self._change(q, lacks)
            if change is None:
                return alpha, t
            found = found / (1 + change[0])
            place = place - found * change[1]
            if abs(found) < LEAST * abs(alpha):
                return alpha, t
        return (found, place) if (self._lacks(w, found, place)[0] < self.room).all() else (alpha, t)

    def _lacks(self, w: Complexes, alpha: complex, t: complex) -> tuple[Floats, Complexes]:
        """Return by how much each corner has less than its room, and the frame nodes as seen from the feature."""
        q = (w[self.outside] - t) / alpha if alpha else np.zeros(len(self.outside), np.complex128)
        return self.room - (np.conj(self.b - self.a) * (q - self.a)).imag, q

    def _change(self, q: Complexes, lacks: Floats) -> tuple[complex, complex] | None:
        """Return the least (ω, σ) that gives corners what each `lacks`; None if nothing does."""
        along = np.conj(self.b - self.a)
        size, count = float(np.linalg.norm(self.body.arms)), float(np.sqrt(len(self.body.nodes)))
        parts = [(along * q).imag / size, (along * q).real / size, along.imag / count, along.real / count]
        rows, limits = np.stack(parts, axis=1), self.body.limits
        for scales in [False, True] if limits.fix_size else [True]:
            chosen = np.array([scales, limits.turns, True, True])
            shortest = _shortest(rows[:, chosen], lacks)
            if shortest is not None:
                found = np.zeros(4)
                found[chosen] = shortest
                omega = complex(found[0], found[1]) / size
                return omega if scales else complex(np.exp(omega)) - 1, complex(found[2], found[3]) / count
        return None


def cuts_of(mapping: FeatureMapping) -> list[Cut]:
    """Return the features of a mapping that the frame cuts, and their corners with it."""
    index, frame, grid = mapping.index.ravel(), mapping.grid.outline.ravel(), mapping.grid
    rest = mapping.grid.nodes.reshape(-1, 2).view(np.complex128).ravel()
    near = grid.quads[frame[grid.quads].any(axis=1)]
    corners = np.concatenate([np.roll(near, -k, axis=1)[:, [0, 1, 3]] for k in range(4)])
    corners = np.concatenate([np.roll(corners, -k, axis=1) for k in range(3)])
    one, other, out = corners.T
    chosen = (index[one] >= 0) & (index[one] == index[other]) & (index[out] < 0) & frame[out]
    found = []
    for i in np.unique(index[one[chosen]]):
        a, b, o = corners[chosen & (index[one] == i)].T
        body = mapping.bodies[i]
        middle = rest[body.nodes].mean()
        area = (np.conj(rest[b] - rest[a]) * (rest[o] - rest[a])).imag
        found.append(Cut(int(i), body, rest[a] - middle, rest[b] - middle, o, LITTLE * area))
    return found


def fit_cuts(cuts: list[Cut], w: Complexes, alpha: Complexes, t: Complexes) -> tuple[Complexes, Complexes]:
    """Return (α, t) of all features (n,) with those that the frame cuts where they fit, for W (R, C)."""
    alpha, t = alpha.copy(), t.copy()
    for cut in cuts:
        alpha[cut.number], t[cut.number] = cut.fit(w.ravel(), alpha[cut.number], t[cut.number])
    return alpha, t


def _shortest(G: Floats, h: Floats) -> Floats | None:
    """Return the shortest y with G y >= h, None if there is none."""
    unit = np.linalg.norm(G, axis=1)
    far = float((h / unit).max())
    E, f = np.vstack([G.T, h / far]) / unit, np.append(np.zeros(G.shape[1]), 1.0)
    u, distance = scipy.optimize.nnls(E, f)
    # Where a combination of the constraints is at 0, they contradict one another.
    return None if distance < ROUNDING else np.asarray(far * (E @ u - f)[:-1] / distance**2)
