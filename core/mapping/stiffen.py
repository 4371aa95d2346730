"""Stiffen features from W, which folds nowhere, until each moves as one: what is left when untangling does not succeed.

At the start every node is where W takes it. Each node i of a feature is tied to where the feature's similarity has it,

    μ Σ f(z) + κ/2 Σ |z_i - α a_i - t|² + k/2 (log |α| / s)²,

in units of a cell, with f the barrier of Garanzha et al. 2021 over the quads outside features, α and t free. No step
may fold anything. As κ grows, features find on their own the place, the angle and the size in which they fit; once they
can be set exactly without a fold, they are.
"""

from collections.abc import Iterator

import numpy as np

from core.arrays import Bools, Floats
from core.mapping.assembly import Assembly, packed
from core.mapping.distortion import Barrier, Corners
from core.mapping.feature_mapping import FeatureMapping, Solution
from core.mapping.folds import corner_areas
from core.mapping.frames import Complexes
from core.progress import Job, Progress
from core.tracing import span

_STEPS = 40
START, _TIGHTEN = 0.01, 2.0
"""κ at first, from W, and its growth a step."""
_NEARLY_STIFF = 10.0
"""The first tie where features nearly move as one."""
_BARRIER = Barrier(1e-4)
_SIZE = 0.02
"""k, per node."""
_CLEAR, _LEAST = 0.02, 1e-4
"""Share of its area that a corner is to have before features are set, and at the end."""
_PRESSED = 4
"""It has ended where in so many steps a corner with less than that has lost more in each."""
_HALVINGS = 12


class Stiffening:
    """Newton's method from W with features that are tied ever tighter; s is `scales`, one per feature.

    Outline nodes (R, C) that are `released` may leave W, none by default. It begins at `start` (R, C), by default W.
    Where the `whole` is to fold nowhere at any step, features are behind the barrier too.
    """

    def __init__(
        self,
        mapping: FeatureMapping,
        w: Complexes,
        scales: Floats,
        *,
        released: Bools | None = None,
        start: Complexes | None = None,
        whole: bool = False,
    ) -> None:
        self._mapping, self._scales = mapping, scales
        self.z = (w if start is None else start).ravel().copy()
        self._index = index = mapping.index.ravel()
        fits = [body.fit(self.z) for body in mapping.bodies]
        self.alpha, self.t = (np.array(part, np.complex128) for part in zip(*fits, strict=True))
        quads = mapping.grid.quads
        inside = (index[quads] == index[quads[:, :1]]).all(axis=1) & (index[quads[:, 0]] >= 0)
        self._quads = quads if whole else quads[~inside]
        self._corners = Corners.of(w.ravel()[self._quads.T])
        self._unit = float(np.sqrt(np.abs(corner_areas(w)).mean()))
        arms = np.zeros(len(index), np.complex128)
        for body in mapping.bodies:
            arms[body.nodes] = body.arms
        # Nodes deep inside a feature meet no quad of the barrier: their ties are never strained.
        border = np.unique(self._quads)
        self._tied = border[index[border] >= 0]
        self._owner, self._arms = index[self._tied], arms[self._tied]
        self._shares = np.bincount(self._owner, minlength=len(fits)).astype(np.float64)
        held = mapping.grid.outline if released is None else mapping.grid.outline & ~released
        self._free = border[(index[border] >= 0) | ~held.ravel()[border]]
        self._number_unknowns()

    def _number_unknowns(self) -> None:
        nodes, bodies = 2 * len(self._free), len(self.alpha)
        count = nodes + 4 * bodies
        place = np.full((len(self.z), 2), count)
        place[self._free] = np.arange(nodes).reshape(-1, 2)
        self._body = nodes + np.arange(4 * bodies).reshape(-1, 4)
        ties = np.concatenate([place[self._tied], self._body[self._owner]], axis=1)
        self._assembly = Assembly(count, [place[self._quads].reshape(-1, 8), ties, self._body[:, :2]])

    def step(self, tie: float) -> bool:
        """Take one Newton step with κ = `tie`; return whether it lowered the energy."""
        with span("stiffen", unknowns=self._assembly.count):
            gradient, entries = self._model(tie)
            move = -self._assembly.solve(entries, gradient)
            before, slope, length = self._energy(tie), float(gradient @ move), 1.0
            kept = self.z, self.alpha, self.t
            for _ in range(_HALVINGS):
                self._move(move * length)
                if self._worst(self.z) > 0 and self._energy(tie) <= before + 1e-4 * length * slope:
                    return True
                self.z, self.alpha, self.t = kept
                length /= 2
        return False

    def settled(self, least: float) -> Solution | None:
        """Return the solution with features set exactly, None if that leaves a corner less than `least`."""
        z = self.z.copy()
        for body, alpha, t in zip(self._mapping.bodies, self.alpha, self.t, strict=True):
            z[body.nodes] = body.place(alpha, t)
        if self._worst(z) <= least:
            return None
        return Solution(z.reshape(self._mapping.grid.shape), self.alpha.copy(), self.t.copy())

    @property
    def size(self) -> int:
        """The number of unknowns."""
        return self._assembly.count

    @property
    def worst(self) -> float:
        """The least area of a corner relative to W."""
        return self._worst(self.z)

    def _worst(self, z: Complexes) -> float:
        return float(self._corners.determinants(z[self._quads.T]).min(initial=np.inf))

    def _strain(self) -> Complexes:
        """Return how far tied nodes are from where their features have them, in cells."""
        placed = self.alpha[self._owner] * self._arms + self.t[self._owner]
        return np.asarray((self.z[self._tied] - placed) / self._unit)

    @property
    def _stretch(self) -> Floats:
        return np.asarray(np.log(np.abs(self.alpha) / self._scales))

    def _energy(self, tie: float) -> float:
        ties = tie * (np.abs(self._strain()) ** 2).sum() / 2
        sizes = _SIZE * (self._shares * self._stretch**2).sum() / 2
        return float(_BARRIER.energy(self._corners, self.z[self._quads.T]).sum() + ties + sizes)

    def _model(self, tie: float) -> tuple[Floats, Floats]:
        """Return the gradient of the energy and the entries of its second derivative."""
        gradient, curvature = _BARRIER.model(self._corners, self.z[self._quads.T])
        rows = self._tie_rows()
        strain = self._strain().view(np.float64).reshape(-1, 1, 2)
        # The logarithm's own curvature is left out: its square is convex enough where |α| is near s.
        towards = (self.alpha / np.abs(self.alpha) ** 2).view(np.float64).reshape(-1, 2)
        stiffness = _SIZE * self._shares[:, None]
        slopes = [gradient, tie * (strain @ rows)[:, 0], stiffness * self._stretch[:, None] * towards]
        sizes = stiffness[..., None] * towards[:, :, None] * towards[:, None]
        return self._assembly.gradient(slopes), self._assembly.entries(
            [curvature, packed(tie * (rows.transpose(0, 2, 1) @ rows)), packed(sizes)]
        )

    def _tie_rows(self) -> Floats:
        """Return how a tie's strain (x, y) moves with its node, α and t: (n, 2, 6)."""
        rows = np.zeros((len(self._tied), 2, 6))
        rows[:, 0, 0] = rows[:, 1, 1] = 1
        rows[:, 0, 2] = rows[:, 1, 3] = -self._arms.real
        rows[:, 0, 3], rows[:, 1, 2] = self._arms.imag, -self._arms.imag
        rows[:, 0, 4] = rows[:, 1, 5] = -1
        return rows / self._unit

    def _move(self, move: Floats) -> None:
        self.z = self.z.copy()
        self.z[self._free] += move[: 2 * len(self._free)].view(np.complex128)
        by = move[self._body].view(np.complex128)
        self.alpha, self.t = self.alpha + by[:, 0], self.t + by[:, 1]


def stiffen(
    mapping: FeatureMapping,
    w: Complexes,
    scales: Floats,
    *,
    released: Bools | None = None,
    start: Complexes | None = None,
) -> Job[Solution | None]:
    """Return a mapping without folds whose features are close to `scales`, None if features cannot be brought to it.

    Outline nodes (R, C) that are `released` may leave W, none by default. Where features nearly move as one each and
    nothing folds, the way may begin at such a `start` (R, C).
    """
    stiffening = Stiffening(mapping, w, scales, released=released, start=start)
    tie = START if start is None else _NEARLY_STIFF
    least, pressed = stiffening.worst, 0
    for step, found in enumerate(tightened(stiffening, tie, _STEPS)):
        if found is not None:
            return found
        before, least = least, stiffening.worst
        pressed = pressed + 1 if least < min(_CLEAR, before) else 0
        if pressed == _PRESSED:
            break
        yield Progress(step / _STEPS, "stiffening", work=stiffening.size)
    return stiffening.settled(_LEAST)


def tightened(stiffening: Stiffening, tie: float, steps: int) -> Iterator[Solution | None]:
    """Take steps with ties that grow from `tie`; yield after each the solution with features set, if they can be."""
    for _ in range(steps):
        moved = stiffening.step(tie)
        yield stiffening.settled(_CLEAR)
        tie *= _TIGHTEN if moved else 1 / _TIGHTEN
