"""The feature-aware mapping: as close to W as its features allow  [FAT sec. 2]."""

from collections.abc import Callable
from functools import cached_property
from typing import Literal, TypedDict, Unpack

import numpy as np
import scipy

from core.arrays import Bools, Floats, InputError, Ints, Points
from core.grid import Features, Grid
from core.linalg.blas import one_thread
from core.linalg.cubic_convolution import Smooth
from core.linalg.grid_solver import GridSolver, Onto
from core.linalg.laplacian import edge_weights, laplacian, node_values
from core.linalg.multifrontal import GridFactor
from core.mapping.features.columns import fields_of
from core.mapping.features.limits import FREE, NONE, RIGID, Single
from core.mapping.features.near_load import NearLoad
from core.mapping.features.per_quad import load_per_quad
from core.mapping.features.pose import Approach, HeldNodes, HeldPoints, Pose, Solution, Start
from core.mapping.features.quad_weights import assign_roles, weigh_free
from core.mapping.features.recycled import Recycled
from core.mapping.features.reduced_system import ReducedSystem, as_one, as_two, spread
from core.mapping.features.similarity import Bodies, Body, bodies_of, body_index
from core.mapping.features.sizes import smaller_scales
from core.mapping.jacobians import Complexes, as_complex
from core.mapping.tolerances import SINGULAR
from core.stopwatch import Stopwatch

Keep = Literal["similarity", "rigid"]
Method = Literal["exact", "per-quad"]


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
        self,
        w: Smooth,
        alpha: Complexes,
        t: Complexes,
        points: HeldPoints,
        to: Complexes,
        known: Recycled | None = None,
    ) -> Approach:
        """Return where bodies at (α, t), with the outline as W has it, leave `points` that are to be at `to` (k,)."""
        start, c = self._start(w, alpha, t), self._of_joint(alpha, t)
        with one_thread(), self.clock.measure("solve"):
            load, nodes = self._load(start, c)
            z, place = start.read(points.nodes), self._held.place.ravel()[points.nodes]
            is_joint = (place >= 0) & (place < len(self._held.bodies) - len(self._apart.nodes))
            z[is_joint] = self._joint_at(c, place[is_joint])
            missed = to - points.read(z)
            if known is not None:
                return Approach(w, load, known.miss(load, nodes, missed))
            y = self.factor.forward_again(load, nodes)
            return Approach(w, y, missed - points.moved_by(y))

    def hold(
        self,
        found: Approach,
        points: HeldPoints,
        base: Complexes,
        alpha: Complexes,
        t: Complexes,
        known: Recycled | None = None,
    ) -> Solution:
        """Return where nodes end with points held (FAT eq. 8): by forces λ on them, K_ff v = r_f + Cᵀ M* λ.

        All moves from `base` (R, C) on; with that, the similarities of bodies are (α, t). What is `known` of answers to
        much the same must have been given to `approach` too: free nodes are then off by what nobody sees.
        """
        at = [self._joint_at(self._of_joint(alpha, t)), self._apart_at(alpha, t)]
        onto = Onto(base, found.w, self._held.bodies, np.concatenate(at))
        with one_thread(), self.clock.measure("solve"):
            if known is not None:
                return Solution(onto.moved(known.answer(found.load, found.missed)), alpha, t)
            z, folded = self.factor.place(found.load + points.pull(found.missed), onto)
        return Solution(z, alpha, t, folded)

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
            if moves[joint:].any():
                alone = zip((alpha, t), self._apart.fit_within(w.ravel()), strict=True)
                for part, found in alone:
                    part[joint:] = np.where(moves[joint:], found, part[joint:])
            alpha[together] = t[together] = 0
            start, given = self._start(Smooth(w), alpha, t, frame), self._of_joint(alpha, t)
            load, nodes = self._load(start, given)
        if not self._placement.is_ready(together):
            with one_thread(), self.clock.measure("factor"):
                self._placement.prepare(together, nodes)
        with one_thread(), self.clock.measure("solve"):
            turns = self._joint.turns[together]
            c, y = self._placement.find(start, load, nodes, scales, given=given, moving=together, turns=turns)
            alpha[:joint], t[:joint] = c[:joint], c[joint:]
        return Pose(alpha, t, w, start, y, together)

    def follow(self, pose: Pose, alpha: Complexes | None = None, t: Complexes | None = None) -> Solution:
        """Return where free nodes end, with the bodies where the pose has them, or elsewhere."""
        assert self._placement is not None
        alpha, t = pose.alpha if alpha is None else alpha, pose.t if t is None else t
        held = np.isin(np.arange(len(alpha)), pose.moving, invert=True)
        if (alpha[held] != pose.alpha[held]).any() or (t[held] != pose.t[held]).any():
            return self.place_at(pose.w, alpha, t)
        c = self._of_joint(alpha, t)
        with one_thread(), self.clock.measure("solve"):
            load = self._placement.load_of(c, pose.load, pose.moving)
            z, folded = self.factor.place(load, pose.start.with_first(self._joint_at(c)).onto)
        return Solution(z, alpha, t, folded)

    def _of_joint(self, alpha: Complexes, t: Complexes) -> Complexes:
        """Return the (α, t) of the bodies that are placed together, one after the other."""
        return np.concatenate([part[: self.joint_count] for part in (alpha, t)])

    def _joint_at(self, c: Complexes, chosen: Ints | slice = np.s_[:]) -> Complexes:
        """Return where these bodies' (α, t) take their nodes, or some of them."""
        joint = len(c) // 2
        return self._joint.place(c[:joint], c[joint:], chosen) if self.has_poses else c[:0]

    def _apart_at(self, alpha: Complexes, t: Complexes) -> Complexes:
        """Return the same of all others."""
        return self._apart.place(alpha[self.joint_count :], t[self.joint_count :])

    def _start(self, w: Smooth, alpha: Complexes, t: Complexes, frame: Complexes | None = None) -> Start:
        """Return where nodes are before bodies that are placed together, at 0 for now, and free nodes follow."""
        joint = np.zeros(len(self._held.bodies) - len(self._apart.nodes))
        at_outline = w.read(self._held.outline) if frame is None else frame.ravel()[self._held.outline]
        return Start(w, self._held, np.concatenate([joint, self._apart_at(alpha, t), at_outline]))

    def fit_bodies(self, z: Smooth) -> tuple[Complexes, Complexes]:
        """Return the (α, t) of all bodies that bring each closest to z in the least-squares sense."""
        parts = (np.split(z.combine(part.fitting, part.nodes), 2) for part in (self._joint, self._apart))
        alpha, t = (np.concatenate(part) for part in zip(*parts, strict=True))
        return alpha, t

    def _load(self, start: Start, c: Complexes) -> tuple[Floats, Ints]:
        """Return b - K z⁰ + B c (m, 2) for c = (α, t) at the free nodes (m,) where it may not be 0."""
        glides = (start.at_held[len(self._held.bodies) :] != start.w.read(self._held.outline)).any()
        near = self._near_frame if glides else self._near_features
        return near.evaluate(start, spread(c)), near.nodes

    @cached_property
    def _near_features(self) -> NearLoad:
        return self._near(glides=False)

    @cached_property
    def _near_frame(self) -> NearLoad:
        return self._near(glides=True)

    def _near(self, *, glides: bool) -> NearLoad:
        fields = [] if self._placement is None else self._placement.fields
        own = edge_weights(self.follow_feature if fields else np.zeros_like(self.follow_feature))
        return NearLoad.of(self._edges, own, fields, self.free, self._held, glides=glides)

    @cached_property
    def _held(self) -> HeldNodes:
        bodies = np.concatenate([self._joint.nodes, self._apart.nodes]) if self.has_poses else np.empty(0, np.int64)
        return HeldNodes.of(bodies, self.grid.outline)

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
