"""What an editor keeps between frames: what is prepared for a mask and for handles, and the last answer."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from core.arrays import InputError, Points
from core.grid import Features, Grid
from core.linalg.blas import on_one_thread, one_thread
from core.linalg.grid_solver import GridSolver
from core.linalg.multifrontal import GridFactor
from core.mapping.features.feature_mapping import FeatureMapping
from core.mapping.features.pose import Solution
from core.mapping.features.straight_lines import Pull
from core.mapping.folds import find_folded_quads
from core.mapping.handles.handles import Handles
from core.mapping.handles.solver import HandleSolver, Moved
from core.mapping.handles.straight_frame import constrain_frame
from core.mapping.injective.unfold import unfold
from core.mapping.jacobians import as_complex
from core.mapping.options import MappingOptions
from core.mapping.prepared import Prepared
from core.mapping.result import NO_HANDLES, Warped
from core.mapping.stroke import MaskStroke
from core.progress import Job

_NO_POSES = np.empty(0, np.complex128), np.empty(0, np.complex128)
_LIVE_ROUNDS, _ROUNDS = 1, 20
"""How often at most what handles miss is asked for as well, while something moves and at rest."""


@dataclass(eq=False)
class LastAnswer:
    """What the next answer goes on from, or is, where nothing changed."""

    mask: Prepared | None = None
    """What was answered with, None where no features are kept,"""
    plain: Points | None = None
    """W at the nodes (R, C, 2),"""
    reference: Solution | None = None
    """and the picture without handles: the linear answer or, once that is known, the one without folds."""
    is_settled: bool = False
    pull: Pull | None = None
    """What drew lines straight, under this mask or the one before."""
    stroke: MaskStroke = field(default_factory=MaskStroke)
    """Where features were."""
    handles: HandleSolver | None = None
    """How handles moved it."""

    def wait(self) -> None:
        """Return once nothing is worked out beside."""
        if self.handles is not None:
            self.handles.wait()

    def is_of(self, mask: Prepared | None, plain: Points) -> bool:
        """Return whether the picture without handles was for this mask and W."""
        return self.reference is not None and self.mask is mask and self.plain is plain


class Warper:
    """What an editor keeps between frames, in two places: what is prepared, and the last answer.

    `use` costs a factorisation when features or options are others than before, `frame` one right-hand side and one
    solve, and as much again where there are handles. `settle` is the answer at rest. One thread at a time; a background
    thread has its own. Features, options and W are taken to be as before where they are the same objects.

    Handles are applied to the picture as it is without them: at rest, that has no folds where W has none.
    """

    def __init__(self, grid: Grid, *, analyse: Callable[[tuple[int, int]], GridSolver] = GridFactor) -> None:
        self.grid, self._analyse = grid, analyse
        self._features = Features(np.zeros(grid.shape, np.int32))
        self._bare = self._features
        self._options = MappingOptions(keep="none")
        self._prepared: Prepared | None = None
        self._last = LastAnswer()

    def is_ready(self, features: Features, options: MappingOptions) -> bool:
        """Return whether the next answer to these features and options prepares no straight lines, and no mask anew.

        A mask is painted on where any node stays in a feature.
        """
        mask = self._prepared
        if options.keep == "none":
            return True
        if mask is not None and not mask.is_painted_on(features):
            return False
        if options.lines is None:
            return True
        return mask is not None and (
            mask.is_other_mask(features, options) or (mask.fits(features, options) and mask.is_ready)
        )

    def use(self, features: Features, options: MappingOptions) -> None:
        """Prepare for the given features and options; cheap when they are the same objects as before."""
        self._last.wait()
        if options.keep != "none":
            self._prepare(features, options)
        self._features, self._options = features, options

    def _prepare(self, features: Features, options: MappingOptions) -> Prepared:
        """Return what features and options need, by way of what was prepared last."""
        mask = self._prepared
        if mask is not None and mask.fits(features, options):
            return mask
        if mask is None:
            self._prepared = Prepared.of(self.grid, features, options, self._analyse)
        else:
            self._prepared = mask.update(features, options)
        is_painted, last = self._prepared.is_painted, self._last
        self._last = (
            LastAnswer(pull=last.pull, stroke=last.stroke, handles=last.handles) if is_painted else LastAnswer()
        )
        return self._prepared

    @property
    def _keeping(self) -> Prepared | None:
        """What is prepared where features are kept, None where none are."""
        return None if self._options.keep == "none" else self._prepared

    def frame(self, plain: Points, handles: Handles | None = None) -> Warped:
        """Return the linear answer, which may fold, for W at the nodes (R, C, 2)."""
        self._last.wait()
        if plain is not self._last.plain:
            _check_finite(plain)
        self._prepare_handles(handles)
        reference = self._reference(plain)
        moved = self._moved(reference, handles, rounds=_LIVE_ROUNDS)
        found = self._result(plain, reference, moved, handles, self._seconds())
        return found if moved is None or moved.is_final else replace(found, is_rough=True)

    def look_ahead(self) -> None:
        """Begin beside what the next frame of a drag needs of this one, once nothing more is done for this one."""
        if self._last.handles is not None and self._last.reference is not None:
            self._last.handles.look_ahead(self._last.reference)

    def learn(self, plain: Points, reference: Solution) -> None:
        """Take it that W at the nodes (R, C, 2) leads to the `reference` at rest, without handles."""
        mask = self._keeping
        if mask is not None and len(reference.alpha) == len(mask.mapping.bodies):
            self._keep(plain, reference, is_settled=True)

    def _keep(self, plain: Points, reference: Solution, *, is_settled: bool) -> Solution:
        """Keep the picture without handles, and return it."""
        last = self._last
        last.mask, last.plain, last.reference, last.is_settled = self._keeping, plain, reference, is_settled
        return reference

    def _reference(self, plain: Points) -> Solution:
        """Return the picture without handles: without folds if that is known, else the linear answer.

        The first one under a mask that is painted on is a sketch.
        """
        mask, last = self._keeping, self._last
        if last.is_of(mask, plain) and last.reference is not None:
            return last.reference
        if mask is None:
            last.stroke.forget()
            return self._keep(plain, Solution(as_complex(plain), *_NO_POSES), is_settled=False)
        found = mask.answer(plain, last.stroke)
        if mask.is_painted and last.mask is not mask:
            return self._keep(plain, mask.sketch(found, plain, last.pull), is_settled=False)
        found, last.pull = mask.refine(found, plain)
        return self._keep(plain, found, is_settled=False)

    def _moved(self, reference: Solution, handles: Handles | None, *, rounds: int) -> "Moved | None":
        """Return what the handles make of the reference, None without handles."""
        if handles is None or not handles.any:
            return None
        mask, (probes, asked) = self._mask_of_handles(), handles.probes(self.grid)
        structure = mask.hold(probes, handles.are_pins(probes.at), self._options.frame)
        if self._last.handles is None or self._last.handles.structure is not structure:
            self._last.handles = HandleSolver(structure, self._last.handles)
        with one_thread():
            return self._last.handles.solve(reference, asked, rounds=rounds)

    def _prepare_handles(self, handles: Handles | None) -> None:
        """Prepare what handles act on: what is prepared later would make the last answer another mask's."""
        if handles is not None and handles.any:
            self._mask_of_handles()

    def _mask_of_handles(self) -> Prepared:
        """Return what handles act on; it has no features where none are kept."""
        return self._keeping or self._prepare(self._bare, MappingOptions())

    def settle(self, plain: Points, handles: Handles | None = None, *, near: Solution | None = None) -> Job[Warped]:
        """Return the answer without folds where W has none; of several, the one that is `near` another's reference."""
        _check_finite(plain)
        self._last.wait()
        started = time.perf_counter()
        self._prepare_handles(handles)
        reference = yield from on_one_thread(self._unfolded(plain, near))
        self._last.handles = None
        if self._prepared is not None:
            self._prepared.forget_handles()
        moved = self._moved(reference, handles, rounds=_ROUNDS)
        if moved is not None:
            moved = yield from on_one_thread(self._unfolded_handles(reference, moved))
        return self._result(plain, reference, moved, handles, self._seconds(time.perf_counter() - started))

    def folds(self, plain: Points) -> bool:
        """Return whether the linear answer without handles folds where W at the nodes (R, C, 2) does not."""
        mask = self._keeping
        if mask is None or find_folded_quads(as_complex(plain)).any():
            return False
        self._last.wait()
        self._last.stroke.forget()
        found, _ = mask.refine(mask.answer(plain, self._last.stroke), plain)
        return bool(find_folded_quads(found.z).any())

    def _unfolded(self, plain: Points, near: Solution | None) -> Job[Solution]:
        """Return the picture without handles and, where W has none, without folds."""
        mask, last = self._keeping, self._last
        if mask is None or (last.is_settled and last.is_of(mask, plain)):
            return self._reference(plain)
        # Whatever was answered before: the same bits.
        last.stroke.forget()
        followed, w = mask.answer(plain, last.stroke), as_complex(plain)
        linear, last.pull = mask.refine(followed, plain)
        wanted = w if linear is followed else w + (linear.z - followed.z)
        constraints = constrain_frame(mask.mapping, linear.z)
        if near is not None and not _may_be(near, linear, mask.mapping):
            near = None  # of another grid, or of other features
        solution = yield from unfold(
            mask.mapping, wanted, linear, shape=w, scales=np.abs(linear.alpha), constraints=constraints, near=near
        )
        return self._keep(plain, solution, is_settled=True)

    def _unfolded_handles(self, reference: Solution, moved: Moved) -> Job[Moved]:
        """Return a picture that handles have moved, without folds where there were none without them."""
        assert self._last.handles is not None
        solution = yield from unfold(
            self._mask_of_handles().mapping,
            reference.z + moved.field.whole,
            moved.solution,
            shape=reference.z,
            scales=np.abs(moved.solution.alpha),
            constraints=self._last.handles.constrain(reference, moved),
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
        return Warped(
            self.grid,
            plain,
            solution.positions,
            self._features,
            self._options,
            seconds,
            handles=handles or NO_HANDLES,
            reference=reference,
            field=None if moved is None else moved.field,
            folds=solution.folded,
        )

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
    if not np.isfinite(plain.sum()):  # a fraction of what it takes to ask each
        raise InputError("warp: does not take every grid node to a finite position")
