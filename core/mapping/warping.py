"""A feature-aware warp from W to its report: what the command line, the editor and Python share.

`warp_grid` is the one call; `LiveWarp` is what an editor keeps between frames.
"""

import time
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from core.arrays import Bools, Points
from core.factor import Factor
from core.grid import Features, Grid
from core.mapping.feature_mapping import FeatureMapping, Method
from core.mapping.folds import folded_quads
from core.mapping.frames import as_complex
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
        """Return grid, features, folds and seconds as plain data for JSON."""
        return {
            "grid": list(self.rest.shape[:2]),
            "features": [asdict(feature) for feature in self.features],
            "folds": {"plain": int(self.folded_plain.sum()), "warped": int(self.folded.sum())},
            "seconds": self.seconds,
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
    """Do what `warp_grid` does, step by step; a step's preview is the (R, C, 2) of the moment."""
    live = LiveWarp(grid)
    live.use(features, options)
    if not allow_folds:
        return (yield from live.settle(plain))
    return live.frame(plain)


class LiveWarp:
    """What an editor keeps between frames: the analysis of the grid and the factor of the mask.

    `use` costs a factorisation when features or options are others than before, `frame` one right-hand side and one
    solve. `settle` is the answer at rest. One thread at a time; a background thread has its own.
    """

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self._features = Features(np.zeros(grid.shape, np.int32))
        self._options = MappingOptions(keep="none")
        self._mapping: FeatureMapping | None = None
        self._factor: Factor | None = None

    def use(self, features: Features, options: MappingOptions) -> None:
        """Prepare for the given features and options; cheap when they are the same objects as before."""
        if features is self._features and options == self._options:
            return
        self._mapping = None
        if options.keep != "none":
            self._mapping = FeatureMapping(
                self.grid,
                features,
                keep=options.keep,
                method=options.method,
                weight=options.weight,
                falloff=options.falloff,
                factor=self._factor,
            )
            self._factor = self._mapping.factor
        self._features, self._options = features, options

    def frame(self, plain: Points) -> Warped:
        """Return the linear answer, which may fold, for W at the nodes (R, C, 2)."""
        if self._mapping is None:
            return self._result(plain, plain)
        return self._result(plain, self._mapping.solve(plain))

    def settle(self, plain: Points) -> Job[Warped]:
        """Return the answer without folds where W has none."""
        if self._mapping is None:
            return self._result(plain, plain)
        with self._mapping.clock.measure("unfold"):
            started = time.perf_counter()
        solution = yield from unfold(self._mapping, as_complex(plain))
        return self._result(plain, solution.positions, time.perf_counter() - started)

    def _result(self, plain: Points, warped: Points, settling: float = 0.0) -> Warped:
        seconds = dict.fromkeys(("setup", "factor", "rhs", "solve", "unfold"), 0.0)
        if self._mapping is not None:
            seconds |= self._mapping.clock.take()
        # What settling took beyond one solve; factorisations of its own are part of it.
        seconds["unfold"] = max(0.0, settling - seconds["rhs"] - seconds["solve"])
        return Warped(self.grid.nodes, plain, warped, self._features, self._options.keep == "rigid", seconds)
