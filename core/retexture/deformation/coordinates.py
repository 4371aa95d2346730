"""Curvilinear coordinates: spines that run along a feature curve, ribs that stand on them (DPD sec. 3.2).

The direction of the nearest curve is stored at the nodes of a grid over the picture as a *line* field
(cos 2a, sin 2a): a and a + 180 degrees are the same line, so that the arbitrary senses of several curves never cancel,
and a trace keeps the sense it started with. Where two sides of a bend, or two curves, meet, the nearest direction
jumps; there the field is diffused, held everywhere else.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.curves.bezier import Curve
from core.linalg.nearest import Nearest
from core.retexture.deformation.grids import STRIDE, as_complex, as_pairs, fill
from core.retexture.sampling import read

STEP_PX = 4.0
"""Nodes of the direction field lie this far apart."""
JUMP = 0.85
"""Cosine of twice the angle between two neighbouring nodes, above which it is no jump but a bend that is read well."""
DIFFUSIONS = 8
SMOOTHINGS = 6
SMOOTHING = 0.7
"""lambda of DPD eq. 3."""


@dataclass(frozen=True)
class Feet:
    """The nearest points of several curves to n positions."""

    curve: Ints
    """Which curve is nearest."""
    length: Floats
    """Arc length from that curve's start to the foot, px."""
    offset: Floats
    """Signed distance, px: positive on the side of the curve's normal."""
    heading: Points
    """(n, 2) unit tangents at the feet."""
    beyond: Bools
    """Whether the foot is an open curve's end and the position lies beyond it."""

    def taken(self, which: Bools | Ints | slice) -> "Feet":
        """Return the feet that `which` picks."""
        return Feet(*(part[which] for part in self.__dict__.values()))


class SpineCurves:
    """Curves as points half a pixel apart, with a tree to find the nearest."""

    def __init__(self, curves: list[Curve], *, step: float = 0.5) -> None:
        self.curves, self.step = curves, step
        spans = [np.linspace(0, c.length, int(np.ceil(c.length / step)) + 1) for c in curves]
        t = [c.parameter_at(s) for c, s in zip(curves, spans, strict=True)]
        self.length = np.concatenate(spans)
        self.index = np.repeat(np.arange(len(curves)), [len(s) for s in spans])
        self.points = np.concatenate([c.at(p) for c, p in zip(curves, t, strict=True)])
        self.tangent = np.concatenate([c.tangent(p) for c, p in zip(curves, t, strict=True)])
        self.turn = np.concatenate([_turning(self.tangent[self.index == i]) for i in range(len(curves))])
        """Angle by which the tangent has turned since the curve's start, radians."""
        ends = np.cumsum([len(s) for s in spans])
        open_curve = np.array([not c.closed for c in curves])
        self._end = np.zeros(len(self.length), bool)
        self._end[ends[open_curve] - 1] = True
        self._end[(ends - [len(s) for s in spans])[open_curve]] = True
        self._nearest = Nearest(self.points)

    def feet(self, positions: Points) -> Feet:
        """Return the nearest points to `positions` (n, 2)."""
        distance, near = self._nearest.to(positions)
        gap, tangent = positions - self.points[near], self.tangent[near]
        along = (gap * tangent).sum(axis=1)
        # Between two samples the tangent turns evenly.
        beside = np.clip(near + np.sign(along).astype(np.int64), 0, len(self.length) - 1)
        share = np.clip(np.abs(along) / self.step, 0, 0.5) * (self.index[beside] == self.index[near])
        # Where a curve turns back on itself the tangent leaps to the other side; half way there is none.
        share *= (tangent * self.tangent[beside]).sum(axis=1) > 0
        heading = tangent + share[:, None] * (self.tangent[beside] - tangent)
        heading /= np.linalg.norm(heading, axis=1, keepdims=True)
        across = tangent[:, 0] * gap[:, 1] - tangent[:, 1] * gap[:, 0]
        beyond = self._end[near] & (np.abs(along) > 0.5)
        offset = np.where(beyond, np.copysign(distance, across), across)
        length = self.length[near] + np.clip(along, -0.5, 0.5)
        return Feet(self.index[near], length, offset, heading, beyond)

    def distance(self, positions: Points) -> Floats:
        """Return the distances of `positions` (n, 2) to the nearest curve, px."""
        return self._nearest.to(positions)[0]

    def place(self, curve: Ints, length: Floats, offset: Floats) -> tuple[Points, Points]:
        """Return positions at `offset` px along the normals at arc `length`s of curves, and the tangents there."""
        points, tangents = np.empty((len(curve), 2)), np.empty((len(curve), 2))
        for i, each in enumerate(self.curves):
            mine = curve == i
            t = each.parameter_at(length[mine])
            tangents[mine] = each.tangent(t)
            points[mine] = each.at(t) + offset[mine, None] * _turn(tangents[mine])
        return points, tangents


def _turning(tangent: Points) -> Floats:
    angle = np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0]))
    return np.asarray(angle - angle[0])


class DirectionField:
    """Unit tangents over a window of the picture, read bilinearly."""

    def __init__(
        self, curves: SpineCurves, window: tuple[float, float, float, float], *, step: float = STEP_PX
    ) -> None:
        self.origin, self.step = np.array(window[:2], np.float32), np.float32(step)
        count = np.ceil((np.array(window[2:]) - self.origin) / step).astype(int) + 2
        x, y = np.meshgrid(np.arange(count[0]), np.arange(count[1]))
        nodes = np.stack([x, y], axis=-1).reshape(-1, 2) * step + self.origin
        feet = curves.feet(nodes)
        a = 2 * np.arctan2(feet.heading[:, 1], feet.heading[:, 0])
        line = np.stack([np.cos(a), np.sin(a)], axis=-1).reshape(*x.shape, 2).astype(np.float32)
        self._line = _diffused(line)

    def along(self, positions: Singles, heading: Singles) -> Singles:
        """Return unit tangents (..., 2) at `positions` (..., 2), in the sense of `heading` (..., 2).

        Of the line (c, s) = (cos 2a, sin 2a) both (1 + c, s) and (s, 1 - c) have the direction a or a + 180 degrees;
        the longer one is safe to normalise.
        """
        line = read(self._line, (positions - self.origin) / self.step)
        c, s = line[..., 0], line[..., 1]
        steep = c < 0
        x, y = np.where(steep, s, 1 + c), np.where(steep, 1 - c, s)
        size = np.maximum(np.hypot(x, y), np.float32(1e-6))
        size = np.copysign(size, x * heading[..., 0] + y * heading[..., 1])
        found = np.empty_like(line)
        np.divide(x, size, out=found[..., 0])
        np.divide(y, size, out=found[..., 1])
        return found


def _diffused(line: Singles) -> Singles:
    """Solve Laplace's equation for the field around its jumps, with the rest held, by Jacobi's sweeps."""
    jump = np.zeros(line.shape[:2], np.uint8)
    jump[:, 1:] |= (line[:, 1:] * line[:, :-1]).sum(axis=-1) < JUMP
    jump[1:] |= (line[1:] * line[:-1]).sum(axis=-1) < JUMP
    around = cv2.dilate(jump, np.ones((3, 3), np.uint8)) > 0
    if not around.any():
        return line
    for _ in range(DIFFUSIONS):
        mean = cv2.blur(line, (3, 3), borderType=cv2.BORDER_REPLICATE)
        line = np.where(around[..., None], mean, line).astype(np.float32)
    return line


def trace(
    field: DirectionField, origins: Points, heading: Points, *, spine: int, rib: int, turn: Floats | None = None
) -> Singles:
    """Grow grids q[k, j] of unit steps from `origins` (n, 2): (n, 2 rib + 1, 2 spine + 1, 2) (DPD eq. 2).

    `turn` (n,) is an angle between each grid and the field, 0 by default.
    """
    return fill(trace_roughly(field, origins, heading, spine=spine, rib=rib, turn=turn), spine=spine, rib=rib)


def trace_roughly(
    field: DirectionField, origins: Points, heading: Points, *, spine: int, rib: int, turn: Floats | None = None
) -> Singles:
    """Grow grids from `origins` (n, 2) in steps of `STRIDE` px, as far as `rib` and `spine` at least, see `trace`.

    Midpoint steps in place of Euler's: on a circle of radius R Euler's unit steps spiral out by 1 / 2R each.
    """
    angle = np.zeros(len(origins)) if turn is None else turn
    turned = np.stack([np.cos(angle), np.sin(angle)], axis=-1).astype(np.float32)
    ribs, spines = -(-rib // STRIDE), -(-spine // STRIDE)
    grids = np.empty((len(origins), 2 * ribs + 1, 2 * spines + 1, 2), np.float32)
    leaving = np.empty((len(origins), 2 * spines + 1, 2), np.float32)
    first = origins.astype(np.float32)
    grids[:, ribs, spines] = first
    leaving[:, spines] = field.along(first, heading.astype(np.float32))
    steps = _steps(field, first, leaving[:, spines], turned)
    for j, (at, toward) in zip(range(1, spines + 1), steps, strict=False):
        grids[:, ribs, spines + j], grids[:, ribs, spines - j] = at
        leaving[:, spines + j], leaving[:, spines - j] = toward
    steps = _steps(field, grids[:, ribs], leaving, _turn(turned)[:, None])
    for k, (at, _) in zip(range(1, ribs + 1), steps, strict=False):
        grids[:, ribs + k], grids[:, ribs - k] = at
    return _smooth(grids)


def _steps(field: DirectionField, start: Singles, along: Singles, turned: Singles) -> Iterator[tuple[Singles, Singles]]:
    """Yield positions (2, ...), step after step in either sense, and the field's directions there.

    Steps are taken at angles, unit vectors `turned`, from the field.
    """
    at, toward = np.stack([start, start]), np.stack([along, along])
    step = np.reshape(np.array([STRIDE, -STRIDE], np.float32), (2, *[1] * start.ndim))
    while True:
        middle = field.along(at + np.float32(0.5) * step * _rotate(toward, turned), toward)
        at = at + step * _rotate(middle, turned)
        toward = field.along(at, middle)
        yield at, toward


def _rotate(vectors: Singles, by: Singles) -> Singles:
    """Return `vectors` turned by the angles of the unit vectors `by`: a complex product."""
    return as_pairs(as_complex(vectors) * as_complex(by))


def _turn(vectors: Singles) -> Singles:
    """Return `vectors` turned by +90 degrees, from tangents to normals."""
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


def _smooth(grids: Singles) -> Singles:
    """Relax the inner nodes of grids that cross themselves towards the mean of their neighbours (DPD eq. 3)."""
    crossed = _is_folded(grids)
    if crossed.any():
        part = grids[crossed]
        for _ in range(SMOOTHINGS):
            mean = (part[:, 2:, 1:-1] + part[:, :-2, 1:-1] + part[:, 1:-1, 2:] + part[:, 1:-1, :-2]) / 4
            part[:, 1:-1, 1:-1] += np.float32(SMOOTHING) * (mean - part[:, 1:-1, 1:-1])
        grids[crossed] = part
    return grids


def _is_folded(grids: Singles) -> Bools:
    """Return which grids (n,) have a cell turned inside out."""
    nodes = as_complex(grids)
    along, across = np.diff(nodes, axis=2)[:, :-1], np.diff(nodes, axis=1)[:, :, :-1]
    return np.asarray(((np.conj(along) * across).imag <= 0).any(axis=(1, 2)))
