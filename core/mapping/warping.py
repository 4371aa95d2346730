"""A feature-aware warp from W to its report: what the command line, the editor and Python share.

`warp_grid` is the one call; `LiveWarp` is what an editor keeps between frames.
"""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, Literal, TypeAlias

import numpy as np

from core.arrays import Bools, Ints, Points
from core.blas import on_one_thread
from core.grid import Features, Grid
from core.mapping.feature_mapping import FeatureMapping, Method, Pose, Solution
from core.mapping.folds import folded_quads
from core.mapping.frames import as_complex
from core.mapping.junctions import fitted_places, folds_corners
from core.mapping.similarity import bodies_of, fit_residual
from core.mapping.unfold import unfold
from core.progress import Job, run

Keep = Literal["similarity", "rigid", "none"]


@dataclass(frozen=True)
class MappingOptions:
    """What an artist chooses about the mapping."""

    keep: Keep = "similarity"
    method: Method = "exact"
    weight: float = 10.0
    """w_F of FAT sec. 2.1."""
    falloff: float = 2.0
    """ρ, in cells."""


DEFAULT_OPTIONS = MappingOptions()
_NEAR = 12
"""Cells from a stroke within which features are placed with the one that it changes."""
_FRAMES_PER_TURN = 2
"""Under a brush, one of the features that it leaves alone is placed anew once in so many frames."""


@dataclass(frozen=True)
class FeatureReport:
    """What became of a feature."""

    id: int
    nodes: int
    residual: float
    """RMS distance of its nodes from their best-fit similarity (rigid: rotation), over the fit's RMS radius."""
    scale: float
    angle_deg: float


@dataclass(frozen=True, eq=False)
class Warped:
    """A warped grid; positions are (R, C, 2), `rest` in pixels of the picture, the others in output pixels."""

    rest: Points
    plain: Points
    """Where W takes the nodes."""
    warped: Points
    """Where they end."""
    marked: Features
    rigid: bool
    seconds: dict[str, float]
    """Per stage: setup, factor, rhs, solve, and unfold, which holds the solves that it asks for."""

    @cached_property
    def folded(self) -> Bools:
        """Which quads (R-1, C-1) of `warped` are folded."""
        return folded_quads(as_complex(self.warped))

    @cached_property
    def folded_plain(self) -> Bools:
        """Which quads (R-1, C-1) of `plain` are folded."""
        return folded_quads(as_complex(self.plain))

    @cached_property
    def outline_moved_px(self) -> float:
        """How far outline nodes outside features are from W at most: 0 unless there is no other way without folds."""
        edge = self.marked.labels == 0
        edge[1:-1, 1:-1] = False
        away = np.abs(as_complex(self.warped) - as_complex(self.plain))
        return float(away[edge].max(initial=0.0))

    @cached_property
    def features(self) -> list[FeatureReport]:
        """What became of every feature that has a shape, by component number."""
        rest, z = as_complex(self.rest), as_complex(self.warped).ravel()
        found = []
        for body in bodies_of(self.marked, rest):
            alpha, _ = body.fit(z)
            residual = fit_residual(body.arms, z[body.nodes], rigid=self.rigid)
            angle = float(np.degrees(np.angle(alpha)))
            found.append(FeatureReport(body.number, len(body.nodes), residual, abs(alpha), angle))
        return found

    def report(self) -> dict[str, Any]:
        """Return grid, features, folds, seconds and how far the outline gave way, if it did, as plain data for JSON."""
        moved = {"outline_moved_px": self.outline_moved_px} if self.outline_moved_px > 0 else {}
        return {
            "grid": list(self.rest.shape[:2]),
            "features": [asdict(feature) for feature in self.features],
            "folds": {"plain": int(self.folded_plain.sum()), "warped": int(self.folded.sum())},
            "seconds": self.seconds,
            **moved,
        }


def warp_grid(
    grid: Grid,
    features: Features,
    plain: Points,
    *,
    options: MappingOptions = DEFAULT_OPTIONS,
    allow_folds: bool = False,
) -> Warped:
    """Map a grid as close to W as its features allow, without folds where W has none.

    `plain` (R, C, 2) is where W takes the grid's nodes.
    """
    return run(warp_job(grid, features, plain, options=options, allow_folds=allow_folds))


def warp_job(
    grid: Grid,
    features: Features,
    plain: Points,
    *,
    options: MappingOptions = DEFAULT_OPTIONS,
    allow_folds: bool = False,
) -> Job[Warped]:
    """Do what `warp_grid` does, step by step; a step's preview is a first (R, C, 2) without folds."""
    live = LiveWarp(grid)
    live.use(features, options)
    if not allow_folds:
        return (yield from live.settle(plain))
    return live.frame(plain)


class LiveWarp:
    """What an editor keeps between frames: the analysis of the grid and the factor of the mask.

    `use` costs a factorisation when features or options are others than before, `frame` one right-hand side and one
    solve. `settle` is the answer at rest. One thread at a time; a background thread has its own.

    Under a brush, when nothing but one feature changes from one frame to the next, each frame places that one and those
    close by; the others stay where they are, but for one of them in turn every few frames. So a stroke costs the same
    beside many features as beside few.
    """

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self._features = Features(np.zeros(grid.shape, np.int32))
        self._options = MappingOptions(keep="none")
        self._mapping: FeatureMapping | None = None
        self._newest: FeatureMapping | None = None
        """The last mapping there was, which the next one starts from."""
        self._last: _Frame | None = None
        self._turn = 0

    def use(self, features: Features, options: MappingOptions) -> None:
        """Prepare for the given features and options; cheap when they are the same objects as before."""
        if features is self._features and options == self._options:
            return
        if options != self._options:
            self._last = None
        self._mapping = None
        if options.keep != "none":
            self._mapping = FeatureMapping(
                self.grid,
                features,
                keep=options.keep,
                method=options.method,
                weight=options.weight,
                falloff=options.falloff,
                previous=self._newest,
            )
            self._newest = self._mapping
        self._features, self._options = features, options

    def frame(self, plain: Points) -> Warped:
        """Return the linear answer, which may fold, for W at the nodes (R, C, 2).

        Features that the picture's edge cuts are fitted between its nodes, as they are at rest, so that they need not
        jump then.
        """
        mapping = self._mapping
        if mapping is None or not mapping.has_poses:
            self._last = None
            return self._result(plain, plain if mapping is None else mapping.solve(plain), self._seconds())
        pose = self._pose(mapping, plain)
        is_new, self._last = self._last is None or self._last.mapping is not mapping, _Frame(mapping, plain, pose)
        # What is tried on the way takes its time as well.
        seconds: dict[str, float] = {}
        result: _Result = lambda found: self._result(plain, found.positions, seconds)  # noqa: E731
        shown = self._fitted(mapping, pose, result, foresees=not is_new)
        seconds |= self._seconds()
        return shown

    def _fitted(self, mapping: FeatureMapping, pose: Pose, result: "_Result", *, foresees: bool) -> Warped:
        """Return the answer with features that the picture's edge cuts fitted to it, where that folds less.

        Corners that a feature and the outline decide tell in advance that it will not do without. With `foresees` they
        are asked: which they are takes a moment to find out, so that it pays while features stay and W changes.
        """
        shown = None
        if not (foresees and folds_corners(mapping, pose.w, pose.alpha, pose.t)):
            shown = result(mapping.follow(pose))
            if not _rim(shown.folded).any():
                return shown
        if not folded_quads(pose.w).any():
            places = fitted_places(mapping, pose.w, pose.alpha, pose.t)
            fitted = None if places is None else result(mapping.follow(pose, *places))
            if fitted is not None and not fitted.folded.any():
                return fitted
            shown = shown or result(mapping.follow(pose))
            if fitted is not None and fitted.folded.sum() < shown.folded.sum():
                return fitted
        return shown or result(mapping.follow(pose))

    def _pose(self, mapping: FeatureMapping, plain: Points) -> Pose:
        last, w = self._last, as_complex(plain)
        if last is None or last.mapping is mapping or last.plain is not plain:
            return mapping.pose(w)
        before = last.places_in(mapping)
        same = np.flatnonzero(before >= 0)
        came, gone = len(before) - same.size, len(last.mapping.bodies) - same.size
        if came > 1 or gone > came:
            return mapping.pose(w)
        alpha, t = np.zeros((2, len(before)), np.complex128)
        alpha[same], t[same] = last.pose.alpha[before[same]], last.pose.t[before[same]]
        moving = before < 0
        moving[last.bodies_near_change(mapping)] = True
        turn, self._turn = self._turn, self._turn + 1
        if same.size and turn % _FRAMES_PER_TURN == 0:
            moving[same[turn // _FRAMES_PER_TURN % same.size]] = True
        return mapping.pose(w, alpha, t, moving=moving)

    def settle(self, plain: Points) -> Job[Warped]:
        """Return the answer without folds where W has none."""
        if self._mapping is None:
            return self._result(plain, plain, self._seconds())
        with self._mapping.clock.measure("unfold"):
            started = time.perf_counter()
        solution = yield from on_one_thread(unfold(self._mapping, as_complex(plain)))
        return self._result(plain, solution.positions, self._seconds(time.perf_counter() - started))

    def _result(self, plain: Points, warped: Points, seconds: dict[str, float]) -> Warped:
        return Warped(self.grid.nodes, plain, warped, self._features, self._options.keep == "rigid", seconds)

    def _seconds(self, settling: float = 0.0) -> dict[str, float]:
        """Return what the stages took since the last call."""
        seconds = dict.fromkeys(("setup", "factor", "rhs", "solve", "unfold"), 0.0)
        if self._mapping is not None:
            seconds |= self._mapping.clock.take()
        # What settling took beyond one solve; factorisations of its own are part of it.
        seconds["unfold"] = max(0.0, settling - seconds["rhs"] - seconds["solve"])
        return seconds


_Result: TypeAlias = Callable[[Solution], Warped]


def _rim(quads: Bools) -> Bools:
    """Return the values of the quads along the picture's edge."""
    return np.concatenate([quads[0], quads[-1], quads[:, 0], quads[:, -1]])


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
