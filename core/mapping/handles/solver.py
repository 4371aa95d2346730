"""The linear answer to handles: the picture as it is without them, displaced so that every handle holds.

The picture without handles, z⁰ with features at (α⁰, t⁰), costs nothing; handles cost what they displace. In turn:

1. features that handles place get the similarity that these ask for (`poses`);
2. a plate with rigid inclusions gives all others theirs, and the background its displacement D (`plate`);
   sizes stay, unless two handles in a feature change its size; straight lines are rods in it (`rods`);
3. free nodes follow D and the features as FAT eqs. 3 and 4 have it for displacements, with every point of the
   background that a handle holds as a hard constraint (`FeatureMapping.place_held`).

Whatever does not move at all is therefore left as it is to the last bit.
"""

import copy
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np

from core.grid import DEFAULT_NODES_AT_MOST
from core.linalg.blas import one_thread
from core.linalg.cubic_convolution import Smooth
from core.linalg.multifrontal import GridFactor
from core.mapping.features.pose import Approach, Solution
from core.mapping.features.recycled import Recycled
from core.mapping.handles.constraints import SCALE, Constraints
from core.mapping.handles.frame_glide import Knots, glide_beside
from core.mapping.handles.motions import Poses
from core.mapping.handles.plate import HandleField
from core.mapping.handles.secants import Secants
from core.mapping.handles.straight_frame import Rectangle, constrain_frame, freedom_of, pivot_of
from core.mapping.handles.structure import Structure
from core.mapping.handles.turned import Base, Turned
from core.mapping.jacobians import Complexes, as_complex
from core.mapping.tolerances import LITTLE, MET_PX, SEEN_PX

_POSE_STEPS = 2
"""Newton steps by which bodies are placed, in every round."""
_ROUNDS_PER_TURN = 4
"""So many rounds to each time that the local rotation is taken anew; fewer take that of the last answer."""
_PATIENCE = 3
"""Rounds end when so many have missed about as much as the best one, or more."""
_SAMPLED = 16
"""One of so many rows and columns of nodes is looked at first."""
_BESIDE = ThreadPoolExecutor(1, "rotation")
"""Where the next answer's rotation is taken, and what it will ask for is learnt, while this one is drawn."""


@dataclass(frozen=True, eq=False)
class Moved:
    """A picture that handles have moved."""

    solution: Solution
    field: Smooth
    """D (R, C), the displacement of the background."""
    goal: Complexes
    """By how much each handle is to move its point (k,)."""
    is_final: bool = True
    """Whether another answer to the same handles would not be nearer to that at rest, but for what does not show."""


class HandleSolver:
    """Answers handles at the places of one structure, each time from the last answer on.

    `before` has answered those of another structure: how far the picture was turned is known from there and, where its
    handles were the same, what they are to be asked for.
    """

    def __init__(self, structure: Structure, before: "HandleSolver | None" = None) -> None:
        self.structure = structure
        is_same = before is not None and before.structure.holds_same(structure)
        self._secants: Secants = before._secants if is_same and before is not None else Secants()
        if before is not None and before.structure.field.grid != structure.field.grid:
            before = None
        self._reference: Solution | None = None if before is None else before._reference
        """The picture that was moved last,"""
        self._base: Base | None = None if before is None else before._base
        """where it has the plate's nodes,"""
        self._d: Complexes | None = None if before is None else before._d
        """and their last displacement (r, c)."""
        factor, is_small = structure.mapping.factor, structure.mapping.grid.size <= DEFAULT_NODES_AT_MOST
        self._recycled = Recycled(factor, structure.held) if isinstance(factor, GridFactor) and is_small else None
        """What answers while something moves tell of the next one, on a grid of which a table has many rows."""
        self._is_new = True
        """Whether it has not answered yet: what pays off with the next answer is not begun with the first."""
        self._asked: Complexes | None = None
        """What handles were asked for last,"""
        self._expected: Complexes | None = None
        """and what they will be asked for next, if all goes on as it does."""
        self._explores = False
        """Whether what was expected of the last answer had anything new."""
        self._is_asked = False
        """Whether anything was asked for since the last look ahead."""
        self._begun: Solution | None = None
        """The picture for which all that a drag begins with was got ready at rest."""
        self._ahead: Callable[[], Turned] | None = None
        """Finds what the last answer turns the background into, which the next one to the same picture begins with,"""
        self._turned: Turned | None = None
        """and what it has found."""
        self._beside: Future[None] | None = None
        """What is worked out beside,"""
        self._is_awaited = False
        """and whether the next answer waits for it: then nothing is imagined."""

    def solve(self, reference: Solution, asked: Complexes, *, rounds: int) -> Moved:
        """Return where handles that ask for `asked` (k,) move the `reference`.

        So many times, if need be, what the features around make pins of the background miss is asked for as well: then
        the plate alone holds them, smoothly, and one that is set later where it is already changes nothing.
        """
        s, mapping = self.structure, self.structure.mapping
        goal = self._find_goal(s, reference, asked)
        self._expected = None if self._asked is None else 2 * asked - self._asked
        self._asked, self._is_asked = asked, True
        base, stays = self._base, self._reference is reference
        if base is None or not stays:
            base = Base.of(s.field.sample(reference.z))
            self._reference, self._base, self._turned = reference, base, None
        if not goal.any():
            return Moved(reference, Smooth(np.zeros_like(reference.z)), goal)
        is_straight = _is_straight(reference.z, s.field)
        with mapping.clock.measure("rhs"):
            poses = self._pose_held(s, reference, goal, asked, is_straight=is_straight)
            sides = self._move_frame(s, reference, poses, goal, is_straight=is_straight)
            turned = self._first_turned(s, reference, poses, goal, sides, slides=is_straight)
        is_live = rounds < _ROUNDS_PER_TURN
        recycles, self._is_new = is_live and not self._is_new, False
        known = self._recycled if recycles else None
        for _ in range(max(rounds // _ROUNDS_PER_TURN, 1)):
            found = self._converge(s, reference, poses, goal, turned, sides, rounds, recycles=recycles)
            if is_live:
                break
            again = s.field.turn(base, found.d, sides, slides=is_straight)
            if again.differs_px(turned) < MET_PX:
                break
            turned = again
        last, self._d = self._d, found.d
        moves = last is None or _has_moved(found.d, last, SEEN_PX / 2)
        solution = mapping.hold(found.approach, s.held, reference.z, found.alpha, found.t, known)
        if stays and sides is None and is_live:
            self._ahead = partial(s.field.turn, base, found.d, None, slides=is_straight)
        return Moved(solution, found.D, goal, is_final=not moves)

    def wait(self) -> None:
        """Return once nothing is worked out beside: nobody else uses the factor meanwhile."""
        beside, self._beside = self._beside, None
        if beside is not None:
            self._is_awaited = True
            try:
                beside.result()
            finally:
                self._is_awaited = False

    def look_ahead(self, reference: Solution) -> None:
        """Begin beside what the next answer needs of this one, once nothing more is done for this one.

        Once nothing is asked for, that is what a drag of the `reference` begins with.
        """
        turn, self._ahead = self._ahead, None
        rests, self._is_asked = not self._is_asked, False
        if turn is not None:
            self._beside = _BESIDE.submit(self._prepare, turn)
        elif rests and self._asked is not None and self._begun is not reference and self._recycled is not None:
            self._begun, self._is_new = reference, False
            self._beside = _BESIDE.submit(self._begin, reference, self._asked)

    def _prepare(self, turn: Callable[[], Turned]) -> None:
        """Find what the picture is turned into, and learn from what was asked for, and from what will be."""
        self._turned = turn()
        explores, self._explores = self._explores or self._is_new_in_part, False
        self._learn()
        if explores and self._recycled is not None and self._expected is not None and not self._is_awaited:
            self._imagine(self._expected)
            self._explores = self._is_new_in_part
            if not self._is_awaited:
                self._learn()

    def _begin(self, reference: Solution, asked: Complexes) -> None:
        """Answer as handles are, and from that answer on once more, and as if they were a little elsewhere."""
        for _ in range(2):
            with one_thread():
                self.solve(reference, asked, rounds=1)
        if self._ahead is not None:
            self._turned, self._ahead = self._ahead(), None
        self._imagine(np.where(self.structure.probes.are_rings, asked, asked + SEEN_PX))
        self._learn()

    @property
    def _is_new_in_part(self) -> bool:
        """Whether the last answer had anything that those before it had not."""
        return self.structure.field.is_new or (self._recycled is not None and self._recycled.is_new)

    def _learn(self) -> None:
        """Let the next answers be nearer to the exact ones."""
        self.structure.field.learn()
        if self._recycled is not None:
            self._recycled.learn()

    def _imagine(self, asked: Complexes) -> None:
        """Answer as if handles were asked for that, for what is learnt by it."""
        assert self._reference is not None
        other = copy.copy(self)
        other._secants = copy.copy(self._secants)
        with one_thread():
            other.solve(self._reference, asked, rounds=1)
        self.structure.mapping.clock.take()

    def _first_turned(
        self, s: Structure, reference: Solution, poses: Poses, goal: Complexes, sides: Complexes | None, *, slides: bool
    ) -> Turned:
        """Return what turning does to the background: as in the last frame, or as if nothing turned far."""
        assert self._base is not None
        turned, self._turned, self._ahead = self._turned, None, None
        if turned is not None and sides is None:
            return turned
        d = self._d
        if d is None:
            d = self._displace(s, reference, poses, goal, s.field.still(self._base, slides=slides), recycles=False)
        return s.field.turn(self._base, d, sides, slides=slides)

    def _converge(
        self,
        s: Structure,
        reference: Solution,
        poses: Poses,
        goal: Complexes,
        turned: Turned,
        sides: Complexes | None,
        rounds: int,
        *,
        recycles: bool,
    ) -> "_Found":
        """Return the displacement of the background for which the plate alone holds handles, as nearly as it comes."""
        close_px = MET_PX if rounds >= _ROUNDS_PER_TURN else SEEN_PX / 2
        pins, known = s.rows[s.alone], self._recycled if recycles else None
        asked = goal.copy()
        asked[pins] = self._secants.begin(goal[pins], SEEN_PX / 2)
        best: _Found | None = None
        vain = 0
        for number in range(rounds + 1):
            d = self._displace(s, reference, poses, asked, turned, recycles=recycles)
            D = s.field.refine(d, sides)
            self._pose_small(s, reference, poses, D)
            alpha, t = poses.alpha - reference.alpha, poses.t - reference.t
            to_rows = np.where(s.owners < 0, goal, 0)
            for hold in s.holds.values():
                to_rows[hold.points] = alpha[hold.body] * hold.arms + t[hold.body]
            approach = s.mapping.approach(D, alpha, t, s.held, to_rows[s.rows], known)
            misses = approach.missed[s.alone]
            missed = float(np.abs(misses).max(initial=0))
            vain = 0 if best is None or missed < (1 - LITTLE) * best.missed else vain + 1
            if best is None or missed < best.missed:
                best = _Found(missed, approach, d, D, poses.alpha.copy(), poses.t.copy(), asked[pins])
            self._secants.learn(asked[pins], goal[pins] - misses)
            if number == rounds or vain == _PATIENCE or missed < close_px:
                break
            asked[pins] = self._secants.step(goal[pins])
        assert best is not None
        self._secants.learn(best.asked, goal[pins] - best.approach.missed[s.alone])
        return best

    def _find_goal(self, s: Structure, reference: Solution, asked: Complexes) -> Complexes:
        """Return by how much each handle (k,) is to change what it reads; exactly 0 where it reads that already."""
        there = s.probes.read(s.mapping.grid, reference.z)
        to = asked if s.field.is_free else _inside(asked, reference.z)
        goal = np.where(s.probes.are_rings, (asked - 1) * there, to - there)
        goal[np.abs(goal) < MET_PX] = 0
        return np.asarray(goal)

    def _displace(
        self, s: Structure, reference: Solution, poses: Poses, asked: Complexes, turned: Turned, *, recycles: bool
    ) -> Complexes:
        """Return d (r, c) for the displacements `asked` of handles (k,), beside `turned`; place the plate's bodies."""
        already = s.field.at_points(turned.y)
        for _ in range(_POSE_STEPS):
            known = self._know(s, reference, poses, asked) - already
            s.motions.move(poses, s.field.find_motions(known, s.motions.directions(poses.alpha), turned))
        return turned.y + s.field.displace(self._know(s, reference, poses, asked) - already, turned, recycles=recycles)

    def constrain(self, reference: Solution, moved: Moved) -> Constraints:
        """Return the constraints that the handles of the last answer, `moved`, and the frame are.

        Rigid features keep the size that they have without handles: before that yields, handles do.
        """
        s, mapping = self.structure, self.structure.mapping
        bodies = mapping.moved_bodies
        rest = as_complex(mapping.grid.nodes)
        none = Constraints.none(bodies, rest) if s.field.is_free else constrain_frame(mapping, reference.z)
        pivots, free = none.pivots.copy(), none.free.copy()
        for i, hold in s.holds.items():
            if _is_straight(reference.z, s.field) and s.cut[i].any():
                free[i] = False
            elif hold.is_one_place:
                pivots[i], free[i, 2:] = rest.ravel()[bodies[i].nodes].mean() + hold.arm, False
            else:
                free[i] = False
        free[[body.limits.fix_size for body in bodies], SCALE] = False
        to = s.held.read(reference.z.ravel()[s.held.nodes]) + moved.goal[s.rows]
        return Constraints(s.probes[s.rows], to, pivots, free, none.glide, is_free=s.field.is_free)

    def _pose_held(
        self, s: Structure, reference: Solution, goal: Complexes, asked: Complexes, *, is_straight: bool
    ) -> Poses:
        """Return the similarities of the bodies that handles place; those of the others as they are."""
        none = np.full(len(reference.alpha), np.nan, np.complex128)
        poses = Poses(reference.alpha.copy(), reference.t.copy(), none)
        rest = as_complex(s.mapping.grid.nodes)
        for i, hold in s.holds.items():
            alpha, t = complex(reference.alpha[i]), complex(reference.t[i])
            places, turned = alpha * hold.arms + t + goal[hold.points], alpha * asked[hold.rings]
            if is_straight and s.cut[i].any():
                middle = complex(rest.ravel()[s.mapping.bodies[i].nodes].mean())
                pivot = pivot_of(s.cut[i], rest, middle) - middle
                free = freedom_of(s.cut[i])
                free[0] &= not s.mapping.bodies[i].limits.fix_size
                poses.alpha[i], poses.t[i] = hold.slide(places, turned, alpha, t, free, pivot)
            elif hold.is_one_place:
                poses.pivots[i] = complex(places.mean())
                poses.t[i] = poses.pivots[i] - alpha * hold.arm
            else:
                poses.alpha[i], poses.t[i] = hold.fit(places, turned, alpha, s.mapping.bodies[i].limits)
        return poses

    def _know(self, s: Structure, reference: Solution, poses: Poses, asked: Complexes) -> Complexes:
        """Return the displacements of the plate's points, for what is `asked` of handles (k,) and bodies at `poses`."""
        known = s.motions.displace(poses, reference.alpha, reference.t)
        known[: len(s.outside)] = asked[s.outside]
        return known

    def _pose_small(self, s: Structure, reference: Solution, poses: Poses, D: Smooth) -> None:
        """Place the bodies that are too many for the plate where D has them, at the sizes that they have."""
        small = s.small
        if small.any():
            turned, moved = s.mapping.fit_bodies(D)
            alpha = np.where(s.turns, reference.alpha + turned, reference.alpha)
            kept = np.divide(np.abs(reference.alpha), np.abs(alpha), out=np.zeros(len(alpha)), where=alpha != 0)
            poses.alpha[small] = np.where(alpha != 0, alpha * kept, reference.alpha)[small]
            poses.t[small] = (reference.t + moved)[small]

    def _move_frame(
        self, s: Structure, reference: Solution, poses: Poses, goal: Complexes, *, is_straight: bool
    ) -> Complexes | None:
        """Return the displacements (R, C) of a straight frame: of cut bodies, of points on it, and between them.

        Points that lie on the frame slide along their side; where W bends it, they stay. None where all of it stays.
        """
        if not is_straight or not (s.at_frame.size or any(s.cut[i].any() for i in s.holds)):
            return None
        found = np.zeros_like(reference.z)
        for i in np.flatnonzero(s.cut.any(axis=1)):
            body = s.mapping.bodies[i]
            moved = (poses.alpha[i] - reference.alpha[i]) * body.arms + poses.t[i] - reference.t[i]
            found.ravel()[body.nodes] = moved
        knots = Knots.of(s.mapping.grid, s.probes.at[s.at_frame], goal[s.at_frame])
        frame = glide_beside(found, np.zeros_like(found), s.mapping.index, knots)
        return np.where(s.mapping.grid.outline, frame, 0)


@dataclass(frozen=True, eq=False)
class _Found:
    """The best displacement of the background so far."""

    missed: float
    """By how much pins in the background miss, in output pixels, where nothing but the plate holds them."""
    approach: Approach
    d: Complexes
    """At the plate's nodes (r, c),"""
    D: Smooth
    """and at the picture's (R, C)."""
    alpha: Complexes
    t: Complexes
    asked: Complexes
    """What these pins were asked for."""


def _has_moved(d: Complexes, last: Complexes, px: float) -> bool:
    """Return whether any node (r, c) has moved by more than so many pixels; a few of them mostly tell."""
    return any(np.abs(d[::k, ::k] - last[::k, ::k]).max() > px for k in (_SAMPLED, 1))


def _is_straight(z: Complexes, field: HandleField) -> bool:
    """Return whether a frame at z (R, C) is held, and a rectangle."""
    return not field.is_free and Rectangle.of(z) is not None


def _inside(to: Complexes, z: Complexes) -> Complexes:
    """Return targets (k,), those outside the box around a held frame, z (R, C), at its edge: none gets further."""
    frame = np.concatenate([z[0], z[-1], z[:, 0], z[:, -1]])
    x, y = (np.clip(part(to), part(frame).min(), part(frame).max()) for part in (np.real, np.imag))
    return np.asarray(x + 1j * y)
