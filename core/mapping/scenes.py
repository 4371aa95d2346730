"""A feature at rest among the outline nodes around it: what must hold for none of them to be run over."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import cv2
import numpy as np
from numpy.typing import NDArray

from core.arrays import Floats, Ints
from core.mapping.feature_mapping import FeatureMapping
from core.mapping.frames import Complexes, as_complex
from core.mapping.release import around

_SAMPLES = 32
_NEAR = 8
"""Cells from the outline beyond which a feature is not fitted to it."""
_AROUND = 8
"""Cells around a feature in which the distance to it is known; no contact is as far."""
_FLAT = 0.1
_STRAIGHT = 0.1
"""Width of a side, as a share of its length, that counts as straight."""


_KNOWN: "WeakKeyDictionary[FeatureMapping, dict[int, Scene]]" = WeakKeyDictionary()
"""Scenes depend on the features alone: while W changes, they stay."""


def scenes(mapping: FeatureMapping, count: int) -> Iterator[tuple[int, "Scene"]]:
    """Yield those of the first `count` features that come within a few cells of the outline, with their scenes."""
    if mapping not in _KNOWN:
        corners = _corners(mapping)
        owner = mapping.index.ravel()[corners[:, 1]]
        _KNOWN[mapping] = {i: Scene.of(mapping, i, corners[owner == i]) for i in _near_outline(mapping)}
    for i, scene in _KNOWN[mapping].items():
        if i < count:
            yield i, scene


def _near_outline(mapping: FeatureMapping) -> list[int]:
    """Return the indices of the features that come within a few cells of the outline."""
    rim = mapping.index.copy()
    rim[_NEAR:-_NEAR, _NEAR:-_NEAR] = -1
    found = np.unique(rim)
    return [int(i) for i in found[found >= 0]]


@dataclass(frozen=True, eq=False)
class Sides:
    """What keeps a feature clear of outline nodes o: Re(conj(n) (β W(o) - τ)) + c > 0, seen from the feature."""

    nodes: Ints
    normals: Complexes
    offsets: Floats
    """o, n and c (k,), in cells or as a share of the way at rest, of which a few cells count."""

    def outermost(self, w: Complexes) -> "Sides":
        """Return those of which one is the first not to hold where all n point the same way, for W at nodes (N,)."""
        at = w[self.nodes].view(np.float64).reshape(-1, 2).astype(np.float32)
        hull = cv2.convexHull(at, returnPoints=False).ravel()
        return Sides(self.nodes[hull], self.normals[hull], self.offsets[hull])

    def rows(self, w: Complexes) -> Floats:
        """Return the rows (k, 4) of Re(conj(n) (β W - τ)) in (Re β, Im β, Re τ, Im τ) for W at all nodes (N,)."""
        along = np.conj(self.normals) * w[self.nodes]
        return np.stack([along.real, -along.imag, -self.normals.real, -self.normals.imag], axis=1)


def joined(sides: Sequence[Sides]) -> Sides:
    """Return all of `sides` as one."""
    return Sides(
        np.concatenate([s.nodes for s in sides]),
        np.concatenate([s.normals for s in sides]),
        np.concatenate([s.offsets for s in sides]),
    )


@dataclass(frozen=True, eq=False)
class Scene:
    """A feature at rest, seen from its centre, and the outline nodes around it."""

    corners: "Sides"
    """Of the corners of quads that the feature and the outline decide: twice the area."""
    passed: list["Sides"]
    """Of the ways along the outline from one cut of the feature to another: how far it keeps from the feature."""
    outer: Ints
    """Outline nodes outside features."""
    start: Complexes
    """Their rest positions."""
    unit: float
    """Side of a cell."""
    distance: NDArray[np.float32]
    """Signed distance to the feature in cells, positive outside, on the nodes around it."""
    origin: complex
    """Rest position of the first of these."""
    cell: tuple[float, float]

    @classmethod
    def of(cls, mapping: FeatureMapping, i: int, corners: Ints) -> "Scene":
        """Return the scene of feature i, whose `corners` are (k, 3) nodes o, a, b."""
        grid, body = mapping.grid, mapping.bodies[i]
        rest = as_complex(grid.nodes).ravel()
        rest = rest - (rest[body.nodes] - body.arms)[0]
        row, column = np.divmod(body.nodes, grid.columns)
        top, left = row.min() - _AROUND, column.min() - _AROUND
        inside = np.zeros((row.max() + _AROUND + 1 - top, column.max() + _AROUND + 1 - left), np.uint8)
        inside[row - top, column - left] = 1
        out, into = (cv2.distanceTransform(m, cv2.DIST_L2, cv2.DIST_MASK_5) for m in (1 - inside, inside))
        distance = np.asarray(cv2.GaussianBlur(out - into, (0, 0), 1.0), np.float32)
        width, height = grid.cell
        unit = float(np.sqrt(width * height))
        a, b = rest[corners[:, 1:]].T
        outer = np.flatnonzero(grid.outline & (mapping.index < 0))
        return cls(
            corners=Sides(corners[:, 0], 1j * (b - a) / unit**2, (np.conj(a) * b).imag / unit**2),
            passed=list(_passed(mapping, i, rest, unit)),
            outer=outer,
            start=rest[outer],
            unit=unit,
            distance=distance,
            origin=complex(rest[0] + left * width + 1j * top * height),
            cell=grid.cell,
        )

    def sides(self, w: Complexes) -> "Sides":
        """Return what decides, for W at all nodes (N,), that no corner folds and no node between cuts is run over."""
        return joined([self.corners, *(sides.outermost(w) for sides in self.passed)])

    def _distance_at(self, p: Complexes) -> Floats:
        if not p.size:
            return np.zeros(p.shape)
        u = ((p - self.origin).real / self.cell[0]).astype(np.float32)
        v = ((p - self.origin).imag / self.cell[1]).astype(np.float32)
        found = cv2.remap(self.distance, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(found, np.float64)

    def contacts(self, w: Complexes, beta: complex, tau: complex) -> Sides:
        """Return what keeps the feature off outline nodes that come into it at (β, τ), for W at all nodes (N,).

        The line is the feature's edge where the way from the node's place at rest first meets it.
        """
        start, end = self.start, beta * w[self.outer] - tau
        ways = start + np.linspace(0, 1, _SAMPLES)[:, None] * (end - start)
        room = np.minimum(1.0, 0.3 * self._distance_at(start[None])[0])
        close = self._distance_at(ways) < room
        chosen = np.flatnonzero(close[-1])
        first = ways[np.argmax(close[:, chosen], axis=0), chosen]
        step = 0.5 * self.unit
        slope = [
            self._distance_at((first + d)[None])[0] - self._distance_at((first - d)[None])[0] for d in (step, 1j * step)
        ]
        normal = slope[0] + 1j * slope[1]
        steep = np.abs(normal) > _FLAT
        chosen, first, normal = chosen[steep], first[steep], normal[steep] / np.abs(normal[steep])
        offset = -(np.conj(normal) * first).real / self.unit
        return Sides(self.outer[chosen], normal / self.unit, offset)


def _corners(mapping: FeatureMapping) -> Ints:
    """Return (k, 3) nodes o, a, b, clockwise, of the corners that one feature and the outline decide."""
    index = mapping.index.ravel()
    outer = mapping.grid.outline.ravel() & (index < 0)
    rim = np.ones((mapping.grid.rows - 1, mapping.grid.columns - 1), bool)
    rim[1:-1, 1:-1] = False
    quads = mapping.grid.quads[np.flatnonzero(rim)]
    quads = quads[outer[quads].any(axis=1)]
    corners = quads[:, [[3, 0, 1], [0, 1, 2], [1, 2, 3], [2, 3, 0]]].reshape(-1, 3)
    corners = corners[outer[corners].sum(axis=1) == 1]
    first = np.argmax(outer[corners], axis=1)
    corners = np.take_along_axis(corners, (first[:, None] + np.arange(3)) % 3, axis=1)
    owners = index[corners[:, 1:]]
    return np.asarray(corners[(owners[:, 0] == owners[:, 1]) & (owners[:, 0] >= 0)])


def _passed(mapping: FeatureMapping, i: int, rest: Complexes, unit: float) -> Iterator[Sides]:
    """Yield what keeps the outline between two cuts of feature i on its side of the feature, `rest` seen from it.

    The outline from one cut to the other and the feature's side enclose a part of the picture. If that side is straight
    and nothing folds, none of these nodes lies beyond its line, unless W winds the outline around a cut.
    """
    ring, owner = around(mapping.grid), mapping.index.ravel()
    cuts = np.flatnonzero((owner[ring] == i) & (np.roll(owner[ring], -1) != i))
    if len(cuts) < 2:
        return
    elsewhere = (mapping.index != i).astype(np.uint8)
    _, regions = cv2.connectedComponents(elsewhere, connectivity=4, ltype=cv2.CV_16U)
    for cut in cuts:
        onwards = np.roll(ring, -cut)
        count = int(np.argmax(owner[onwards[1:]] == i))
        arc, first, last = onwards[1 : count + 1], rest[onwards[0]], rest[onwards[count + 1]]
        region = (regions == regions.ravel()[arc[0]]).astype(np.uint8)
        side = (cv2.dilate(region, np.ones((3, 3), np.uint8)) > elsewhere).ravel()
        # Clockwise the picture lies to the right.
        inwards = 1j * (last - first) / abs(last - first)
        across = (np.conj(inwards) * rest[side]).real
        line = across.max()
        if line - across.min() > _STRAIGHT * abs(last - first):
            continue
        along = (np.conj(last - first) * (rest[arc] - first)).real / abs(last - first) ** 2
        held = arc[(owner[arc] < 0) & (along > 0) & (along < 1)]
        if held.size:
            room = np.clip(line - (np.conj(inwards) * rest[held]).real, unit, _NEAR * unit)
            yield Sides(held, -inwards / room, line / room)
