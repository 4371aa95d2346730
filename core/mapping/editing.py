"""Deform a grid by handles: the Laplacian editing of the interactive mode  [FAT sec. 3, eq. 8].

The deformation is base + d. With z = x + iy in cells, the displacement d minimises

    E(d) = Σ |∂d|² + ℓ² Σ (|d_xx|² + 2 |d_xy|² + |d_yy|²)      so that d = c - base at every handle.

With the frame held, d = 0 on the outline and ∂ is the gradient. With the frame free, ∂ is the part of the derivative
that is no similarity (d/d conj z); E is then zero for similarities and for nothing else. Either way, handles that all
agree with one similarity of the base give that similarity. The second term is what keeps handles from drawing the
picture into spikes; ℓ is the distance over which they are rounded.

With A the matrix of E and C the bilinear weights of the handles, d = A⁻¹ Cᵀ λ + Q m where S = C A⁻¹ Cᵀ is as small as
the number of handles, and Q spans the similarities (frame free; Qᵀ Cᵀ λ = 0) or nothing (frame held).
"""

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from core.arrays import InputError, Ints, Points
from core.blas import one_thread
from core.grid import Grid
from core.mapping.frames import Complexes, as_complex, as_positions
from core.mapping.free_plate import FreePlate
from core.mapping.handles import Handles
from core.mapping.held_plate import HeldPlate
from core.tracing import span

Frame = Literal["held", "free"]

_REFINEMENTS = 3
_EXACT = 1e-12
_TOGETHER = 1e-12
"""Handles whose responses differ by no more than this share are taken as one."""
_CLOSE = 0.75
"""Cells from a handle within which the frame pushes no other."""
_APART = 1e-5
"""Pivots down to this share of the largest one, squared, tell of handles that are surely apart."""


class Editing:
    """Deform a grid by handles at any places of the picture; prepare once per grid, solve once per frame.

    Parameters
    ----------
    frame
        "held": the outline stays where the base has it; "free": nothing but the handles holds the picture.
    smoothness
        ℓ as a share of the grid's diagonal.
    """

    def __init__(self, grid: Grid, *, frame: Frame = "held", smoothness: float = 0.1) -> None:
        if not smoothness > 0:
            raise InputError(f"smoothness of {smoothness:g}: must be positive")
        self.grid, self.frame = grid, frame
        self._length = float(np.hypot(grid.width_px, grid.height_px))
        rounded = smoothness * float(np.hypot(*grid.shape))
        self._plate: HeldPlate | FreePlate | None = None
        """None where no node can move."""
        if frame == "free":
            self._plate = FreePlate(grid, cell=_cell(grid), rounded=rounded)
        elif min(grid.shape) > 2:
            self._plate = HeldPlate(grid, cell=_cell(grid), rounded=rounded)
        self._points = np.empty((0, 2))
        self._is_afresh = True
        """Whether all of them were declared at once."""
        self._held: Ints = np.empty(0, np.int64)
        """Which of them are held, and where."""
        self._at = np.empty((0, 2))
        self._inverse: NDArray[Any] = np.empty((0, 0))

    def hold(self, points: Points, *, afresh: bool = False) -> None:
        """Declare the places (n, 2) of the handles, in pixels of the picture; those declared before cost nothing.

        Responses depend in their last bits on the order in which handles came; `afresh` they do not.

        With the frame held, a place within a cell of it, or outside the picture, stands for the closest one a cell
        inside: what lies on the frame no handle can move. Of those that would come to lie close together, the one
        closest to its own place is held.
        """
        points = np.asarray(points, np.float64).reshape(-1, 2)
        if self._plate is None or (np.array_equal(points, self._points) and (self._is_afresh or not afresh)):
            return
        self._is_afresh = afresh or not len(self._points)
        if afresh:
            self._plate.hold(np.empty((0, 2)))
        with span("handles", count=len(points)):
            self._points, inside = points.copy(), self._inside(points)
            self._held = _spread(points, inside, _CLOSE * min(self.grid.cell))
            self._at = inside[self._held]
            S = self._plate.hold(self._at)
            if self.frame == "free":
                Q = self._similar()
                S = np.block([[S, Q], [Q.conj().T, np.zeros((self._spare,) * 2)]])
            with one_thread():
                self._inverse = _inverse(S)

    def solve(self, targets: Points, base: Points | None = None) -> Points:
        """Return where the nodes (R, C, 2) go so that the handles reach `targets` (n, 2).

        `base` (R, C, 2) is where they go without handles, by default where they are; its outline is the frame.
        """
        start = as_complex(self.grid.nodes if base is None else base)
        if self._plate is None or not len(self._held):
            return as_positions(start.copy())
        with span("editing"):
            wanted = as_complex(np.asarray(targets, np.float64)[self._held])
            goal = wanted - self._moved(self._points[self._held], start.ravel())
            d, rest = np.zeros(self.grid.size, np.complex128), goal
            for _ in range(_REFINEMENTS):
                d += self._displacement(rest)
                rest = goal - self._moved(self._at, d)
                if np.abs(rest).max() < _EXACT * np.abs(goal).max():
                    break
        return as_positions(start + d.reshape(start.shape))

    def _displacement(self, goal: Complexes) -> Complexes:
        """Return the nodes' d (N,) for the handles' d (n,)."""
        assert self._plate is not None
        found = self._inverse @ np.concatenate([goal, np.zeros(self._spare)])
        d = self._plate.answer(found[: len(goal)])
        if self._spare:
            d += found[-1]
        if self._spare > 1:
            d += as_complex(self.grid.nodes).ravel() / self._length * found[-2]
        return d

    @property
    def _spare(self) -> int:
        """Columns of Q: one handle alone moves the picture, two turn and scale it too."""
        return 0 if self.frame == "held" else min(len(self._held), 2)

    def _similar(self) -> Complexes:
        """Return C Q."""
        here = as_complex(self._at)[:, None] / self._length
        return np.concatenate([here, np.ones_like(here)], axis=1)[:, 2 - self._spare :]

    def _inside(self, points: Points) -> Points:
        if self.frame == "free":
            return points
        margin = np.minimum(self.grid.cell, np.array([self.grid.width_px, self.grid.height_px]) / 2)
        return np.clip(points, margin - 0.5, [self.grid.width_px, self.grid.height_px] - margin - 0.5)

    def _moved(self, points: Points, z: Complexes) -> Complexes:
        """Return C z for z (N,)."""
        nodes, weights = self.grid.weights_at(points)
        return np.asarray((z[nodes] * weights).sum(axis=1))


def _cell(grid: Grid) -> tuple[float, float]:
    """Return width and height of a cell in units of their mean."""
    width, height = grid.cell
    unit = float(np.sqrt(width * height))
    return width / unit, height / unit


def _spread(points: Points, inside: Points, distance: float) -> Ints:
    """Return which handles to hold: all that are `inside` where they are, of the others those not close to one held."""
    pushed = np.hypot(*(inside - points).T)
    held = np.flatnonzero(pushed == 0).tolist()
    for i in np.argsort(pushed, kind="stable").tolist()[len(held) :]:
        if not held or np.hypot(*(inside[held] - inside[i]).T).min() >= distance:
            held.append(i)
    return np.sort(np.array(held, np.int64))


def _inverse(system: NDArray[Any]) -> NDArray[Any]:
    """Return the inverse of a symmetric matrix; one that is not regular has a pseudoinverse.

    Where the pivots say that a matrix is definite and all handles are apart, its inverse costs little.
    """
    if len(system) and not np.iscomplexobj(system):
        L, fault = lapack.dpotrf(system, lower=True)
        if not fault and (np.diag(L) > _APART * np.diag(L).max(initial=0)).all():
            half, _ = lapack.dpotri(L, lower=True)
            return np.asarray(np.tril(half) + np.tril(half, -1).T)
    return np.linalg.pinv(system, rcond=_TOGETHER, hermitian=True)


def edit_grid(grid: Grid, handles: Handles, *, base: Points | None = None, frame: Frame = "held") -> Points:
    """Return where the nodes (R, C, 2) go so that the handles reach their targets: one-off form of `Editing`."""
    editing = Editing(grid, frame=frame)
    at, to = handles.points(grid)
    editing.hold(at)
    return editing.solve(to, base)
