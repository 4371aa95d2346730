"""What a warp gives: where the nodes end, and what became of features, pins and the outline."""

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from core.arrays import Bools, Points
from core.grid import Features
from core.mapping.features.feature_mapping import Solution
from core.mapping.features.similarity import bodies_of, fit_residual
from core.mapping.folds import folded_quads
from core.mapping.handles.straight_frame import distance_to_line
from core.mapping.jacobians import as_complex

MISSED_PX = 0.1
"""A pin that is no further from its point holds it."""


@dataclass(frozen=True, eq=False)
class Pins:
    """Pins: points of the picture (k, 2) and where they are to be, in output pixels."""

    at: Points
    to: Points


NO_PINS = Pins(np.empty((0, 2)), np.empty((0, 2)))


@dataclass(frozen=True)
class PinReport:
    """What became of a pin."""

    at: tuple[float, float]
    to: tuple[float, float]
    reached: tuple[float, float]
    error_px: float


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
    pins: Pins = NO_PINS
    is_rough: bool = False
    """Whether the same solver's next answer to the same handles is nearer to that at rest."""
    reference: Solution | None = None
    """The picture without handles that they were applied to."""

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
        """How far frame nodes outside features are from the side that W draws: 0 unless nothing else avoids folds."""
        rows, columns = self.rest.shape[:2]
        sides = [np.s_[0, :], np.s_[rows - 1, :], np.s_[:, 0], np.s_[:, columns - 1]]
        return max(
            distance_to_line(self.warped[side][self.marked.labels[side] == 0], self.plain[side]) for side in sides
        )

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

    @cached_property
    def pin_reports(self) -> list[PinReport]:
        """What became of every pin."""
        if not len(self.pins.at):
            return []
        low, high = self.rest[0, 0], self.rest[-1, -1]
        shape = np.array(self.rest.shape[1::-1]) - 1
        place = np.clip((self.pins.at - low) / (high - low), 0, 1) * shape
        column, row = np.minimum(place.astype(np.int64), shape - 1).T
        u, v = (place - np.stack([column, row], axis=1)).T[..., None]
        z = self.warped
        across = (1 - u) * z[row, column] + u * z[row, column + 1]
        below = (1 - u) * z[row + 1, column] + u * z[row + 1, column + 1]
        reached = (1 - v) * across + v * below
        error = np.hypot(*(reached - self.pins.to).T)
        return [
            PinReport(_pair(at), _pair(to), _pair(there), float(px))
            for at, to, there, px in zip(self.pins.at, self.pins.to, reached, error, strict=True)
        ]

    @cached_property
    def missed_pins(self) -> list[PinReport]:
        """The pins that are not where they are to be."""
        return [pin for pin in self.pin_reports if pin.error_px > MISSED_PX]

    def complaints(self) -> list[str]:
        """Return a line for each thing that could not be had."""
        found = []
        if self.outline_moved_px:
            found.append(
                f"the outline gives way by up to {self.outline_moved_px:.1f} px, "
                "or features that the picture's edge cuts would fold"
            )
        if self.missed_pins:
            worst = max(pin.error_px for pin in self.missed_pins)
            of = f"{len(self.missed_pins)} of {len(self.pins.at)} pins are"
            found.append(f"{of} not where they were dragged, by up to {worst:.1f} px, or the picture would fold")
        return found

    def report(self) -> dict[str, Any]:
        """Return grid, features, folds, seconds and how far the outline gave way, if it did, as plain data for JSON."""
        moved = {"outline_moved_px": self.outline_moved_px} if self.outline_moved_px > 0 else {}
        pins = {"pins": [asdict(pin) for pin in self.pin_reports]} if len(self.pins.at) else {}
        return {
            "grid": list(self.rest.shape[:2]),
            "features": [asdict(feature) for feature in self.features],
            "folds": {"plain": int(self.folded_plain.sum()), "warped": int(self.folded.sum())},
            "seconds": self.seconds,
            **pins,
            **moved,
        }


def _pair(point: Points) -> tuple[float, float]:
    return float(point[0]), float(point[1])
