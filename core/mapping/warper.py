"""What an editor keeps between frames: the analysis of a grid, the factor of a mask, the structure of handles."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from core.arrays import InputError, Points
from core.grid import Features, Grid
from core.linalg.blas import on_one_thread, one_thread
from core.linalg.grid_solver import GridSolver
from core.linalg.multifrontal import GridFactor
from core.mapping.features.feature_mapping import Choices, FeatureMapping
from core.mapping.features.pose import Solution
from core.mapping.folds import find_folded_quads
from core.mapping.handles.handles import Handles
from core.mapping.handles.solver import HandleSolver, Moved
from core.mapping.handles.straight_frame import constrain_frame
from core.mapping.injective.unfold import unfold
from core.mapping.jacobians import as_complex, as_positions
from core.mapping.options import MappingOptions
from core.mapping.prepared_mask import PreparedMask
from core.mapping.result import NO_PINS, Pins, Warped
from core.mapping.stroke import MaskStroke
from core.progress import Job

_NO_POSES = np.empty(0, np.complex128), np.empty(0, np.complex128)
_LIVE_ROUNDS, _ROUNDS = 1, 20
"""How often at most what handles miss is asked for as well, while something moves and at rest."""


@dataclass(eq=False)
class _Shown:
    """The picture without handles, for one mask and one W."""

    mask: PreparedMask
    plain: Points
    """W at the nodes (R, C, 2)."""
    reference: Solution
    """The linear answer or, once that is known, the one without folds."""
    is_settled: bool


class Warper:
    """What an editor keeps between frames: of a grid the handles' solver, of a mask its factor, of a W the answer.

    `use` costs a factorisation when features or options are others than before, `frame` one right-hand side and one
    solve, and as much again where there are handles. `settle` is the answer at rest. One thread at a time; a background
    thread has its own.

    Handles are applied to the picture as it is without them: at rest, that has no folds where W has none.
    """

    def __init__(self, grid: Grid, *, analyse: Callable[[tuple[int, int]], GridSolver] = GridFactor) -> None:
        self.grid, self._analyse = grid, analyse
        self._features = Features(np.zeros(grid.shape, np.int32))
        self._bare = self._features
        self._options = MappingOptions(keep="none")
        self._mask: PreparedMask | None = None
        self._shown: _Shown | None = None
        self._stroke = MaskStroke()
        self._painted: PreparedMask | None = None
        """A mask that has just been painted on, whose answer is a sketch once."""
        self._handles: HandleSolver | None = None

    def is_ready(self, features: Features, options: MappingOptions) -> bool:
        """Return whether the next answer to these features and options prepares no straight lines."""
        mask = self._mask
        if options.keep == "none" or options.lines is None or self._is_painting(features, options):
            return True
        return mask is not None and mask.fits(features, options) and mask.is_ready

    def _is_painting(self, features: Features, options: MappingOptions) -> bool:
        """Return whether these are other features than before, and kept in the same way."""
        mask = self._mask
        return mask is not None and mask.mapping.features is not features and mask.fits_poses(options)

    def use(self, features: Features, options: MappingOptions) -> None:
        """Prepare for the given features and options; cheap when they are the same objects as before."""
        if options.keep != "none":
            self._prepare(features, options)
        self._features, self._options = features, options

    def _prepare(self, features: Features, options: MappingOptions) -> PreparedMask:
        """Return what features and options need, by way of what was prepared last."""
        mask = self._mask
        if mask is not None and mask.fits(features, options):
            return mask
        is_painted = self._is_painting(features, options)
        if not is_painted:
            self._stroke.forget()
        choices: Choices = {
            "keep": "rigid" if options.keep == "rigid" else "similarity",
            "single": dict(options.single),
            "method": options.method,
            "weight": options.weight,
            "falloff": options.falloff,
        }
        if mask is None:
            mapping = FeatureMapping(self.grid, features, **choices, analyse=self._analyse)
        else:
            mapping = mask.mapping.update(features, **choices)
        pull = mask.pull if mask is not None and is_painted else None
        self._mask = PreparedMask(mapping, options, pull=pull)
        self._painted = self._mask if is_painted else None
        return self._mask

    @property
    def _keeping(self) -> PreparedMask | None:
        """The mask whose features are kept, None where none are."""
        return None if self._options.keep == "none" else self._mask

    def frame(self, plain: Points, handles: Handles | None = None) -> Warped:
        """Return the linear answer, which may fold, for W at the nodes (R, C, 2)."""
        _check_finite(plain)
        reference = self._reference(plain)
        moved = self._moved(reference, handles, rounds=_LIVE_ROUNDS)
        found = self._result(plain, reference, moved, handles, self._seconds())
        return found if moved is None or moved.is_final else replace(found, is_rough=True)

    def learn(self, plain: Points, reference: Solution) -> None:
        """Take it that W at the nodes (R, C, 2) leads to the `reference` at rest, without handles."""
        mask = self._keeping
        if mask is not None and len(reference.alpha) == len(mask.mapping.bodies):
            self._shown = _Shown(mask, plain, reference, is_settled=True)

    def _reference(self, plain: Points) -> Solution:
        """Return the picture without handles: without folds if that is known, else the linear answer."""
        mask, shown = self._keeping, self._shown
        if mask is None:
            self._stroke.forget()
            return Solution(as_complex(plain), *_NO_POSES)
        if not mask.mapping.has_poses:
            return self._refined(mask, plain)
        if shown is None or shown.mask is not mask or shown.plain is not plain:
            found = self._refined(mask, plain)
            self._shown = shown = _Shown(mask, plain, found, is_settled=False)
        return shown.reference

    def _refined(self, mask: PreparedMask, plain: Points) -> Solution:
        """Return the refined linear answer; while the mask is painted on, a sketch of it."""
        painted, self._painted = self._painted, None
        found = mask.answer(plain, self._stroke)
        return mask.sketch(found, plain) if painted is mask else mask.refine(found, plain)

    def _moved(self, reference: Solution, handles: Handles | None, *, rounds: int) -> "Moved | None":
        """Return what the handles make of the reference, None without handles."""
        if handles is None or not handles.any:
            return None
        mapping = self._mapping_of_handles()
        if self._handles is None or self._handles.frame != self._options.frame:
            self._handles = HandleSolver(mapping, self._options.frame)
        with one_thread():
            return self._handles.solve(mapping, reference, handles, rounds=rounds)

    def _mapping_of_handles(self) -> FeatureMapping:
        """Return the mapping that handles act on; it has no features where none are kept."""
        return (self._keeping or self._prepare(self._bare, MappingOptions())).mapping

    def settle(self, plain: Points, handles: Handles | None = None, *, near: Solution | None = None) -> Job[Warped]:
        """Return the answer without folds where W has none; of several, the one that is `near` another's reference."""
        _check_finite(plain)
        started = time.perf_counter()
        reference = yield from on_one_thread(self._unfolded(plain, near))
        if self._handles is not None:
            self._handles.forget()
        moved = self._moved(reference, handles, rounds=_ROUNDS)
        if moved is not None:
            moved = yield from on_one_thread(self._unfolded_handles(reference, moved))
        return self._result(plain, reference, moved, handles, self._seconds(time.perf_counter() - started))

    def folds(self, plain: Points) -> bool:
        """Return whether the linear answer without handles folds where W at the nodes (R, C, 2) does not."""
        mask = self._keeping
        if mask is None or find_folded_quads(as_complex(plain)).any():
            return False
        self._stroke.forget()
        return bool(find_folded_quads(mask.refine(mask.answer(plain, self._stroke), plain).z).any())

    def _unfolded(self, plain: Points, near: Solution | None) -> Job[Solution]:
        """Return the picture without handles and, where W has none, without folds."""
        mask, shown = self._keeping, self._shown
        if mask is None:
            return self._reference(plain)
        if shown is not None and shown.is_settled and shown.mask is mask and shown.plain is plain:
            return shown.reference
        # Whatever was answered before: the same bits.
        self._stroke.forget()
        followed, w = mask.answer(plain, self._stroke), as_complex(plain)
        linear = mask.refine(followed, plain)
        wanted = w if linear is followed else w + (linear.z - followed.z)
        constraints = constrain_frame(mask.mapping, linear.z)
        if near is not None and not _may_be(near, linear, mask.mapping):
            near = None  # of another grid, or of other features
        solution = yield from unfold(
            mask.mapping, wanted, linear, shape=w, scales=np.abs(linear.alpha), constraints=constraints, near=near
        )
        self._shown = _Shown(mask, plain, solution, is_settled=True)
        return solution

    def _unfolded_handles(self, reference: Solution, moved: Moved) -> Job[Moved]:
        """Return a picture that handles have moved, without folds where there were none without them."""
        assert self._handles is not None
        solution = yield from unfold(
            self._mapping_of_handles(),
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
        positions, options = solution.positions, self._options
        return Warped(self.grid, w, positions, self._features, options, seconds, pins=pins, reference=reference)

    def _seconds(self, settling: float = 0.0) -> dict[str, float]:
        """Return what the stages took since the last call."""
        seconds = dict.fromkeys(("setup", "factor", "rhs", "solve", "unfold"), 0.0)
        if self._keeping is not None:
            seconds |= self._keeping.mapping.clock.take()
        # What settling took beyond one solve; factorisations of its own are part of it.
        seconds["unfold"] = max(0.0, settling - seconds["rhs"] - seconds["solve"])
        return seconds


def _may_be(near: Solution, linear: Solution, mapping: FeatureMapping) -> bool:
    """Return whether `near` is of the grid and the bodies of the linear answer, and turns none that stays upright."""
    if (near.z.shape, near.alpha.shape) != (linear.z.shape, linear.alpha.shape):
        return False
    bodies = mapping.bodies[: len(near.alpha)]
    return not any(alpha.imag and not body.limits.turns for alpha, body in zip(near.alpha, bodies, strict=True))


def _check_finite(plain: Points) -> None:
    """Raise `InputError` where W does not take every node (R, C, 2) to a finite position."""
    if not np.isfinite(plain).all():
        raise InputError("warp: does not take every grid node to a finite position")
