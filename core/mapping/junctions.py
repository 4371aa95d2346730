"""Place features that the picture's edge cuts so that they fit between the outline nodes on either side.

Outline nodes outside features are held by W, a feature's nodes by its similarity. A corner of a quad with two nodes
a, b of one feature and one node o of the outline is therefore decided by the similarity alone. Seen from the feature,
with β = 1/α and τ = t/α, the outline node lies at β W(o) - τ, and twice the corner's area is

    Im(conj(a) b) + Im(conj(b - a) (β W(o) - τ)),

which is linear in (β, τ). So the placement closest to a given one that leaves every such corner some area is a small
least-distance problem (Lawson & Hanson 1974, ch. 23).
"""

import numpy as np

from core.arrays import Floats
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.frames import Complexes
from core.mapping.nonnegative import nonnegative
from core.mapping.scenes import Scene, joined, scenes

_MARGINS = (0.5, 0.25, 0.1, 0.03, 0.01)
"""Room to leave, in cells, the most that can be had."""
WORTH = 0.05
"""Logarithm of the scale that may be given for more room."""
_CONTACTS = 8
_WORTH_HAVING, _FAR = 0.1, 1e3
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
    mapping: FeatureMapping, w: Complexes, alpha: Complexes, t: Complexes, *, worth: float = WORTH
) -> tuple[Complexes, Complexes] | None:
    """Return the (α, t) closest to the given ones at which features fit between outline nodes, None if all do.

    `worth` is the logarithm of a feature's scale that may be given for more room.
    """
    found, at = alpha.copy(), t.copy()
    for i, scene in scenes(mapping, len(alpha)):
        found[i], at[i] = _fitted(mapping, i, scene, w.ravel(), alpha[i], t[i], worth)
    return None if np.array_equal(found, alpha) else (found, at)


def folds_corners(mapping: FeatureMapping, w: Complexes, alpha: Complexes, t: Complexes) -> bool:
    """Return whether features at (α, t) fold a corner that they and the outline decide."""
    for i, scene in scenes(mapping, len(alpha)):
        sides = scene.sides(w.ravel())
        there = (w.ravel()[sides.nodes] - t[i]) / alpha[i] if alpha[i] else np.full(len(sides.nodes), np.nan)
        if not ((np.conj(sides.normals) * there).real + sides.offsets > 0).all():
            return True
    return False


def can_fit(mapping: FeatureMapping, w: Complexes, linear: Solution) -> bool:
    """Return whether features at a size worth having fold no corner of them and the outline.

    That is, whether each has such a similarity that is at least `_WORTH_HAVING` as large as that of `linear`.
    """
    return bool((largest_scales(mapping, w, len(linear.alpha)) >= _WORTH_HAVING * np.abs(linear.alpha)).all())


def largest_scales(mapping: FeatureMapping, w: Complexes, count: int) -> Floats:
    """Return for each of the first `count` features the scale up to which some similarity folds no such corner."""
    far = _FAR * float(np.abs(w - w.mean()).max())
    scales = np.full(count, np.inf)
    for i, scene in scenes(mapping, count):
        sides = scene.sides(w.ravel())
        if not sides.nodes.size:
            continue
        # Where it lies is all but free, so that the shortest step is the β of the largest similarity.
        largest = _least_step(sides.rows(w.ravel()) * [1, 1, far, far], _TOUCHING - sides.offsets)
        beta = np.inf if largest is None else float(np.hypot(largest[0], largest[1]))
        scales[i] = 1 / beta if beta else np.inf
    return scales


def _fitted(
    mapping: FeatureMapping, i: int, scene: Scene, w: Complexes, alpha: complex, t: complex, worth: float
) -> tuple[complex, complex]:
    """Return the (α, t) closest to the given one at which every corner has area and no outline node is run over."""
    sides = scene.sides(w)
    beta, tau = 1 / alpha, t / alpha
    start = np.array([beta.real, beta.imag, tau.real, tau.imag])
    half = np.linalg.inv(np.linalg.cholesky(_metric(mapping, i, beta, tau))).T
    x = start
    for _ in range(_CONTACTS):
        hit = scene.contacts(w, complex(x[0], x[1]), complex(x[2], x[3]))
        low = sides.rows(w) @ x + sides.offsets
        if not hit.nodes.size and low.min(initial=1.0) > 0:
            break
        sides = joined([sides, hit])
        A = sides.rows(w)
        # A turn is linear in β for small angles only.
        sideways = np.array([-x[1], x[0], 0, 0]) / (x[0] ** 2 + x[1] ** 2)
        turn = np.stack([sideways, -sideways])
        G = np.vstack([A, turn])
        reach = [np.concatenate([margin - A @ start - sides.offsets, -_TURN - turn @ start]) for margin in _MARGINS]
        found = [_least_step(G @ half, h) for h in reach]
        if not any(step is not None for step in found):
            # What cannot all be had is missed by as little as possible, corners less than contacts.
            cost = scene.unit * np.sqrt(len(mapping.bodies[i].nodes)) * np.full(len(A), _CONTACT)
            cost[: len(scene.corners.nodes)] *= _CORNER / _CONTACT
            found = [_least_miss(G @ half, reach[0], np.append(cost, _LIMIT / np.linalg.norm(turn @ half, axis=1)))]
        places = [start + half @ step for step in found if step is not None]
        if not places:
            break
        # Room is worth having, but not at the cost of the feature's size.
        changes = [abs(np.log(np.hypot(y[0], y[1]) / np.hypot(start[0], start[1]))) for y in places]
        x = next(y for y, change in zip(places, changes, strict=True) if change <= min(changes) + worth)
    if x is start:
        return alpha, t
    beta, tau = complex(x[0], x[1]), complex(x[2], x[3])
    if mapping.keep == "rigid" and abs(np.log(abs(beta))) < _SAME_SIZE:
        beta /= abs(beta)
    return 1 / beta, tau / beta


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
    far = float((h / size).max(initial=0.0))
    if far <= 0:
        return np.zeros(G.shape[1])
    # As a multiple of the farthest of the single ways, y is of a size that rounding does not hide.
    E, f = np.vstack([G.T, h / far]) / size, np.append(np.zeros(G.shape[1]), 1.0)
    u, residual = nonnegative(E, f)
    if residual < _NONE:
        return None
    # The last entry of E u - f is -|E u - f|², which this way never rounds to 0.
    return np.asarray(far * (E @ u - f)[:-1] / residual**2)


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
