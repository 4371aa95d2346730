"""The feature-aware mapping: as close to W as its features allow  [FAT sec. 2]."""

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from typing import Literal, TypedDict, Unpack

import numpy as np
import scipy

from core.arrays import Bools, Floats, InputError, Ints, Points
from core.grid import SIDES, Features, Grid
from core.linalg.bands import cut_bands
from core.linalg.blas import one_thread
from core.linalg.grid_solver import GridSolver
from core.linalg.laplacian import collect_steps, edge_weights, laplacian, node_values, steps
from core.linalg.multifrontal import GridFactor
from core.mapping.features.columns import fields_of
from core.mapping.features.limits import FREE, NONE, RIGID, Single
from core.mapping.features.per_quad import load_per_quad
from core.mapping.features.pose import Approach, HeldPoints, Pose, Solution
from core.mapping.features.quad_weights import assign_roles, weigh_free
from core.mapping.features.reduced_system import ReducedSystem, as_one, as_two
from core.mapping.features.similarity import Bodies, Body, bodies_of, body_index
from core.mapping.features.sizes import smaller_scales
from core.mapping.jacobians import Complexes, as_complex
from core.mapping.tolerances import SINGULAR
from core.stopwatch import Stopwatch

Keep = Literal["similarity", "rigid"]
Method = Literal["exact", "per-quad"]
Ways = Sequence[tuple[Complexes, Complexes]]


class Choices(TypedDict, total=False):
    """What `FeatureMapping` says of them."""

    keep: Keep
    single: Single
    method: Method
    weight: float
    falloff: float


JOINT_AT_MOST = 32
"""So many features, the largest, are placed together; each smaller one where W alone would have it."""


class FeatureMapping:
    """Map a grid as close to W as its features allow; factor once per grid and mask, solve once per frame.

    Parameters
    ----------
    keep
        "similarity": every feature is turned, moved and scaled by its λ, the smaller singular value of W in it;
        "rigid": turned and moved.
    single
        Limits of single features; of all others `keep` says them.
    method
        "exact": a feature's nodes move as one; "per-quad": FAT eqs. 1-7 as printed.
    weight
        w_F: what the equations of a feature's quads are multiplied by.
    falloff
        ρ: over so many cells around a feature the weight returns to 1.
    analyse
        What makes the factor of a grid of that shape.
    """

    def __init__(
        self,
        grid: Grid,
        features: Features,
        *,
        keep: Keep = "similarity",
        single: Single = NONE,
        method: Method = "exact",
        weight: float = 10.0,
        falloff: float = 2.0,
        analyse: Callable[[tuple[int, int]], GridSolver] = GridFactor,
        _taken: "FeatureMapping | None" = None,
    ) -> None:
        if features.labels.shape != grid.shape:
            raise InputError("features: found on another grid")
        self.grid, self.features, self.method = grid, features, method
        self._is_spent = False
        self.clock = Stopwatch()
        self._rest = as_complex(grid.nodes)
        with self.clock.measure("setup"):
            self.factor: GridSolver = analyse(grid.shape) if _taken is None else _taken.factor
            known: list[Body] = [] if _taken is None else [*_taken.bodies, *_taken.soft]
            bodies = bodies_of(features, self._rest, RIGID if keep == "rigid" else FREE, single, known)
            bodies.sort(key=lambda body: -len(body.nodes))
            self.bodies: list[Body] = [body for body in bodies if body.limits.weight == 1]
            self.soft: list[Body] = [body for body in bodies if body.limits.weight < 1]
            self._joint, self._apart = Bodies(self.bodies[: self.joint_count]), Bodies(self.bodies[self.joint_count :])
            self.index = body_index(self.bodies, grid.shape)
            self._roles = assign_roles(self.index, weight=weight, falloff=falloff)
            self.owner = np.where(self._roles.owner < self.joint_count, self._roles.owner, -1)
            self.follow_feature = np.where(self.owner >= 0, self._roles.weight**2, 0.0)
            self.follow_w = weigh_free(self.owner, grid, self.soft, weight)
            self._edges = edge_weights(self.follow_w + self.follow_feature)
            self._own_edges = edge_weights(self.follow_feature)
            self.free = ~(grid.outline if method == "per-quad" else grid.outline | (self.index >= 0))
            values = node_values(self._edges, self.free)
        with one_thread(), self.clock.measure("factor"):
            self.factor.factorise(values)
            self._placement = self._place_features(_taken) if self.method == "exact" and self.bodies else None

    def update(self, features: Features, **choices: Unpack[Choices]) -> "FeatureMapping":
        """Return the mapping of other features on the same grid, with this one's factor, renewed where it differs.

        This one is spent: it raises `RuntimeError` when it is solved with again.
        """
        self._check_fresh()
        self._is_spent = True
        return FeatureMapping(self.grid, features, **choices, _taken=self)

    def _check_fresh(self) -> None:
        if self._is_spent:
            raise RuntimeError("this mapping was updated: only the one that `update` returned can be solved with")

    @property
    def joint_count(self) -> int:
        """How many bodies, the first, are placed together."""
        return min(len(self.bodies), JOINT_AT_MOST) if self.method == "exact" else len(self.bodies)

    def _place_features(self, previous: "FeatureMapping | None") -> ReducedSystem:
        known = previous._placement.fields if previous is not None and previous._placement is not None else []
        fields = fields_of(
            self.bodies[: self.joint_count],
            self._rest,
            owner=self.owner,
            follow=self.follow_feature,
            weights=self._edges,
            reach=self._roles.reach,
            known=known,
        )
        return ReducedSystem(fields, free=self.free, factor=self.factor)

    def solve(self, warped: Points) -> Points:
        """Return where the nodes (R, C, 2) end, given where W takes them."""
        return self.place(as_complex(warped)).positions

    def place(self, w: Complexes) -> Solution:
        """Return where nodes and features end, given where W takes the nodes, as x + iy (R, C)."""
        self._check_fresh()
        if w.shape != self.grid.shape or not np.isfinite(w.view(np.float64)).all():
            raise InputError("warp: does not take every grid node to a finite position")
        return self._per_quad(w) if self._placement is None else self.follow(self.pose(w))

    def place_at(self, w: Complexes, alpha: Complexes, t: Complexes) -> Solution:
        """Return where free nodes end, given W and the similarity of every body."""
        if self._placement is None:
            return self.place(w)
        return self.follow(self.pose(w, alpha, t, moving=np.zeros(len(alpha), bool)))

    def hold_points(self, at: Points, M: "scipy.sparse.csr_array", shares: Floats | None = None) -> HeldPoints:
        """Return what holding combinations M (k, m) of the points `at` (m, 2) takes; half a solve for each point.

        With `shares` (m, s) each point is the mean, by them, of s places: `at` is (m, s, 2).
        """
        self._check_fresh()
        nodes, weights = self.grid.weights_at(at.reshape(-1, 2))
        if shares is not None:
            nodes, weights = nodes.reshape(len(at), -1), (weights.reshape(*shares.shape, -1) * shares[..., None])
            weights = weights.reshape(len(at), -1)
        free = np.where(self.free.ravel()[nodes], weights, 0.0)
        load = np.zeros((self.grid.size, len(at)))
        np.add.at(load, (nodes, np.arange(len(at))[:, None]), free)
        with one_thread(), self.clock.measure("factor"):
            half = self.factor.forward(load, np.unique(nodes))
            inverse = np.linalg.pinv(M @ (half.T @ half) @ M.conj().T, rcond=SINGULAR, hermitian=True)
            return HeldPoints(nodes, weights, M, half, inverse)

    def approach(
        self, w: Complexes, alpha: Complexes, t: Complexes, frame: Complexes, points: HeldPoints, to: Complexes
    ) -> Approach:
        """Return where bodies at (α, t) and the outline at `frame` leave `points` that are to be at `to` (k,)."""
        if self._placement is None:
            z = np.where(self.grid.outline, frame, w)
            r = laplacian(self._edges, w - z)
            with one_thread(), self.clock.measure("solve"):
                y = self.factor.forward_again(as_two(np.where(self.free, r, 0).ravel()))
        else:
            pose = self.pose(w, alpha, t, moving=np.zeros(len(alpha), bool), frame=frame)
            z, y = pose.start, pose.load
            self.put_bodies(z, alpha, t)
        with one_thread():
            return Approach(z, y, to - points.read(z) - points.moved_by(y))

    def hold(self, found: Approach, points: HeldPoints) -> Complexes:
        """Return where nodes (R, C) end with points held (FAT eq. 8): by forces λ on them, K_ff v = r_f + Cᵀ M* λ."""
        with one_thread(), self.clock.measure("solve"):
            v = as_one(self.factor.backward(found.load + points.pull(found.missed)))
        z = v.reshape(found.start.shape)
        z += found.start
        return z

    @property
    def moved_bodies(self) -> list[Body]:
        """The bodies that move as one each."""
        return self.bodies if self.has_poses else []

    @property
    def has_poses(self) -> bool:
        """Whether there are bodies that move as one each, so that they have a pose."""
        return self._placement is not None

    def pose(
        self,
        w: Complexes,
        alpha: Complexes | None = None,
        t: Complexes | None = None,
        *,
        moving: Bools | None = None,
        frame: Complexes | None = None,
    ) -> Pose:
        """Return where the bodies `moving`, by default all, find their place, given W and the similarity of the others.

        Bodies that are not placed together never move from a similarity that is given. Nodes of the outline outside
        bodies are where W has them, or where `frame` (R, C) has them.
        """
        self._check_fresh()
        assert self._placement is not None
        joint = self.joint_count
        alpha, t = (np.zeros(len(self.bodies), np.complex128) if c is None else c.copy() for c in (alpha, t))
        moves = np.ones(len(self.bodies), bool) if moving is None else moving
        together = np.flatnonzero(moves[:joint])
        with self.clock.measure("rhs"):
            scales = self._scales(w, together) if together.size else None
            z = w.copy() if frame is None else np.where(self.grid.outline, frame, w)
            z.ravel()[self._joint.nodes] = 0
            if moves[joint:].any():
                alone = zip((alpha, t), self._apart.fit_within(w.ravel()), strict=True)
                for part, found in alone:
                    part[joint:] = np.where(moves[joint:], found, part[joint:])
            z.ravel()[self._apart.nodes] = self._apart.place(alpha[joint:], t[joint:])
            r = self._load(w, z, glides=frame is not None)
        if not self._placement.is_ready(together):
            with one_thread(), self.clock.measure("factor"):
                self._placement.prepare(together)
        with one_thread(), self.clock.measure("solve"):
            given = np.concatenate([alpha[:joint], t[:joint]])
            turns = self._joint.turns[together]
            c, load = self._placement.find(w, z, r, scales, given=given, moving=together, turns=turns)
            alpha[:joint], t[:joint] = c[:joint], c[joint:]
        return Pose(alpha, t, w, z, load, together)

    def follow(self, pose: Pose, alpha: Complexes | None = None, t: Complexes | None = None) -> Solution:
        """Return where free nodes end, with the bodies where the pose has them, or elsewhere."""
        assert self._placement is not None
        joint = self.joint_count
        alpha, t = pose.alpha if alpha is None else alpha, pose.t if t is None else t
        held = np.isin(np.arange(len(alpha)), pose.moving, invert=True)
        if (alpha[held] != pose.alpha[held]).any() or (t[held] != pose.t[held]).any():
            return self.place_at(pose.w, alpha, t)
        with one_thread(), self.clock.measure("solve"):
            c = np.concatenate([alpha[:joint], t[:joint]])
            z = self._placement.follow(c, pose.load, pose.moving).reshape(pose.w.shape)
            z += pose.start
            z.ravel()[self._joint.nodes] = self._joint.place(alpha[:joint], t[:joint])
        return Solution(z, alpha, t)

    def put_bodies(self, z: Complexes, alpha: Complexes, t: Complexes) -> None:
        """Set the nodes of z (R, C) that lie in bodies to where the similarities of all bodies take them."""
        joint = self.joint_count
        z.ravel()[self._joint.nodes] = self._joint.place(alpha[:joint], t[:joint])
        z.ravel()[self._apart.nodes] = self._apart.place(alpha[joint:], t[joint:])

    def fit_bodies(self, z: Complexes) -> tuple[Complexes, Complexes]:
        """Return the (α, t) of all bodies that bring each closest to z (R, C) in the least-squares sense."""
        parts = zip(self._joint.fit(z.ravel()), self._apart.fit(z.ravel()), strict=True)
        alpha, t = (np.concatenate(part) for part in parts)
        return alpha, t

    def _load(self, w: Complexes, z: Complexes, *, glides: bool) -> Complexes:
        """Return b - K z⁰ = K (W - z⁰) - dᵀ w_own d W (R, C), w_own of the quads that follow features.

        It is 0 but around features, and along a frame that `glides`.
        """
        load, columns = np.zeros_like(w), w.shape[1]
        bands: Iterable[tuple[slice, Ways]] = self._bands_asked
        if glides and any((w[side] != z[side]).any() for side in SIDES):
            bands = ((band, self._weigh_ways(band)) for band in cut_bands(np.ones(len(w), bool), columns))
        for band, weights in bands:
            read = _with_neighbours(band)
            here = w[read].ravel()
            ways = zip(steps(here - z[read].ravel(), columns), steps(here, columns), weights, strict=True)
            across, down = (both * away - own * way for away, way, (both, own) in ways)
            load[band] = collect_steps(across, down).reshape(-1, columns)[band.start - read.start :][: len(load[band])]
        return load

    @cached_property
    def _bands_asked(self) -> list[tuple[slice, Ways]]:
        """Bands around features, and the weights of the ways in them."""
        bands = cut_bands(self._rows_asked, self.grid.columns)
        return [(band, self._weigh_ways(band)) for band in bands]

    def _weigh_ways(self, band: slice) -> Ways:
        """Return the weights of the ways across and down in a band and to the rows beside it (`laplacian.steps`).

        They are those of all edges, and of those that follow features; complex, for products with complex numbers.
        """
        read, found = _with_neighbours(band), []
        for across, down in (self._edges, self._own_edges):
            rows = np.pad(across[read], ((0, 0), (0, 1))).ravel()[:-1], down[read.start : read.stop - 1].ravel()
            found.append([part.astype(np.complex128) for part in rows])
        return list(zip(*found, strict=True))

    @cached_property
    def _rows_asked(self) -> Bools:
        """The rows (R,) of features, their neighbours, and the quads that follow them."""
        across, down = self._own_edges
        asked: Bools = np.any(self.index >= 0, axis=1) | np.any(across, axis=1)
        asked[1:] |= np.any(down, axis=1)
        asked[:-1] |= np.any(down, axis=1)
        near = asked.copy()
        near[1:] |= asked[:-1]
        near[:-1] |= asked[1:]
        return near

    def scale_alone(self, body: int, w: Complexes) -> float:
        """Return the size that W alone gives a body: λ of FAT eq. 3 within its limits."""
        if body >= self.joint_count:
            return float(np.abs(Bodies([self.bodies[body]]).fit_within(w.ravel())[0][0]))
        scales = self._scales(w, np.array([body]))
        return abs(self.bodies[body].fit(w.ravel())[0]) if scales is None else float(scales[0])

    def _scales(self, w: Complexes, chosen: Ints) -> Floats | None:
        """Return the scale of each `chosen` feature; None leaves it to the best fit where there are only features."""
        limits = [self.bodies[i].limits for i in chosen]
        if not self.free.any() and all(limit == FREE for limit in limits):
            return None
        are_fixed = all(limit.fix_size for limit in limits)
        sizes = np.zeros(len(chosen)) if are_fixed else self.sizes_under(w, chosen)
        return self._joint.clip_sizes(sizes, chosen)

    def sizes_under(self, w: Complexes, chosen: Ints) -> Floats:
        """Return λ of FAT sec. 2.1 of the `chosen` bodies; where it is 0, the size of the similarity closest to W."""
        found = smaller_scales(self.grid, w, self._roles, chosen)
        for place in np.flatnonzero(found <= 0):
            found[place] = abs(self.bodies[chosen[place]].fit(w.ravel())[0])
        return found

    def _per_quad(self, w: Complexes) -> Solution:
        """Solve FAT eqs. 3-5: quads of a feature turn and scale, each by its own rotation and the feature's λ."""
        none = np.empty(0, np.complex128)
        if not self.bodies:
            # W itself has no energy: b - K w = 0.
            with self.clock.measure("rhs"), self.clock.measure("solve"):
                return Solution(w.copy(), none, none)
        with self.clock.measure("rhs"):
            b = load_per_quad(self.grid, w, self._roles, self.owner, self._joint)
            r = np.where(self.free, b - laplacian(self._edges, w), 0)
        with one_thread(), self.clock.measure("solve"):
            v = as_one(self.factor.solve(as_two(r.ravel())))
        return Solution(w + v.reshape(w.shape), none, none)


def _with_neighbours(band: slice) -> slice:
    """Return a band of rows and one more on both sides, where there is one."""
    return slice(max(band.start - 1, 0), band.stop + 1)
