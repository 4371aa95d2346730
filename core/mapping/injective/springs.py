"""Friction: energies that grow like a line, so that what they hold stays unless a force is greater than their strength.

    τ δ h(x / δ),   h(u) = √(1 + u²) - 1.

Its force is at most τ; what it holds against less than that stays within about δ, and is then set exactly.
"""

from dataclasses import dataclass

import numpy as np

from core.arrays import Floats, Ints
from core.mapping.jacobians import Complexes

SLACK = 0.02
"""δ: logarithms of a size, angles, or cells, within which these count as unmoved."""


@dataclass(frozen=True)
class Springs:
    """Values (m,) that friction holds at 0, each by the x and y of two unknowns."""

    dofs: Ints
    """Numbers (m, 2) of the unknowns."""
    value: Complexes
    strength: Floats
    """τ (m,)."""
    unit: float
    """What an unknown changes by when its value changes by 1."""

    @property
    def energy(self) -> float:
        """What all of them hold together."""
        return float((self.strength * SLACK * (np.hypot(1, np.abs(self.value / SLACK)) - 1)).sum())

    @property
    def stiffness(self) -> Floats:
        """Of the parabola (m,) that touches the energy and lies above it: of no less than its second derivative."""
        return np.asarray(self.strength / SLACK / np.hypot(1, np.abs(self.value / SLACK)))

    def add_to(self, gradient: Floats, entries: Floats, diagonal: Ints) -> None:
        """Add their slopes, and curvatures at the places of the `diagonal` among a matrix' entries."""
        stiffness = self.stiffness
        for dofs, value in zip(self.dofs.T, (self.value.real, self.value.imag), strict=True):
            on = dofs < len(diagonal)
            gradient[dofs[on]] += (stiffness * value)[on] / self.unit
            entries[diagonal[dofs[on]]] += stiffness[on] / self.unit**2
