"""Place features that the picture's edge cuts so that they fit between the outline nodes on either side.

Outline nodes outside features are held by W, a feature's nodes by its similarity. A corner of a quad with two nodes
a, b of one feature and one node o of the outline is therefore decided by the similarity alone. Seen from the feature,
with β = 1/α and τ = t/α, the outline node lies at β W(o) - τ, and twice the corner's area is

    Im(conj(a) b) + Im(conj(b - a) (β W(o) - τ)),

which is linear in (β, τ). So the placement closest to a given one that leaves every such corner some area is a small
least-distance problem (Lawson & Hanson 1974, ch. 23).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import cv2
import numpy as np
from numpy.typing import NDArray

from core.arrays import Floats, Ints
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.frames import Complexes, as_complex
from core.mapping.nonnegative import nonnegative

_MARGINS = (0.5, 0.25, 0.1, 0.03, 0.01)
"""Room to leave, in cells, the most that can be had."""
_WORTH = 0.05
"""Logarithm of the scale that may be given for more room."""
_CONTACTS = 8
_SAMPLES = 32
_NEAR = 8
"""Cells from the outline beyond which a feature is not fitted to it."""
_AROUND = 8
"""Cells around a feature in which the distance to it is known; no contact is as far."""
_FLAT = 0.1
_WORTH_HAVING, _FAR = 0.4, 1e3
"""Share of a feature's size for which the outline is not let go; weight of a place, in sizes of the picture."""
_SAME_SIZE = 0.01
"""Logarithm of a rigid feature's scale that the free nodes can take up."""
_NONE = float(np.sqrt(np.finfo(np.float64).eps))
"""Residual below which rounding hides whether there is a step, since its square is what the step is told by."""
_TOUCHING = 1e-3
"""Twice the area, in cells, below which a corner counts as folded."""
_TURN = 0.3
"""Radians by which a feature may turn at a time."""
_RIGID = 1e3
"""How much dearer a change of a rigid feature's size is than a turn."""
_CORNER, _CONTACT, _LIMIT = 1e3, 10.0, 1e5
"""How much dearer than to move the whole feature as far is what a corner, a contact and the limit of a turn miss."""
_NEWTON, _HALVINGS = 50, 30


def fit_between(mapping: FeatureMapping, w: Complexes, solution: Solution) -> Solution | None:
    """Return the solution with features moved to where they fit between outline nodes, None if all fit already."""
    found = fitted_places(mapping, w, solution.alpha, solution.t)
    return None if found is None else mapping.place_at(w, *found)


def fitted_places(
    mapping: FeatureMapping, w: Complexes, alpha: Complexes, t: Complexes
) -> tuple[Complexes, Complexes] | None:
    """Return the (α, t) closest to the given ones at which features fit between outline nodes, None if all do."""
    found, at = alpha.copy(), t.copy()
    for i, scene in _scenes(mapping, len(alpha)):
        found[i], at[i] = _fitted(mapping, i, scene, w.ravel(), alpha[i], t[i])
    return None if np.array_equal(found, alpha) else (found, at)


def folds_corners(mapping: FeatureMapping, w: Complexes, alpha: Complexes, t: Complexes) -> bool:
    """Return whether features at (α, t) fold a corner that they and the outline decide."""
    for i, scene in _scenes(mapping, len(alpha)):
        sides, base = scene.corner_sides()
        there = (w.ravel()[scene.corners[:, 0]] - t[i]) / alpha[i] if alpha[i] else np.full(len(base), np.nan)
        if not ((np.conj(sides) * there).real + base > 0).all():
            return True
    return False


def can_fit(mapping: FeatureMapping, w: Complexes, linear: Solution) -> bool:
    """Return whether features at a size worth having fold no corner of them and the outline.

    That is, whether each has such a similarity that is at least `_WORTH_HAVING` as large as that of `linear`.
    """
    far = _FAR * float(np.abs(w - w.mean()).max())
    for i, scene in _scenes(mapping, len(linear.alpha)):
        sides, base = scene.corner_sides()
        rows = _rows(sides, w.ravel()[scene.corners[:, 0]])
        if not len(rows):
            continue
        # Where it lies is all but free, so that the shortest step is the β of the largest similarity.
        largest = _least_step(rows * [1, 1, far, far], _TOUCHING - base)
        if largest is None or np.hypot(largest[0], largest[1]) * _WORTH_HAVING * np.abs(linear.alpha[i]) > 1:
            return False
    return True


_KNOWN: "WeakKeyDictionary[FeatureMapping, dict[int, _Scene]]" = WeakKeyDictionary()
"""Scenes depend on the features alone: while W changes, they stay."""


def _scenes(mapping: FeatureMapping, count: int) -> Iterator[tuple[int, "_Scene"]]:
    """Yield those of the first `count` features that come within a few cells of the outline, with their scenes."""
    if mapping not in _KNOWN:
        outer = np.flatnonzero(mapping.grid.outline & (mapping.index < 0))
        corners = _corners(mapping)
        owner = mapping.index.ravel()[corners[:, 1]]
        _KNOWN[mapping] = {i: _Scene.of(mapping, i, outer, corners[owner == i]) for i in _near_outline(mapping)}
    for i, scene in _KNOWN[mapping].items():
        if i < count:
            yield i, scene


def _near_outline(mapping: FeatureMapping) -> list[int]:
    """Return the indices of the features that come within a few cells of the outline."""
    rim = mapping.index.copy()
    rim[_NEAR:-_NEAR, _NEAR:-_NEAR] = -1
    found = np.unique(rim)
    return [int(i) for i in found[found >= 0]]


def _corners(mapping: FeatureMapping) -> Ints:
    """Return (k, 3) nodes o, a, b, clockwise, of the corners that one feature and the outline decide."""
    index = mapping.index.ravel()
    outer = mapping.grid.outline.ravel() & (index < 0)
    rim = np.ones((mapping.grid.rows - 1, mapping.grid.columns - 1), bool)
    rim[1:-1, 1:-1] = False
    quads = mapping.grid.quads[np.flatnonzero(rim)]
    quads = quads[outer[quads].any(axis=1)]
    corners = quads[:, [[3, 0, 1], [0, 1, 2], [1, 2, 3], [2, 3, 0]]].reshape(-1, 3)
    corners = corners[outer[corners].sum(axis=1) == 1]
    first = np.argmax(outer[corners], axis=1)
    corners = np.take_along_axis(corners, (first[:, None] + np.arange(3)) % 3, axis=1)
    owners = index[corners[:, 1:]]
    return np.asarray(corners[(owners[:, 0] == owners[:, 1]) & (owners[:, 0] >= 0)])


def _fitted(
    mapping: FeatureMapping, i: int, scene: "_Scene", w: Complexes, alpha: complex, t: complex
) -> tuple[complex, complex]:
    """Return the (α, t) closest to the given one at which every corner has area and no outline node is run over."""
    normals, offsets = scene.corner_sides()
    nodes = scene.corners[:, 0]
    beta, tau = 1 / alpha, t / alpha
    start = np.array([beta.real, beta.imag, tau.real, tau.imag])
    half = np.linalg.inv(np.linalg.cholesky(_metric(mapping, i, beta, tau))).T
    x = start
    for _ in range(_CONTACTS):
        hit, normal, offset = scene.contacts(w, complex(x[0], x[1]), complex(x[2], x[3]))
        low = _rows(normals, w[nodes]) @ x + offsets
        if not len(hit) and low.min(initial=1.0) > 0:
            break
        nodes, normals = np.append(nodes, hit), np.append(normals, normal)
        offsets = np.append(offsets, offset)
        A = _rows(normals, w[nodes])
        # A turn is linear in β for small angles only.
        sideways = np.array([-x[1], x[0], 0, 0]) / (x[0] ** 2 + x[1] ** 2)
        turn = np.stack([sideways, -sideways])
        G = np.vstack([A, turn])
        reach = [np.concatenate([margin - A @ start - offsets, -_TURN - turn @ start]) for margin in _MARGINS]
        found = [_least_step(G @ half, h) for h in reach]
        if not any(step is not None for step in found):
            # What cannot all be had is missed by as little as possible, corners less than contacts.
            cost = scene.unit * np.sqrt(len(mapping.bodies[i].nodes)) * np.full(len(A), _CONTACT)
            cost[: len(scene.corners)] *= _CORNER / _CONTACT
            found = [_least_miss(G @ half, reach[0], np.append(cost, _LIMIT / np.linalg.norm(turn @ half, axis=1)))]
        places = [start + half @ step for step in found if step is not None]
        if not places:
            break
        # Room is worth having, but not at the cost of the feature's size.
        changes = [abs(np.log(np.hypot(y[0], y[1]) / np.hypot(start[0], start[1]))) for y in places]
        x = next(y for y, change in zip(places, changes, strict=True) if change <= min(changes) + _WORTH)
    if x is start:
        return alpha, t
    beta, tau = complex(x[0], x[1]), complex(x[2], x[3])
    if mapping.keep == "rigid" and abs(np.log(abs(beta))) < _SAME_SIZE:
        beta /= abs(beta)
    return 1 / beta, tau / beta


def _rows(normals: Complexes, there: Complexes) -> Floats:
    """Return the rows of Re(conj(n) (β w - τ)) in (Re β, Im β, Re τ, Im τ)."""
    along = np.conj(normals) * there
    return np.stack([along.real, -along.imag, -normals.real, -normals.imag], axis=1)


@dataclass(frozen=True, eq=False)
class _Scene:
    """A feature at rest, seen from its centre, and the outline nodes around it."""

    corners: Ints
    """Nodes o, a, b (k, 3) of the corners that the feature and the outline decide."""
    ends: Complexes
    """Rest positions (k, 2) of a and b."""
    outer: Ints
    """Outline nodes outside features."""
    start: Complexes
    """Their rest positions."""
    unit: float
    """Side of a cell."""
    distance: NDArray[np.float32]
    """Signed distance to the feature in cells, positive outside, on the nodes around it."""
    origin: complex
    """Rest position of the first of these."""
    cell: tuple[float, float]

    @classmethod
    def of(cls, mapping: FeatureMapping, i: int, outer: Ints, corners: Ints) -> "_Scene":
        grid, body = mapping.grid, mapping.bodies[i]
        rest = as_complex(grid.nodes).ravel()
        centre = (rest[body.nodes] - body.arms)[0]
        row, column = np.divmod(body.nodes, grid.columns)
        top, left = row.min() - _AROUND, column.min() - _AROUND
        inside = np.zeros((row.max() + _AROUND + 1 - top, column.max() + _AROUND + 1 - left), np.uint8)
        inside[row - top, column - left] = 1
        out, into = (cv2.distanceTransform(m, cv2.DIST_L2, cv2.DIST_MASK_5) for m in (1 - inside, inside))
        distance = np.asarray(cv2.GaussianBlur(out - into, (0, 0), 1.0), np.float32)
        width, height = grid.cell
        origin = complex(rest[0] + left * width + 1j * top * height - centre)
        unit = float(np.sqrt(width * height))
        ends = rest[corners[:, 1:]] - centre
        return cls(corners, ends, outer, rest[outer] - centre, unit, distance, origin, grid.cell)

    def corner_sides(self) -> tuple[Complexes, Floats]:
        """Return n and c with twice each corner's area, in cells, = Re(conj(n) (β W(o) - τ)) + c."""
        a, b = self.ends.T
        return 1j * (b - a) / self.unit**2, (np.conj(a) * b).imag / self.unit**2

    def _distance_at(self, p: Complexes) -> Floats:
        if not p.size:
            return np.zeros(p.shape)
        u = ((p - self.origin).real / self.cell[0]).astype(np.float32)
        v = ((p - self.origin).imag / self.cell[1]).astype(np.float32)
        found = cv2.remap(self.distance, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(found, np.float64)

    def contacts(self, w: Complexes, beta: complex, tau: complex) -> tuple[Ints, Complexes, Floats]:
        """Return outline nodes that come into the feature, and n and c so that Re(conj(n) (β W - τ)) + c is to be > 0.

        The line is the feature's edge where the way from the node's place at rest first meets it.
        """
        start, end = self.start, beta * w[self.outer] - tau
        ways = start + np.linspace(0, 1, _SAMPLES)[:, None] * (end - start)
        room = np.minimum(1.0, 0.3 * self._distance_at(start[None])[0])
        close = self._distance_at(ways) < room
        chosen = np.flatnonzero(close[-1])
        first = ways[np.argmax(close[:, chosen], axis=0), chosen]
        step = 0.5 * self.unit
        slope = [
            self._distance_at((first + d)[None])[0] - self._distance_at((first - d)[None])[0] for d in (step, 1j * step)
        ]
        normal = slope[0] + 1j * slope[1]
        steep = np.abs(normal) > _FLAT
        chosen, first, normal = chosen[steep], first[steep], normal[steep] / np.abs(normal[steep])
        offset = -(np.conj(normal) * first).real / self.unit
        return self.outer[chosen], normal / self.unit, offset


def _metric(mapping: FeatureMapping, i: int, beta: complex, tau: complex) -> Floats:
    """Return the squared distance that a change of (β, τ) moves the body's nodes, as a quadratic form (4, 4).

    Seen from the feature, node p moves by -(dβ (p + τ) / β - dτ).
    """
    arms = mapping.bodies[i].arms
    first, spread = -tau / beta, float((np.abs(arms) ** 2).sum()) / abs(beta) ** 2
    rows = np.array([[first.real, -first.imag, 1, 0], [first.imag, first.real, 0, 1]])
    form = len(arms) * rows.T @ rows
    form[0, 0] += spread
    form[1, 1] += spread
    if mapping.keep == "rigid":
        unit = np.array([beta.real, beta.imag, 0, 0]) / abs(beta)
        form += _RIGID * spread * np.outer(unit, unit)
    return np.asarray(form)


def _least_step(G: Floats, h: Floats) -> Floats | None:
    """Return the shortest y with G y >= h, None if there is none."""
    size = np.linalg.norm(G, axis=1)
    E, f = np.vstack([G.T, h]) / size, np.append(np.zeros(G.shape[1]), 1.0)
    u, residual = nonnegative(E, f)
    if residual < _NONE:
        return None
    # The last entry of E u - f is -|E u - f|², which this way never rounds to 0.
    return np.asarray((E @ u - f)[:-1] / residual**2)


def _least_miss(G: Floats, h: Floats, cost: Floats) -> Floats:
    """Return the y that minimises |y|² + |cost max(0, h - G y)|², by Newton's method on a convex function."""

    def value(y: Floats) -> float:
        return float(y @ y + (np.maximum(0, cost * (h - G @ y)) ** 2).sum())

    y = np.zeros(G.shape[1])
    for _ in range(_NEWTON):
        missed = h > G @ y
        rows = cost[missed, None] * G[missed]
        H = np.eye(len(y)) + rows.T @ rows
        step = np.linalg.solve(H, rows.T @ (cost * h)[missed]) - y
        length, before = 1.0, value(y)
        while length > 0.5**_HALVINGS and value(y + length * step) >= before:
            length /= 2
        if length <= 0.5**_HALVINGS:
            break
        y = y + length * step
    return y
