"""What the hand and the frame fix of a mapping, as every solver of it takes it.

Three kinds of constraints, all hard:

- probes in the background: the bilinear place of a point of the picture is where the hand has it, and a ring reads what
  the hand asks for;
- freedoms of bodies: a body moves by z = t + α (p - pivot), where α = s exp(ρ + iφ); each of ρ, φ, Re t and Im t is
  either unknown or stays. A body with one pin turns and scales about it; one with two has none of the four left; one
  that stays upright does not turn; one that a straight frame cuts neither turns nor leaves its side;
- gliding nodes of the frame: they move along the outline that W draws, and only along it. All others
  stay, but where the frame is free.
"""

from dataclasses import dataclass

import numpy as np

from core.arrays import Bools
from core.mapping.features.similarity import Body
from core.mapping.handles.probes import Probes
from core.mapping.jacobians import Complexes

SCALE, TURN, ALONG_X, ALONG_Y = range(4)


@dataclass(frozen=True, eq=False)
class Constraints:
    """The constraints of a mapping of n bodies on a grid of R x C nodes."""

    probes: Probes
    """Points and rings (k), each with free nodes."""
    to: Complexes
    """What they are to read (k,)."""
    pivots: Complexes
    """Point of the picture that each body (n,) turns and scales about."""
    free: Bools
    """Which of ρ, φ, Re t and Im t of each body are unknown (n, 4)."""
    glide: Bools
    """Nodes of the frame (R, C) that glide."""
    is_free: bool = False
    """Whether nodes of the frame move like all others."""

    @classmethod
    def none(cls, bodies: list[Body], rest: Complexes) -> "Constraints":
        """Return those of a mapping without handles whose frame is held; rest is (R, C)."""
        pivots = np.array([rest.ravel()[body.nodes].mean() for body in bodies], np.complex128)
        return cls(
            Probes.of_points(np.empty((0, 2))),
            np.empty(0, np.complex128),
            pivots,
            np.array([(True, body.limits.turns, True, True) for body in bodies], bool).reshape(-1, 4),
            np.zeros(rest.shape, bool),
        )
