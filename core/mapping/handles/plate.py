"""How handles deform the plane around them: a thin plate with rigid inclusions  [FAT sec. 3; Bookstein 1989].

Handles displace the picture that is there without them, z⁰. The displacement d of the nodes minimises

    E(d) = Σ |∂d|² + ℓ² Σ (|d_xx|² + 2 |d_xy|² + |d_yy|²),

where d is as asked for at every point of the background that a handle holds, and where every feature moves as a rigid
body at sampled points p of its rim. How it moves is known of a feature that handles place; else it turns by φ and moves
by (x, y) as costs least, so that no torque and no force is left on it: near where it is, by iα (p - pivot) φ + x + iy.
∂ is the gradient where the frame is held, d = 0 there; where it is free, the part of the derivative that is no
similarity. ℓ is the distance over which handles are rounded: without it they would draw the picture into spikes.

With A the matrix of E and C the bilinear weights of the points (for rings, combinations of these), d = A⁻¹ C* λ with
S λ = g + Q c, S = C A⁻¹ C*, g what is known of the points' displacements, Q c what the unknown motions c make of them,
which are real: Re Q* λ = 0. So

    c = -(Re Q* S⁻¹ Q)⁻¹ Re Q* S⁻¹ g:

one small dense inverse for each set of points, and a few products in every frame.

A displacement is linear, so that it would shear what is turned far. Therefore the local rotation r of z⁰ + d against
z⁰ is taken from it, quad by quad, and the gradient of z⁰ turned by it is integrated [as-rigid-as-possible; Sorkine and
Alexa 2007]: y minimises Σ |d y - (r - 1) d z⁰|², y = 0 on the frame. Then d makes up for the rest.

Lines that are to stay straight are rods in the plate (`rods`).
"""

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias

import numpy as np
import scipy
from numpy.typing import NDArray

from core.arrays import Floats, Points
from core.grid import Grid
from core.linalg.blas import one_thread
from core.linalg.cubic_convolution import Smooth
from core.linalg.laplacian import edge_weights, laplacian
from core.linalg.reduced_basis import ReducedBasis
from core.mapping.handles.dirichlet_plate import HeldForces, HeldPlate
from core.mapping.handles.free_plate import FreeForces, FreePlate
from core.mapping.handles.probes import Probes
from core.mapping.handles.rods import Found, Rods, RodSystem, Slides
from core.mapping.handles.turned import Base, Turned
from core.mapping.jacobians import Complexes, as_complex
from core.mapping.tolerances import SINGULAR, UNSEEN_PX
from core.tracing import span

Frame = Literal["held", "free"]
Plate: TypeAlias = HeldPlate | FreePlate

ROUNDED = 0.1
"""ℓ as a share of the grid's diagonal."""
_REFINEMENTS = 1
"""Of the forces on points, some of which may be close together."""
_APART = 1e-5
"""Pivots down to this share of the largest one, squared, tell of points that are surely apart."""


def make_plate(grid: Grid, frame: Frame) -> Plate | None:
    """Return the plate over a grid, None where no node can move.

    frame
        "held": the outline stays where it is; "free": nothing but the handles holds the picture.
    """
    if frame == "free":
        return FreePlate(grid, smoothness=ROUNDED)
    if min(grid.shape) <= 2:
        return None
    return HeldPlate(grid, smoothness=ROUNDED)


class HandleField:
    """Displacements of a grid by points at any places of the picture; made once per set, solve once per frame.

    They are those of the plate's nodes (r, c), which may be fewer than the picture's (R, C); `refine` and `sample` lead
    from the ones to the others.

    Parameters
    ----------
    points
        What is displaced (n): points of the picture, and rings around some.
    spare
        With the frame free, how many columns similarities of the whole have: one handle alone moves the picture, two
        turn and scale it too.
    rods
        Lines that stay straight.
    bodies
        B (n, u): how unknown motions of bodies move the points; by default the points are of no body.
    slides
        Directions and shapes (R, C) by which a straight frame slides with rods that end on it.
    known
        The field of other points of the same plate, in which some of these may be.
    """

    def __init__(
        self,
        grid: Grid,
        plate: Plate | None,
        points: Probes,
        *,
        spare: int = 0,
        rods: Rods | None = None,
        bodies: "scipy.sparse.csr_array | None" = None,
        slides: Sequence[tuple[complex, Floats]] = (),
        known: "HandleField | None" = None,
    ) -> None:
        self.grid, self._plate = grid if plate is None else plate.grid, plate
        grid = self.grid
        self.rods = Rods.none(grid) if rods is None else rods
        self._system: RodSystem | None = None
        """None where there are no rods."""
        self._length = float(np.hypot(grid.width_px, grid.height_px))
        at, self._M = points.spread(grid)
        """Places (m, 2), and combinations M (n, m) of these that the points are."""
        self._spare = spare if isinstance(plate, FreePlate) else 0
        self._bodies = scipy.sparse.csr_array((len(points), 0)) if bodies is None else bodies
        self._forces: HeldForces | FreeForces | None = None
        if plate is None or not len(points):
            return
        with span("handles", count=len(points)), one_thread():
            at, n = self._inside(at), self._M.shape[0]
            self._nodes, self._weights = grid.weights_at(at)
            places = np.concatenate([at, self._inside(self.rods.at)])
            if isinstance(plate, FreePlate):
                before = None if known is None else known._forces
                self._forces = plate.hold(places, before if isinstance(before, FreeForces) else None)
            else:
                self._forces = plate.hold(places)
            of_all: Any = self._M
            if len(self.rods):
                of_all = scipy.sparse.block_diag([self._M, self.rods.M], format="csr")
            self._loads = of_all.conj().T.tocsr()
            S = np.asarray(of_all @ self._forces.S @ self._loads)
            across, within, S = S[:n, n:], S[n:, n:], S[:n, :n]
            if self._spare:
                whole = of_all @ self._similarities(places)
                across = np.concatenate([across, whole[n:].conj().T])
                S = np.block([[S, whole[:n]], [whole[:n].conj().T, np.zeros((self._spare,) * 2)]])
            self._S, self._inverse = S, _inverse(S)
            self._on_bodies = np.asarray(self._bodies.conj().T @ self._inverse[:n, :n])
            self._between_bodies = np.asarray(self._on_bodies @ self._bodies)
            off = UNSEEN_PX / np.concatenate([np.ones(n), np.abs(np.diag(within))])
            self._basis = ReducedBasis(self._spread, off)
            if len(self.rods):
                self._system = RodSystem(self.rods, self._inverse, across, within)
                self._slides = self._prepare_slides(slides)

    @property
    def is_free(self) -> bool:
        """Whether the frame is."""
        return isinstance(self._plate, FreePlate)

    def find_motions(self, known: Complexes, along: Complexes, turned: Turned | None = None) -> Floats:
        """Return the motions c (u,) of bodies.

        They move the points by Σ Bᵢ aᵢ cᵢ (n,), a being `along` (u,), beyond what is `known` of them (n,).
        """
        if self._forces is None or not len(along):
            return np.zeros(len(along))
        if self._system is not None and turned is not None:
            return self._push(known, self._bodies.toarray() * along, turned).motions
        system = (along.conj()[:, None] * self._between_bodies * along).real
        return _solve(system, -(along.conj() * (self._on_bodies @ known)).real)

    def displace(self, asked: Complexes, turned: Turned | None = None, *, recycles: bool = False) -> Complexes:
        """Return the nodes' displacements d (r, c) that have the points' ones (n,), beside what is `turned`.

        One that `recycles` earlier answers is off by what nobody sees.
        """
        if self._forces is None:
            return np.zeros(self.grid.shape, np.complex128)
        if self._system is None or turned is None:
            return self._answer(asked, recycles=recycles).reshape(self.grid.shape)
        none, slides = np.empty((len(asked), 0), np.complex128), self._slides.where(turned.slides)
        found = self._push(asked, none, turned)
        d = slides.fields @ found.slid
        d = d + self._answer(asked - slides.at_points @ found.slid, found.forces, recycles=recycles)
        return np.asarray(d).reshape(self.grid.shape)

    @property
    def is_new(self) -> bool:
        """Whether the last answer that recycled what is known had anything new."""
        return self._forces is not None and self._basis.is_new

    def learn(self) -> None:
        """Let the next answers that recycle what is known be nearer to the exact ones."""
        if self._forces is not None:
            self._basis.learn()

    def sample(self, z: Complexes) -> Complexes:
        """Return what z at the picture's nodes (R, C) is at the plate's (r, c)."""
        return self._plate.sample(z) if isinstance(self._plate, HeldPlate) else z

    def refine(self, d: Complexes, sides: Complexes | None) -> Smooth:
        """Return what d (r, c) is at the picture's nodes (R, C), on the frame exactly what moves it there, `sides`."""
        return self._plate.refine(d, sides) if isinstance(self._plate, HeldPlate) else Smooth(d)

    def still(self, base: Base, *, slides: bool) -> Turned:
        """Return that nothing of z⁰ is turned; `slides` says whether a straight frame holds it."""
        return self._aim(base, np.zeros_like(base.z), base.z, slides=slides)

    def turn(self, base: Base, d: Complexes, sides: Complexes | None, *, slides: bool) -> Turned:
        """Return what large rotations make of z⁰ displaced by d (r, c); on the frame y is `sides` (R, C), or 0."""
        held = np.zeros_like(d) if sides is None else np.where(self.grid.outline, self.sample(sides), 0)
        return self._aim(base, self._integrate(base, d, held), base.z + d, slides=slides)

    def _aim(self, base: Base, y: Complexes, now: Complexes, *, slides: bool) -> Turned:
        """Return y with the normals that rods have `now` (r, c), and by how much more than in z⁰ it bends them."""
        if not len(self.rods):
            return Turned(y, np.empty(0, np.complex128), np.empty(0), slides)
        there, moved, then = (self.rods.read(self.grid, z.ravel()) for z in (base.z, y, now))
        normals = self.rods.normals(then)
        bends = self.rods.bends(there + moved, normals) - self.rods.bends(there, self.rods.normals(there))
        return Turned(y, normals, bends, slides)

    def _integrate(self, base: Base, d: Complexes, held: Complexes) -> Complexes:
        """Return y (r, c): the displacement of z⁰ whose gradient z⁰ + d turns, locally, with that of z⁰.

        With the frame free there is none: similarities cost nothing there.
        """
        if not isinstance(self._plate, HeldPlate):
            return held
        load = base.turn(base.z + d)
        if held.any():
            load -= laplacian(edge_weights(np.ones((self.grid.rows - 1, self.grid.columns - 1))), held)
        with one_thread():
            return self._plate.solve_poisson(load) + held

    def at_points(self, d: Complexes) -> Complexes:
        """Return what displacements d (r, c) of the nodes are at the points (n,)."""
        if self._forces is None:
            return np.zeros(self._M.shape[0], np.complex128)
        return self._moved(d.ravel())

    def _push(self, known: Complexes, Q: Complexes, turned: Turned) -> Found:
        """Return how rods answer what is `known` of the points (n,), and bodies that move them by Q."""
        assert self._system is not None
        with one_thread():
            return self._system.find(known, Q, self._slides.where(turned.slides), turned.normals, turned.bends)

    def _answer(self, asked: Complexes, pushes: Complexes | None = None, *, recycles: bool) -> Complexes:
        """Return d (N,) for what is asked of the points (n,), where rods push by forces (k,)."""
        pushed = np.zeros(len(self.rods), np.complex128) if pushes is None else pushes
        x = np.concatenate([asked, pushed])
        return self._basis.answer(x) if recycles else self._spread(x)

    def _spread(self, x: Complexes) -> Complexes:
        """Return the same for both, one after the other (n + k,)."""
        assert self._forces is not None
        asked, pushed = np.split(x, [len(x) - len(self.rods)])
        n, load = len(asked), np.concatenate([asked, np.zeros(self._spare)])
        if self._system is not None:
            load = load - self._system.across @ pushed
        found = times(self._inverse, load)
        for _ in range(_REFINEMENTS):
            found = found + times(self._inverse, load - times(self._S, found))
        d = self._forces.answer(self._loads @ np.concatenate([found[:n], pushed]))
        if self._spare:
            d += found[-1]
        if self._spare > 1:
            d += as_complex(self.grid.nodes).ravel() / self._length * found[-2]
        return d

    def _prepare_slides(self, shapes: Sequence[tuple[complex, Floats]]) -> Slides:
        """Return how the frame slides by these directions and shapes (R, C), and how inner nodes follow."""
        plain = edge_weights(np.ones((self.grid.rows - 1, self.grid.columns - 1)))
        fields, loads = np.zeros((2, self.grid.size, len(shapes)), np.complex128)
        for number, (along, fine) in enumerate(shapes):
            assert isinstance(self._plate, HeldPlate)
            shape = self.sample(fine.astype(np.complex128)).real
            y = along * (shape + self._plate.solve_poisson(-laplacian(plain, shape.astype(np.complex128))))
            fields[:, number], loads[:, number] = y.ravel(), laplacian(plain, y).ravel()
        cost = (fields.conj().T @ loads).real / 2  # an inner edge belongs to two quads
        at_rows = np.asarray(self.rods.M @ self.rods.read(self.grid, fields))
        return Slides(fields, cost, self._moved(fields), at_rows)

    def _similarities(self, places: Points) -> Complexes:
        """Return the displacements (n, spare) of `places` (n, 2) by the similarities of the whole."""
        here = as_complex(places)[:, None] / self._length
        return np.concatenate([here, np.ones_like(here)], axis=1)[:, 2 - self._spare :]

    def _inside(self, points: Points) -> Points:
        """Return the points, those less than a cell from a held frame a cell inside it: on it nothing moves."""
        if isinstance(self._plate, FreePlate):
            return points
        margin = np.minimum(self.grid.cell, np.array([self.grid.width_px, self.grid.height_px]) / 2)
        return np.clip(points, margin - 0.5, [self.grid.width_px, self.grid.height_px] - margin - 0.5)

    def _moved(self, d: Complexes) -> Complexes:
        """Return M C d for d (N,) or (N, q)."""
        return np.asarray(self._M @ np.einsum("nk,nk...->n...", self._weights, d[self._nodes]))


def times(matrix: NDArray[Any], z: Complexes) -> Complexes:
    """Return a matrix, which may be real, times x + iy (n,): NumPy would make it complex each time."""
    if np.iscomplexobj(matrix):
        return np.asarray(matrix @ z)
    return (matrix @ z[:, None].view(np.float64)).view(np.complex128)[:, 0]


def _solve(system: Floats, load: Floats) -> Floats:
    """Return the solution of a symmetric system, the least one where it is not regular."""
    L = _factor(system)
    return (
        _pseudoinverse(system) @ load if L is None else np.asarray(scipy.linalg.lapack.dpotrs(L, load, lower=True)[0])
    )


def _inverse(system: NDArray[Any]) -> NDArray[Any]:
    """Return the inverse of a symmetric matrix; one that is not regular has a pseudoinverse."""
    L = _factor(system)
    if L is None:
        return _pseudoinverse(system)
    half, _ = scipy.linalg.lapack.dpotri(L, lower=True)
    return np.asarray(np.tril(half) + np.tril(half, -1).T)


def _factor(system: NDArray[Any]) -> Floats | None:
    """Return L of a matrix that its pivots say is definite, with all points apart; None of any other."""
    if not len(system) or np.iscomplexobj(system):
        return None
    L, fault = scipy.linalg.lapack.dpotrf(system, lower=True)
    return None if fault or (np.diag(L) <= _APART * np.diag(L).max(initial=0)).any() else np.asarray(L)


def _pseudoinverse(system: NDArray[Any]) -> NDArray[Any]:
    return np.linalg.pinv(system, rcond=SINGULAR, hermitian=True)
