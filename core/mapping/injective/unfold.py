"""A map without folds, as close to what is wanted as its features, handles and frame allow.

FAT sec. 5 leaves fold-overs as future work. Here one problem is solved, by one stepper, along one continuation.

**Unknowns.** Nodes of the grid lie at z, complex, in pixels. Nodes of body i lie at z = t + α (p - pivot), where p is
their place in the picture and α = α⁰ exp(ρ + iφ): they are eliminated, so that bodies keep their shape exactly. Unknown
are inner nodes (2 each), of every body those of ρ, φ, Re t and Im t that the constraints leave free, and by their arc
length nodes of the outline that glide along it (`unknowns`).

**Energy**, in units of a cell:

    E = ½ Σ_quads Σ_edges w_W² |dz - dW|² + w_F² |dz - α dp|²      FAT eq. 4 for the background, eq. 3 around bodies
      + μ Σ_corners [|J|² + 1 + D²] / (2 χ_ε(D))                   against folds, Garanzha et al. 2021 (`barrier`)
      + Σ_bodies k n_i δ h(log(|α_i| / s_i) / δ)                   sizes s_i, by n_i nodes
      + Σ_loose τ δ h(|z - S| / δ)                                 the outline of S, where it may be left
      + Σ_driven ν δ h(distance / δ)                               handles, where they cannot be held

J is a corner's linear map against the same corner of S (`shape`), a map without folds, and D its determinant. W is what
is `wanted`; it may fold. h grows like a line (`springs`): sizes, outline and handles behave as with friction. They stay
where the force on them is below their strength, and what stayed is then set exactly. Strengths say what yields first:
the background, then sizes, then the outline, at last handles, those first that are farthest from what can be had. The
shape of a body never yields, and nothing ever folds.

**Constraints**, hard: the bilinear places of points of the background lie on their targets, C z = to. A step satisfies
them to first order, C step = to - C z, and the line search minds how far they are from being met (`newton`).

**Continuation** (`continuation`). Folds are cleared from the linear answer, which meets all constraints but folds in
places: ε falls from the depth of the folds with μ large, until every corner has room. Where they do not become
shallower, friction falls; then μ rises. After that μ falls, and with it ε, while the line search keeps D positive.

**Coarse to fine** (`levels`, `refinement`). Both run first on a grid of larger cells, on all of it. Corners of the fine
grid that poses alone decide stand behind the coarse barrier as well (`contacts`). What friction held is set exactly;
the result is lifted, and the few folds that come of it are cleared in narrow windows: the first map without folds.
Elsewhere the linear answer for these poses takes its place, and near folds E is brought to its least.

**Order of ways.** Few folds are cleared on the fine grid at once, outline and sizes held. From a map that is `near`,
where one is given, more of them are, with bodies as there. Then the coarse grid has its turn with the outline where it
is, first from that map.

Without handles the outline may have to yield: beside cut bodies nodes leave it or, if that is enough, glide along it;
before they leave it, rigid bodies may take the size that they have under W if that is no less than half. At last the
way begins at a map without folds, the one similarity of all closest to S, or S with small bodies in it (`starts`).

With handles a curved outline may glide beside what it cuts. Handles that cannot all be held are drawn to their goals
instead, with friction: from the map that is `safe`, the picture before a handle moved, brought part of the way to the
linear answer, which is shown; first on the coarse grid, then on the fine one. What does not get there stays where it
came to. All loops are bounded by counts.
"""

from dataclasses import replace
from itertools import count

import numpy as np

from core.arrays import Floats
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.features.pose import Solution
from core.mapping.folds import find_folded_quads
from core.mapping.handles.constraints import Constraints
from core.mapping.injective.levels import GridLevel
from core.mapping.injective.problem import Goal
from core.mapping.injective.ways import Ways
from core.mapping.jacobians import Complexes, as_complex
from core.progress import Job, T, stepwise

_PACE = 0.98
"""What a step leaves of the work that is said to be left."""


def unfold(
    mapping: FeatureMapping,
    wanted: Complexes,
    start: Solution,
    *,
    shape: Complexes,
    scales: Floats,
    constraints: Constraints,
    safe: Solution | None = None,
    near: Solution | None = None,
) -> Job[Solution]:
    """Return a map without folded quads that is as close to what is wanted as that allows.

    Parameters
    ----------
    mapping
        The grid with its bodies and the roles of its quads; it is left as it was.
    wanted
        W (R, C), which background quads follow.
    start
        The linear answer, which meets all constraints but may fold.
    shape
        S (R, C), a map without folds that corners are measured against, and whose outline is kept.
    scales
        Size (n,) that each body is to have.
    safe
        A map without folds with exact bodies, from which handles can be drawn to their goals.
    near
        A map without folds of nearly the same, such as the frame before: of several maps, the one next to it is found.

    A step's preview is a first map without folds, (R, C, 2), on which the rest of the work improves. Where `shape`
    folds, the linear answer is returned.
    """
    if find_folded_quads(shape).any() or not find_folded_quads(start.z).any():
        return start
    n, rest = len(start.alpha), as_complex(mapping.grid.nodes).ravel()
    centres = np.array([rest[body.nodes].mean() for body in mapping.bodies[:n]], np.complex128)
    order = np.lexsort((constraints.to.imag, constraints.to.real, *constraints.probes.at.T))
    held = replace(constraints, probes=constraints.probes[order], to=constraints.to[order])
    if not n:
        held = replace(held, pivots=held.pivots[:0], free=held.free[:0])
    level = GridLevel.of(mapping, wanted, start, shape, held)
    linear = level.of_solution(start, centres)
    begin, beside = (None if known is None else level.of_solution(known, centres) for known in (safe, near))
    ways = Ways(mapping, level, linear, Goal(scales[:n], linear.alpha, linear.place), centres)
    found = yield from _counted(ways.find(begin, beside))
    return level.solution_of(found, centres)


def _counted(job: Job[T]) -> Job[T]:
    """Run `job` with fractions that grow with every step, since nobody knows how many there will be."""
    counter = count(1)
    return stepwise(job, lambda step: replace(step, fraction=1 - _PACE ** next(counter)))
