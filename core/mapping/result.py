"""What a warp gives: where the nodes end, and what became of features, pins and the outline."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from core.arrays import Bools, Points
from core.grid import SIDES, Features, Grid
from core.linalg.cubic_convolution import Smooth
from core.mapping.features.pose import Solution
from core.mapping.features.similarity import Body, bodies_of, body_index, fit_residual
from core.mapping.folds import find_folded_quads
from core.mapping.handles.handles import Handles, ring_radius
from core.mapping.handles.poses import find_owners
from core.mapping.handles.probes import Probes
from core.mapping.handles.straight_frame import distance_to_line
from core.mapping.jacobians import Complexes, as_complex, as_positions
from core.mapping.options import MappingOptions
from core.mapping.tolerances import SEEN_PX

NO_HANDLES = Handles(np.empty((0, 2)), np.empty((0, 2)))


@dataclass(frozen=True)
class RingReport:
    """What became of a ring."""

    turn_deg: float
    scale: float
    reached_turn_deg: float
    reached_scale: float
    error_px: float
    """How far its end is off on a ring of the picture's size, in output pixels."""


@dataclass(frozen=True)
class PinReport:
    """What became of a pin."""

    at: tuple[float, float]
    to: tuple[float, float]
    reached: tuple[float, float]
    error_px: float
    ring: RingReport | None = None

    @property
    def worst_px(self) -> float:
        """By how much the pin or its ring misses."""
        return self.error_px if self.ring is None else max(self.error_px, self.ring.error_px)

    def data(self) -> dict[str, Any]:
        """Return it as plain data for JSON, with a ring if there is one."""
        return {name: value for name, value in asdict(self).items() if value is not None}


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

    grid: Grid
    w: Points
    """Where W takes the nodes, without handles."""
    warped: Points
    """Where they end."""
    marked: Features
    options: MappingOptions
    seconds: dict[str, float]
    """Per stage: setup, factor, rhs, solve, and unfold, which holds the solves that it asks for."""
    handles: Handles = NO_HANDLES
    is_rough: bool = False
    """Whether the same solver's next answer to the same handles is nearer to that at rest."""
    reference: Solution | None = None
    """The picture without handles that they were applied to."""
    field: Smooth | None = None
    """By how much handles displace the background."""
    folds: Bools | None = None
    """Which quads of `warped` are folded, where that is known."""

    @cached_property
    def plain(self) -> Points:
        """Where W takes the nodes, or W and handles, as if there were no features."""
        return self.w if self.field is None or not self.field.d.any() else self.w + as_positions(self.field.whole)

    @property
    def rest(self) -> Points:
        """Where the nodes are on the picture."""
        return self.grid.nodes

    @cached_property
    def folded(self) -> Bools:
        """Which quads (R-1, C-1) of `warped` are folded."""
        return find_folded_quads(as_complex(self.warped)) if self.folds is None else self.folds

    @cached_property
    def folded_plain(self) -> Bools:
        """Which quads (R-1, C-1) of `plain` are folded."""
        return find_folded_quads(as_complex(self.plain))

    @cached_property
    def outline_moved_px(self) -> float:
        """How far frame nodes outside features are from the side that W draws: 0 unless nothing else avoids folds."""
        moved = (self.warped != self.plain).any(axis=-1) & (self.marked.labels == 0)
        return max(distance_to_line(self.warped[side][moved[side]], self.plain[side]) for side in SIDES)

    @cached_property
    def features(self) -> list[FeatureReport]:
        """What became of every feature that has a shape, by component number."""
        rest, z = as_complex(self.rest), as_complex(self.warped).ravel()
        found = []
        for body in bodies_of(self.marked, rest):
            alpha, _ = body.fit(z)
            rigid = self.options.limits_of(body.number).is_rigid
            residual = fit_residual(body.arms, z[body.nodes], rigid=rigid)
            angle = float(np.degrees(np.angle(alpha)))
            found.append(FeatureReport(body.number, len(body.nodes), residual, abs(alpha), angle))
        return found

    @cached_property
    def pin_reports(self) -> list[PinReport]:
        """What became of every pin."""
        if not len(self.handles.pins_at):
            return []
        reached = as_positions(Probes.of_points(self.handles.pins_at).read(self.grid, as_complex(self.warped)))
        error = np.hypot(*(reached - self.handles.pins_to).T)
        rings, pins = self._ring_reports(), self.handles
        return [
            PinReport(_pair(at), _pair(to), _pair(there), float(px), ring)
            for at, to, there, px, ring in zip(pins.pins_at, pins.pins_to, reached, error, rings, strict=True)
        ]

    def _ring_reports(self) -> list[RingReport | None]:
        """Return what became of the ring of every pin, None for none."""
        found: list[RingReport | None] = [None] * len(self.handles.pins_at)
        if self.handles.rings is None or not np.isfinite(self.handles.rings).any():
            return found
        ringed = np.flatnonzero(np.isfinite(self.handles.rings))
        at, asked = self.handles.pins_at[ringed], self.handles.rings[ringed]
        reached, unit = self.turned_at(at), np.abs(next(self._read_rings(at, self._unmoved)))
        for i, f, there, px in zip(ringed, asked, reached, np.abs(reached - asked) * unit, strict=True):
            found[i] = RingReport(_degrees(f), float(abs(f)), _degrees(there), float(abs(there)), float(px))
        return found

    def turned_at(self, at: Points) -> Complexes:
        """Return by how much handles have turned and grown the picture (k,) around points of it (k, 2)."""
        before, after = self._read_rings(at, self._unmoved, as_complex(self.warped))
        found = np.divide(after, before, out=np.ones_like(after), where=before != 0)
        if self.reference is None or not self.reference.alpha.size:
            return np.asarray(found)
        for i, body in _bodies_around(self.marked, self.options, self.grid, _as_pairs(at)):
            found[i] = body.fit(as_complex(self.warped).ravel())[0] / body.fit(self._unmoved.ravel())[0]
        return found

    @property
    def _unmoved(self) -> Complexes:
        """Nodes (R, C) without handles."""
        return as_complex(self.warped) if self.reference is None else self.reference.z

    def _read_rings(self, at: Points, *maps: Complexes) -> Iterator[Complexes]:
        nodes, weights = _rings_around(self.grid, _as_pairs(at)).on(self.grid)
        for z in maps:
            yield np.asarray((z.ravel()[nodes] * weights).sum(axis=1), np.complex128)

    @cached_property
    def missed_pins(self) -> list[PinReport]:
        """The pins that are not where they are to be, or not turned or scaled as their rings ask for."""
        return [pin for pin in self.pin_reports if pin.worst_px > SEEN_PX]

    @cached_property
    def curves_off_px(self) -> float:
        """How far points of inner curves are at most from where they are to be."""
        at, to = self.handles.sample_curves(self.grid)
        reached = as_positions(Probes.of_points(at).read(self.grid, as_complex(self.warped)))
        return float(np.hypot(*(reached - to).T).max(initial=0))

    def complaints(self) -> list[str]:
        """Return a line for each thing that could not be had."""
        found = []
        if self.outline_moved_px:
            found.append(
                f"the outline gives way by up to {_px(self.outline_moved_px)}, "
                "or features that the picture's edge cuts would fold"
            )
        if self.missed_pins:
            worst = max(pin.worst_px for pin in self.missed_pins)
            of = f"{len(self.missed_pins)} of {len(self.handles.pins_at)}"
            found.append(f"pins that are missed: {of}, by up to {_px(worst)}; closer, the picture would fold")
        if self.curves_off_px > SEEN_PX:
            found.append(
                f"inner curves are up to {_px(self.curves_off_px)} from where they were dragged: "
                "features keep their shape, and nothing folds"
            )
        return found

    def report(self) -> dict[str, Any]:
        """Return grid, features, folds, seconds and how far the outline gave way, if it did, as plain data for JSON."""
        moved = {"outline_moved_px": self.outline_moved_px} if self.outline_moved_px > 0 else {}
        pins = {"pins": [pin.data() for pin in self.pin_reports]} if len(self.handles.pins_at) else {}
        return {
            "grid": list(self.rest.shape[:2]),
            "features": [asdict(feature) for feature in self.features],
            "folds": {"plain": int(self.folded_plain.sum()), "warped": int(self.folded.sum())},
            "seconds": self.seconds,
            **pins,
            **moved,
        }


def _as_pairs(points: Points) -> tuple[tuple[float, float], ...]:
    return tuple(_pair(point) for point in points.tolist())


@lru_cache(maxsize=4)
def _rings_around(grid: Grid, at: tuple[tuple[float, float], ...]) -> Probes:
    """Return the rings around points of the picture, the same while only the map changes."""
    return Probes(np.array(at), np.full(len(at), ring_radius(grid)))


@lru_cache(maxsize=4)
def _bodies_around(
    features: Features, options: MappingOptions, grid: Grid, at: tuple[tuple[float, float], ...]
) -> list[tuple[int, Body]]:
    """Return which points of the picture are in features that keep their shape exactly, and in which."""
    labels, points = features.labels, np.array(at)
    near = np.isin(labels, labels.ravel()[grid.weights_at(points)[0]])
    bodies = [
        body
        for body in bodies_of(Features(np.where(near, labels, 0)), as_complex(grid.nodes))
        if options.limits_of(body.number).weight == 1
    ]
    owners = find_owners(body_index(bodies, grid.shape), grid, points)
    return [(i, bodies[owners[i]]) for i in np.flatnonzero(owners >= 0).tolist()]


def _degrees(f: complex) -> float:
    return float(np.degrees(np.angle(f)))


def _px(length: float) -> str:
    """Return a length in pixels in words; one far beyond all pictures in few digits."""
    return f"{length:.1f} px" if length < 1e6 else f"{length:.1e} px"


def _pair(point: Sequence[float] | Points) -> tuple[float, float]:
    return float(point[0]), float(point[1])
