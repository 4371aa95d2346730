"""Rings of pins: by how much the picture is turned and scaled around one."""

from dataclasses import dataclass

import numpy as np

from core.arrays import InputError

RING_SCALES = 0.05, 20.0
"""By how much a ring scales at least and at most."""


@dataclass(frozen=True)
class Ring:
    """By how much the picture is turned and scaled around a pin, against what it is without handles.

    Raises `InputError` for a scale that is not within `RING_SCALES`, or a turn that is no number.
    """

    turn_deg: float = 0.0
    """Clockwise on the screen, y down."""
    scale: float = 1.0

    def __post_init__(self) -> None:
        if not np.isfinite(self.turn_deg):
            raise InputError(f"ring: a turn of {self.turn_deg:g} degrees is not a finite number")
        if not RING_SCALES[0] <= self.scale <= RING_SCALES[1]:
            raise InputError(f"ring: a scale of {self.scale:g} is not from {RING_SCALES[0]:g} to {RING_SCALES[1]:g}")

    @classmethod
    def of(cls, f: complex) -> "Ring":
        """Return the ring that turns and scales by s exp(iφ)."""
        return cls(float(np.degrees(np.angle(f))), float(np.clip(abs(f), *RING_SCALES)))

    @property
    def f(self) -> complex:
        """What it turns and scales by, s exp(iφ); 1, to the last bit, where it has not been moved."""
        return complex(self.scale * np.exp(1j * np.radians(self.turn_deg)))
