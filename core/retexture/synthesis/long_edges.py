"""Long edges near moved curves, along which structure goes on  [Sun et al. 2005, "Structure propagation"].

A rail, a paling or a leash that is read in the coordinates of a moved curve would be bent, stepped or doubled. As a
passive curve it goes where the plain deformation takes it, and texture beside it is read along it. Long edges are
chains of straight ones [LSD, von Gioi et al. 2010].

Strokes of a texture that follows the curve are long edges too. They keep their angle to the curve, structure keeps its
own direction: of edges beside a curve, with directions a and b from the curve's at their feet, the circular variances
1 - |mean exp 2ia| and 1 - |mean exp 2ib| tell which.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, TypeAlias

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve
from core.curves.fitting import fit
from core.curves.polylines import Polylines, count_up
from core.linalg.nearest import Nearest
from core.retexture.deformation.coordinates import Feet, SpineCurves
from core.retexture.synthesis.patches import PatchShape

SHORTEST_PX = 8.0
"""Straight edges that are shorter, at the size at which they are found, are grain."""
GAP_PX, BEND = 6.0, np.cos(np.radians(30.0))
"""One edge leads on to another that begins so near to its end, and turns by no more: by its cosine."""
PARALLEL = np.cos(np.radians(30.0))
"""Cosine of the angle to a drawn curve within which an edge beside it runs along it, and is read in its coordinates."""
BORDER_PX = 3.0
"""An edge that lies nearer to the picture's border is the border."""
STEP_PX = 4.0
"""Edges are looked at in places so far apart."""
STROKES, FEWEST = 1.15, 5
"""Edges on a side of a curve are strokes if their own directions vary so many times as much as their angles to it, and
there are so many. Learnt: twenty painted textures lie at 1.24 and above, structure in twelve photographs at 1.05 and
below."""

UNSURE = 0.01
"""Circular variance of directions that are known to 4 degrees."""
GROUP = 3
"""So many edges side by side repeat."""


Side: TypeAlias = tuple[int, bool]
"""A curve's number and whether its positive side is meant."""


@dataclass(frozen=True)
class LongEdges:
    """What goes on near moved curves."""

    curves: tuple[Curve, ...] = ()
    """Edges of the picture, the longest first."""
    structured: frozenset[Side] = frozenset()
    """Sides of drawn curves whose edges keep their own direction, whatever the curve's: no texture of it lies there."""

    def but(self, left_out: Sequence[tuple[float, float]], near_px: float) -> "LongEdges":
        """Return the same without edges that pass within `near_px` of one of some points (x, y)."""
        return replace(self, curves=tuple(edge for edge in self.curves if not passes(edge, left_out, near_px)))


def find_long_edges(picture: Singles, curves: list[FeatureCurve], patch: PatchShape, reach_px: float) -> LongEdges:
    """Return the edges of a picture (H, W, 3), longer than a patch, near moved `curves`, and what they tell of sides.

    Near is within `reach_px` of where a curve is or goes. Edges that run along a drawn curve are left out, and of those
    that run side by side, closer than half a patch is wide, the shorter ones. So near to a drawn curve an edge ends:
    what lies there is read along the curve.
    """
    drawn = [line for curve in curves for line in (curve.source, curve.target) if line is not None]
    moved = [line for curve in curves if curve.target for line in (curve.source, curve.target)]
    own, near = SpineCurves([curve.source for curve in curves]), SpineCurves(moved)
    edges = _follow(_find_chains(picture, drawn, patch, reach_px), own, near, reach_px)
    sides: dict[Side, list[_Edge]] = {}
    for edge in edges:
        sides.setdefault(edge.side, []).append(edge)
    room = {side: reach_px * curves[side[0]].source.length / (2 * patch.rib + 1) for side in sides}
    verdicts = {side: _judge(beside, reach_px, room[side]) for side, beside in sides.items()}
    structure, unsure = ([edge for edge in edges if verdicts[edge.side] == kind] for kind in ("structure", "unsure"))
    edges = structure + _leave_out_repeated(unsure, patch.rib)
    chosen: list[_Edge] = []
    for edge in sorted(edges, key=lambda edge: -len(edge.places)):
        if edge.runs_along(2.0 * patch.spine + 1):
            continue
        if not any(edge.is_beside(other, patch.rib) for other in chosen):
            chosen.append(edge)
    structured = frozenset(side for side, verdict in verdicts.items() if verdict == "structure")
    free = (_longest_run(edge.places, own.distance(edge.places) > patch.rib) for edge in chosen)
    return LongEdges(tuple(fit(places) for places in free if len(places) > 1), structured)


def passes(edge: Curve, points: Sequence[tuple[float, float]], near_px: float) -> bool:
    """Return whether an edge passes within `near_px` of any of some points (x, y)."""
    return bool(len(points)) and bool((edge.nearest(np.array(points, np.float64))[1] < near_px).any())


@dataclass(frozen=True, eq=False)
class _Edge:
    """An edge of the picture beside curves."""

    places: Points
    """(k, 2) along it."""
    way: Points
    """(k, 2) unit tangents."""
    feet: Feet
    """The nearest places of the curves."""

    @cached_property
    def low(self) -> Points:
        """The least x and y of its places."""
        return np.asarray(self.places.min(axis=0))

    @cached_property
    def high(self) -> Points:
        """The greatest x and y of its places."""
        return np.asarray(self.places.max(axis=0))

    @property
    def side(self) -> Side:
        """The curve that most of it is nearest to, and whether most of it lies on that curve's positive side."""
        curve = int(np.bincount(self.feet.curve).argmax())
        return curve, bool((self.feet.offset[self.feet.curve == curve] > 0).mean() > 0.5)

    @property
    def directions(self) -> tuple[complex, complex]:
        """The means of exp 2ia of its own directions and of those from the curve's: of lines, that have no sense."""
        way, heading = (part[:, 0] + 1j * part[:, 1] for part in (self.way, self.feet.heading))
        return complex((way**2).mean()), complex(((way / heading) ** 2).mean())

    def is_beside(self, other: "_Edge", near_px: float) -> bool:
        """Return whether most of it lies within `near_px` of another one."""
        if (self.low > other.high + near_px).any() or (other.low > self.high + near_px).any():
            return False
        return bool((Nearest(other.places).to(self.places)[0] < near_px).mean() > 0.5)

    def sense_of(self, other: "_Edge") -> float:
        """Return the cosine of the angle between its way, as a whole, and another one's."""
        own, its = self.places[-1] - self.places[0], other.places[-1] - other.places[0]
        return float(own @ its / max(np.linalg.norm(own) * np.linalg.norm(its), 1e-9))

    def runs_along(self, near_px: float) -> bool:
        """Return whether most of it lies within `near_px` of curves that run as it does."""
        cosine = np.abs((self.feet.heading * self.way).sum(axis=1))
        return bool(((cosine > PARALLEL) & (np.abs(self.feet.offset) < near_px)).mean() > 0.5)


def _follow(lines: Polylines, own: SpineCurves, near: SpineCurves, reach_px: float) -> list[_Edge]:
    """Return the edges along `lines` that come within `reach_px` of `near`, with their feet on curves' `own` places."""
    if not len(lines.count):
        return []
    lines = lines.resample(STEP_PX)
    lines = lines.take(np.flatnonzero(~lines.all(near.distance(lines.places) > reach_px)))
    feet, way = own.feet(lines.places), lines.tangent
    return [_Edge(lines.places[part], way[part], feet.taken(part)) for part in lines.split()]


def _longest_run(places: Points, kept: Bools) -> Points:
    """Return the longest run (k, 2) of `places` (n, 2) that are `kept` (n,)."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], kept, [False]]).astype(int)))
    starts, stops = ends[::2], ends[1::2]
    longest = int((stops - starts).argmax()) if len(starts) else 0
    return places[starts[longest] : stops[longest]] if len(starts) else places[:0]


def _judge(edges: list[_Edge], reach_px: float, room_px: float) -> Literal["structure", "texture", "unsure"]:
    """Return what edges on one side of a curve are, by those within `reach_px` of it.

    Beside a straight curve directions do not tell. There, what is longer in all than a band as wide as a patch has room
    for on that side, `room_px`, lies everywhere and is texture.
    """
    near = [edge for edge in edges if np.abs(edge.feet.offset).min() <= reach_px]
    if len(near) < FEWEST:
        return "unsure"
    own, along = 1 + UNSURE - np.abs(np.mean([edge.directions for edge in near], axis=0))
    if own > STROKES * along:
        return "texture"
    if along > STROKES * own:
        return "structure"
    return "texture" if STEP_PX * sum(len(edge.places) - 1 for edge in near) > room_px else "unsure"


def _leave_out_repeated(edges: list[_Edge], near_px: float) -> list[_Edge]:
    """Return the edges but for those of groups that run side by side with the dark on the same hand, `near_px` apart.

    What repeats within a patch is texture where nothing tells otherwise. Two edges of a rail have it on either hand.
    """
    alike = np.array([[a.is_beside(b, near_px) and a.sense_of(b) > 0 for b in edges] for a in edges], bool)
    together = np.reshape(alike | alike.T, (len(edges), len(edges))) | np.eye(len(edges), dtype=bool)
    while (further := together @ together).sum() > together.sum():
        together = further
    return [edge for edge, others in zip(edges, together, strict=True) if others.sum() < GROUP]


def _find_chains(picture: Singles, drawn: list[Curve], patch: PatchShape, reach_px: float) -> Polylines:
    """Return chains of straight edges around curves `drawn` that are longer than a patch, the longest first.

    They are found at the size at which patches are as large as in a small picture, and have their dark side always on
    the same hand.
    """
    scale = min(PatchShape().spine / patch.spine, 1.0)
    size = np.array(picture.shape[1::-1])
    around = np.concatenate([line.at(line.parameters(step=STEP_PX)) for line in drawn])
    low = np.clip(np.floor(around.min(axis=0) - reach_px), 0, size - 1).astype(int)
    high = np.clip(np.ceil(around.max(axis=0) + reach_px) + 1, low + 1, size).astype(int)
    grey = cv2.cvtColor(np.ascontiguousarray(picture[low[1] : high[1], low[0] : high[0]]), cv2.COLOR_RGB2GRAY)
    if scale < 1:
        grey = np.asarray(cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.float32)
    levels = np.rint(np.clip(grey, 0, 1) * 255).astype(np.uint8)
    found = cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD).detect(levels)[0]
    lines = np.reshape([] if found is None else found, (-1, 2, 2)).astype(np.float64)
    lines = lines[np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) > SHORTEST_PX]
    chains = _link(lines)
    points = (lines[np.concatenate(chains)] if chains else lines).reshape(-1, 2)
    chained = Polylines((points + 0.5) / scale - 0.5 + low, 2 * np.array([len(chain) for chain in chains], int))
    last = size - 1 - BORDER_PX
    on_border = chained.all(chained.places < BORDER_PX).any(axis=1) | chained.all(chained.places > last).any(axis=1)
    long = np.flatnonzero(~on_border & (chained.length > 2 * patch.spine + 1))
    return chained.take(long[np.argsort(-chained.length[long], kind="stable")])


def _link(lines: Floats) -> list[list[int]]:
    """Return chains of numbers of straight edges (n, 2, 2), each leading on to the next that begins nearest to its end.

    Where two edges lead on to the same one, the nearer does.
    """
    if not len(lines):
        return []
    way = (lines[:, 1] - lines[:, 0]) / np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)[:, None]
    one, other, far = _pairs(lines)
    leads = (far <= GAP_PX) & ((way[one] * way[other]).sum(axis=1) >= BEND) & (one != other)
    one, other, far = one[leads], other[leads], far[leads]
    number = np.arange(len(lines))
    after, before = number.copy(), np.full(len(lines), -1)
    # The nearest come last, and stay.
    for named, leading, led in ((after, one, other), (before, other, one)):
        order = np.lexsort((-led, -far))
        named[leading[order]] = led[order]
    follows = (after != number) & (before[after] == number)
    has_before = np.isin(number, after[follows])
    chains, taken = [], np.zeros(len(lines), bool)
    # What is left after all chains with a beginning are rings.
    for first in (*np.flatnonzero(~has_before), *np.flatnonzero(has_before)):
        chain, i = [], int(first)
        while not taken[i]:
            taken[i] = True
            chain.append(i)
            if follows[i]:
                i = int(after[i])
        if chain:
            chains.append(chain)
    return chains


def _pairs(lines: Floats) -> tuple[Ints, Ints, Floats]:
    """Return numbers (k,) of edges (n, 2, 2) of which the first ends, and the other begins, at nearly the same x.

    And how far these ends are apart (k,).
    """
    begin, end = lines[:, 0], lines[:, 1]
    order = np.argsort(begin[:, 0])
    low, high = (np.searchsorted(begin[order, 0], end[:, 0] + gap) for gap in (-GAP_PX, GAP_PX))
    count = high - low
    one = np.repeat(np.arange(len(lines)), count)
    other = order[np.repeat(low, count) + count_up(count)]
    return one, other, np.linalg.norm(begin[other] - end[one], axis=1)
