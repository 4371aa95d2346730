"""A camera that goes around a surface in space."""

from dataclasses import dataclass

import numpy as np

from core.arrays import Floats
from core.surfaces.surface import Surface

FIELD_DEG = 30.0
"""Angle that the camera sees."""
NEAR, FAR = 0.05, 20.0
ROOM = 0.95
"""A whole surface fills so much of the view."""


@dataclass(frozen=True)
class Orbit:
    """Where a camera is that looks at the middle of a surface."""

    turn_deg: float = 20.0
    """How far it has gone around to the right."""
    tilt_deg: float = 15.0
    """How far up."""
    zoom: float = 1.0
    """1 shows the whole surface, more shows less of it."""

    def turned(self) -> Floats:
        """Return the rotation (3, 3) of space before the camera."""
        turn, tilt = np.radians([-self.turn_deg, self.tilt_deg])
        around = np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
        over = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
        return np.asarray(over @ around)

    def clip_matrix(self, surface: Surface, size: tuple[int, int]) -> Floats:
        """Return the matrix (4, 4) from the space of a surface to clip coordinates of a picture of `size`, (w, h)."""
        low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
        middle = (low + high) / 2
        radius = max(float(np.linalg.norm(surface.vertices - middle, axis=1).max()), 1e-12)
        half = np.radians(FIELD_DEG / 2)
        view = np.eye(4)
        view[:3, :3] = self.turned() / radius
        view[:3, 3] = -view[:3, :3] @ middle - [0, 0, 1 / np.sin(half)]
        # The narrower side of the picture sees the whole angle.
        scale = ROOM * self.zoom / np.tan(half) * min(size) / np.array(size)
        depth = (FAR + NEAR) / (NEAR - FAR), 2 * FAR * NEAR / (NEAR - FAR)
        project = np.array([[scale[0], 0, 0, 0], [0, scale[1], 0, 0], [0, 0, *depth], [0, 0, -1, 0]])
        return np.asarray(project @ view)
