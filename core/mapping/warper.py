"""What an editor keeps between frames: the analysis of a grid, the factor of a mask, the structure of handles."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from core.arrays import InputError, Ints, Points
from core.grid import Features, Grid
from core.linalg.blas import on_one_thread, one_thread
from core.linalg.multifrontal import MappingFactor, grid_factor
from core.mapping.features.feature_mapping import FeatureMapping, Solution
from core.mapping.features.pose import Pose
from core.mapping.handles.curved_frame import Cut, cuts_of, fit_cuts
from core.mapping.handles.frame_glide import FrameGlide
from core.mapping.handles.handles import Handles
from core.mapping.handles.solver import HandleSolver, Moved
from core.mapping.handles.straight_frame import Placed, Rectangle, constrain_frame, place_cut
from core.mapping.injective.unfold import unfold
from core.mapping.jacobians import as_complex, as_positions
from core.mapping.options import MappingOptions
from core.mapping.result import NO_PINS, Pins, Warped
from core.progress import Job

_NO_POSES = np.empty(0, np.complex128), np.empty(0, np.complex128)
_LIVE_ROUNDS, _ROUNDS = 1, 20
"""How often at most what handles miss is asked for as well, while something moves and at rest."""
_NEAR = 12
"""Cells from a stroke within which features are placed with the one that it changes."""
_FRAMES_PER_TURN = 2
"""Under a brush, one of the features that it leaves alone is placed anew once in so many frames."""


class Warper:
    """What an editor keeps between frames: the analysis of the grid and the factor of the mask.

    `use` costs a factorisation when features or options are others than before, `frame` one right-hand side and one
    solve, and as much again where there are handles. `settle` is the answer at rest. One thread at a time; a background
    thread has its own.

    Handles are applied to the picture as it is without them: at rest, that has no folds where W has none.

    Under a brush, when nothing but one feature changes from one frame to the next, each frame places that one and those
    close by; the others stay where they are, but for one of them in turn every few frames. So a stroke costs the same
    beside many features as beside few.
    """

    def __init__(self, grid: Grid, *, analyse: Callable[[Grid], MappingFactor] = grid_factor) -> None:
        self.grid, self._analyse = grid, analyse
        self._features = Features(np.zeros(grid.shape, np.int32))
        self._options = MappingOptions(keep="none")
        self._mapping: FeatureMapping | None = None
        self._newest: FeatureMapping | None = None
        """The last mapping there was, which the next one starts from."""
        self._last: _Frame | None = None
        self._turn = 0
        self._handles: HandleSolver | None = None
        self._glide: tuple[FeatureMapping, FrameGlide] | None = None
        self._cuts: tuple[FeatureMapping, list[Cut]] | None = None
        self._known: tuple[FeatureMapping, Points, Solution] | None = None
        """The picture without handles and without folds, for a mapping and a W."""
        self._shown: tuple[FeatureMapping, Points, Solution] | None = None
        """The linear answer to them."""

    def use(self, features: Features, options: MappingOptions) -> None:
        """Prepare for the given features and options; cheap when they are the same objects as before."""
        alike = replace(options, frame=self._options.frame) == self._options
        if features is not self._features or not alike:
            self._last = self._last if alike else None
            self._mapping = None
            if options.keep != "none":
                self._mapping = self._map(features, options)
        self._features, self._options = features, options

    def _map(self, features: Features, options: MappingOptions) -> FeatureMapping:
        """Return the mapping of other features or options, by way of the last one there was."""
        keep: Literal["similarity", "rigid"] = "rigid" if options.keep == "rigid" else "similarity"
        method, weight, falloff = options.method, options.weight, options.falloff
        if self._newest is None:
            self._newest = FeatureMapping(
                self.grid,
                features,
                keep=keep,
                method=method,
                weight=weight,
                falloff=falloff,
                analyse=self._analyse,
            )
        else:
            self._newest = self._newest.update(features, keep=keep, method=method, weight=weight, falloff=falloff)
        return self._newest

    def frame(self, plain: Points, handles: Handles | None = None) -> Warped:
        """Return the linear answer, which may fold, for W at the nodes (R, C, 2)."""
        _check_finite(plain)
        seconds: dict[str, float] = {}
        reference = self._reference(plain)
        moved = self._moved(reference, handles, rounds=_LIVE_ROUNDS)
        seconds |= self._seconds()
        found = self._result(plain, reference, moved, handles, seconds)
        return found if moved is None or moved.is_final else replace(found, is_rough=True)

    def learn(self, plain: Points, reference: Solution) -> None:
        """Take it that W at the nodes (R, C, 2) leads to the `reference` at rest, without handles."""
        if self._mapping is not None and len(reference.alpha) == len(self._mapping.bodies):
            self._known = self._mapping, plain, reference

    def _reference(self, plain: Points) -> Solution:
        """Return the picture without handles: without folds if that is known, else the linear answer."""
        mapping, w = self._mapping, as_complex(plain)
        if mapping is None or not mapping.has_poses:
            self._last = None
            return Solution(w, *_NO_POSES) if mapping is None else mapping.place(w)
        for known in (self._known, self._shown):
            if known is not None and known[0] is mapping and known[1] is plain:
                return known[2]
        found = self._linear(mapping, plain)
        self._shown = mapping, plain, found
        return found

    def _linear(self, mapping: FeatureMapping, plain: Points) -> Solution:
        """Return the linear answer without handles.

        Where W keeps the frame a rectangle, features that it cuts slide along its sides, and where it stretches the
        picture, all of the frame glides with what the features do; where W bends it, they fit between its nodes.
        """
        w = as_complex(plain)
        rectangle = Rectangle.of(w)
        placed = None if rectangle is None else place_cut(mapping, w, rectangle)
        if rectangle is not None and placed is not None and placed.frame is not None:
            cut = np.isin(mapping.index, np.flatnonzero(placed.bodies))
            if not rectangle.holds(placed.frame[cut]):
                self._last = None
                return rectangle.cover(mapping)
        pose = self._pose(mapping, plain, placed)
        self._last = _Frame(mapping, plain, pose)
        if rectangle is None:
            rigid = mapping.keep == "rigid"
            return mapping.follow(pose, *fit_cuts(self._cuts_of(mapping), w, pose.alpha, pose.t, rigid=rigid))
        found = mapping.follow(pose)
        if not rectangle.stretches(self.grid):
            return found
        if self._glide is None or self._glide[0] is not mapping:
            self._glide = mapping, FrameGlide(mapping)
        placed = replace(placed or Placed.none(mapping), frame=self._glide[1].glide(found.z, w))
        self._last = None
        return mapping.follow(self._pose(mapping, plain, placed))

    def _cuts_of(self, mapping: FeatureMapping) -> list[Cut]:
        """Return the features that the frame cuts, found once for a mapping."""
        if self._cuts is None or self._cuts[0] is not mapping:
            self._cuts = mapping, cuts_of(mapping)
        return self._cuts[1]

    def _moved(self, reference: Solution, handles: Handles | None, *, rounds: int) -> "Moved | None":
        """Return what the handles make of the reference, None without handles."""
        if handles is None or not handles.any:
            return None
        mapping = self._mapping
        if mapping is None:
            mapping = self._bare()
        if self._handles is None or self._handles.frame != self._options.frame:
            self._handles = HandleSolver(mapping, self._options.frame)
        with one_thread():
            return self._handles.solve(mapping, reference, handles, rounds=rounds)

    def _bare(self) -> FeatureMapping:
        """Return the mapping without features."""
        newest = self._newest
        if newest is not None and not newest.bodies:
            return newest
        return self._map(Features(np.zeros(self.grid.shape, np.int32)), MappingOptions())

    def _pose(self, mapping: FeatureMapping, plain: Points, placed: Placed | None) -> Pose:
        """Return where features are; those that are `placed` are given."""
        last, w = self._last, as_complex(plain)
        alpha, t, moving, frame = None, None, None, None
        if placed is not None:
            alpha, t, moving, frame = placed.alpha, placed.t, ~placed.bodies, placed.frame
        if last is None or last.mapping is mapping or last.plain is not plain:
            return mapping.pose(w, alpha, t, moving=moving, frame=frame)
        before = last.places_in(mapping)
        same = np.flatnonzero(before >= 0)
        came, gone = len(before) - same.size, len(last.mapping.bodies) - same.size
        if came > 1 or gone > came:
            return mapping.pose(w, alpha, t, moving=moving, frame=frame)
        stay = np.zeros(len(before), bool) if placed is None else placed.bodies
        alpha, t = (
            np.zeros((2, len(before)), np.complex128) if placed is None else (placed.alpha.copy(), placed.t.copy())
        )
        known = same[~stay[same]]
        alpha[known], t[known] = last.pose.alpha[before[known]], last.pose.t[before[known]]
        moves = before < 0
        moves[last.bodies_near_change(mapping)] = True
        turn, self._turn = self._turn, self._turn + 1
        if same.size and turn % _FRAMES_PER_TURN == 0:
            moves[same[turn // _FRAMES_PER_TURN % same.size]] = True
        return mapping.pose(w, alpha, t, moving=moves & ~stay, frame=frame)

    def settle(self, plain: Points, handles: Handles | None = None) -> Job[Warped]:
        """Return the answer without folds where W has none."""
        _check_finite(plain)
        seconds: dict[str, float] = {}
        started = time.perf_counter()
        reference = yield from on_one_thread(self._unfolded(plain))
        if self._handles is not None:
            self._handles.forget()
        moved = self._moved(reference, handles, rounds=_ROUNDS)
        if moved is not None:
            moved = yield from on_one_thread(self._unfolded_handles(reference, moved))
        seconds |= self._seconds(time.perf_counter() - started)
        return self._result(plain, reference, moved, handles, seconds)

    def _unfolded(self, plain: Points) -> Job[Solution]:
        """Return the picture without handles and, where W has none, without folds."""
        mapping = self._mapping
        if mapping is None:
            return self._reference(plain)
        if self._known is not None and self._known[0] is mapping and self._known[1] is plain:
            return self._known[2]
        linear, w = self._linear_afresh(mapping, plain), as_complex(plain)
        constraints = constrain_frame(mapping, linear.z)
        solution = yield from unfold(mapping, w, linear, shape=w, scales=np.abs(linear.alpha), constraints=constraints)
        self._known = mapping, plain, solution
        return solution

    def _linear_afresh(self, mapping: FeatureMapping, plain: Points) -> Solution:
        """Return the linear answer without handles, whatever was answered before."""
        if not mapping.has_poses:
            return mapping.place(as_complex(plain))
        self._last = None
        return self._linear(mapping, plain)

    def _unfolded_handles(self, reference: Solution, moved: Moved) -> Job[Moved]:
        """Return a picture that handles have moved, without folds where there were none without them."""
        mapping = self._mapping or self._bare()
        assert self._handles is not None
        solution = yield from unfold(
            mapping,
            reference.z + moved.field,
            moved.solution,
            shape=reference.z,
            scales=np.abs(moved.solution.alpha),
            constraints=self._handles.constrain(reference, moved),
            safe=reference,
        )
        return replace(moved, solution=solution)

    def _result(
        self,
        plain: Points,
        reference: Solution,
        moved: Moved | None,
        handles: Handles | None,
        seconds: dict[str, float],
    ) -> Warped:
        solution = reference if moved is None else moved.solution
        w = plain if moved is None or not moved.field.any() else plain + as_positions(moved.field)
        pins = NO_PINS if handles is None else Pins(handles.pins_at, handles.pins_to, handles.rings)
        rigid = self._options.keep == "rigid"
        return Warped(self.grid, w, solution.positions, self._features, rigid, seconds, pins=pins, reference=reference)

    def _seconds(self, settling: float = 0.0) -> dict[str, float]:
        """Return what the stages took since the last call."""
        seconds = dict.fromkeys(("setup", "factor", "rhs", "solve", "unfold"), 0.0)
        if self._mapping is not None:
            seconds |= self._mapping.clock.take()
        # What settling took beyond one solve; factorisations of its own are part of it.
        seconds["unfold"] = max(0.0, settling - seconds["rhs"] - seconds["solve"])
        return seconds


def _check_finite(plain: Points) -> None:
    """Raise `InputError` where W does not take every node (R, C, 2) to a finite position."""
    if not np.isfinite(plain).all():
        raise InputError("warp: does not take every grid node to a finite position")


@dataclass(frozen=True, eq=False)
class _Frame:
    """The last frame: what it was solved with, for and to, before features were fitted to the outline."""

    mapping: FeatureMapping
    plain: Points
    pose: Pose

    def places_in(self, mapping: FeatureMapping) -> Ints:
        """Return for each body of `mapping` the one with the same nodes in this frame's mapping, -1 for none."""
        known = {body.nodes.tobytes(): i for i, body in enumerate(self.mapping.bodies)}
        return np.array([known.get(body.nodes.tobytes(), -1) for body in mapping.bodies], np.int64)

    def bodies_near_change(self, mapping: FeatureMapping) -> Ints:
        """Return the bodies of `mapping` around nodes that came into a feature, or out of one, since this frame."""
        row, column = ((mapping.index >= 0) != (self.mapping.index >= 0)).nonzero()
        if not row.size:
            return np.empty(0, np.int64)
        rows = np.s_[max(row.min() - _NEAR, 0) : row.max() + _NEAR + 1]
        columns = np.s_[max(column.min() - _NEAR, 0) : column.max() + _NEAR + 1]
        near = np.unique(mapping.index[rows, columns])
        return near[near >= 0]
