"""A surface in space with texture coordinates, as triangles."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from core.arrays import Floats, InputError, Ints, Points, readonly
from core.surfaces.chart import Chart, flatten

MOST = 2_000_000
"""Triangles of a surface at most."""
THIN = 0.1
"""At a pole a texture has no length across. There it is taken to have this share of the usual length."""
RASTER_PX, FINER = 1024, 4
"""Texture coordinates are looked up in a raster of so many pixels a side, drawn to so many bits of a pixel."""
FARTHEST = 1e9
"""Numbers that are larger are no places."""
FAR = 100.0
"""Texture coordinates so many pictures away are as good as any farther."""
CELLS = 64
"""Cells along either side of the texture by which a surface is flattened."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface of triangles; raises `InputError` for arrays that make none, or that no picture can be laid on."""

    name: str
    vertices: Floats
    """(n, 3), y up."""
    texture: Points
    """(n, 2) where each vertex is on the picture: shares of its width and height, from its top left corner."""
    triangles: Ints
    """(m, 3) numbers of vertices."""
    number: float | None = None
    """The number of a shape by name, see `shapes.Shape`; None for a mesh."""

    def __post_init__(self) -> None:
        vertices, texture = np.array(self.vertices, np.float64), np.array(self.texture, np.float64)
        numbers = np.array(self.triangles)
        if vertices.ndim != 2 or vertices.shape[1:] != (3,) or texture.shape != (len(vertices), 2):
            raise InputError(f"surface: {vertices.shape} vertices with {texture.shape} texture coordinates")
        if numbers.ndim != 2 or numbers.shape[1:] != (3,) or not 1 <= len(numbers) <= MOST:
            raise InputError(f"surface: {numbers.shape} is not from 1 to {MOST} triangles")
        if not (np.isfinite(vertices).all() and np.isfinite(texture).all() and np.isfinite(numbers).all()):
            raise InputError("surface: holds numbers that are not finite")
        if max(np.abs(vertices).max(), np.abs(texture).max()) > FARTHEST:
            raise InputError(f"surface: reaches farther than {FARTHEST:g}")
        triangles = numbers.astype(np.int64)
        if (triangles != numbers).any() or triangles.min() < 0 or triangles.max() >= len(vertices):
            raise InputError("surface: a triangle names a vertex that is not there")
        for name, array in (("vertices", vertices), ("texture", texture), ("triangles", triangles)):
            object.__setattr__(self, name, readonly(array))
        if not len(self._laid):
            raise InputError("surface: its texture coordinates cover nothing")

    @cached_property
    def chart(self) -> Chart:
        """The surface laid flat, with its angles kept."""
        return flatten(self.stretch_at, CELLS)

    @cached_property
    def corners(self) -> Points:
        """Texture coordinates (m, 3, 2) of the triangles' corners, each triangle within the unit square's tile."""
        corners = self.texture[self.triangles]
        return np.asarray(corners - np.floor(corners.mean(axis=1, keepdims=True)))

    @cached_property
    def normals(self) -> Floats:
        """Unit normals (n, 3) at the vertices, by the areas of the triangles around them; 0 where there are none."""
        a, b, c = (self.vertices[self.triangles[:, i]] for i in range(3))
        total = np.zeros_like(self.vertices)
        for i in range(3):
            np.add.at(total, self.triangles[:, i], np.cross(b - a, c - a))
        return np.asarray(total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-300))

    @cached_property
    def _laid(self) -> Ints:
        """Numbers of the triangles that the picture covers with some area."""
        one, other = self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0]
        area = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
        return np.flatnonzero(np.abs(area) > 1e-12)

    @cached_property
    def _stretch(self) -> Floats:
        """(k, 2, 2) M of the triangles that are laid: M'M = J'J, with J their Jacobian from the texture to space.

        No singular value is less than `THIN` of the usual one.
        """
        place, corners = self.vertices[self.triangles[self._laid]], self.corners[self._laid]
        sides = (np.stack([part[:, 1] - part[:, 0], part[:, 2] - part[:, 0]], axis=-1) for part in (place, corners))
        in_space, on_texture = sides
        jacobian = in_space @ np.linalg.inv(on_texture)
        square, turn = np.linalg.eigh(np.swapaxes(jacobian, 1, 2) @ jacobian)
        length = np.sqrt(np.maximum(square, 0))
        usual = float(np.median(length[:, 1]))
        if not usual > 0:
            raise InputError("surface: has no area")
        length = np.maximum(length, THIN * usual)
        return np.asarray((turn * length[:, None, :]) @ np.swapaxes(turn, 1, 2))

    def stretch_at(self, share: Points) -> Floats:
        """Return M (k, 2, 2) at places of the texture (k, 2): that of the nearest triangle where none lies there."""
        return np.asarray(self._stretch[self._find(share)])

    def _find(self, share: Points) -> Ints:
        """Return the first of the triangles that are laid at each place (k, 2), the nearest where none is."""
        drawn = np.full((RASTER_PX, RASTER_PX), -1, np.int32)
        corners = np.clip(self.corners[self._laid], -FAR, FAR) * RASTER_PX - 0.5
        corners = np.rint(corners * 2**FINER).astype(np.int32)
        for number in range(len(corners) - 1, -1, -1):
            cv2.fillConvexPoly(drawn, corners[number], (number,), shift=FINER)
        x, y = np.clip((share * RASTER_PX).astype(np.int64), 0, RASTER_PX - 1).T
        found: Ints = np.asarray(drawn[y, x], np.int64)
        missing = found < 0
        if missing.any():
            from scipy.spatial import cKDTree

            middles = self.corners[self._laid].mean(axis=1)
            found[missing] = cKDTree(middles).query(share[missing])[1]
        return found
