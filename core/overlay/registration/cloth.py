"""The cloth of a photo while it is fitted: what stays the same, and what has been found of it."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from core.arrays import Bools, Floats, Points, Singles
from core.overlay.detection.alignment import FlatPicture
from core.overlay.detection.lattice import LEAST_VERTICES, Lattice
from core.overlay.detection.stages import Stage
from core.overlay.filters.distances import within
from core.overlay.filters.shrinking import shrunk
from core.overlay.filters.texture_filter import DENSITY
from core.overlay.mesh import ClothMesh
from core.overlay.registration.region import LIMIT, SeenCells, Tolerance, look_at, misfit_of_cells, tolerance_of
from core.overlay.registration.registration import ClothState, Registration
from core.overlay.registration.thin_plate import spread
from core.overlay.texel import Texel, estimate_texel

IN_REGION = 1.25
"""Leniency where a region is given: nothing but cloth should be there."""
CELLS = 8
"""Cells along a side of a texel at least, where the mesh is coarsened."""
STEP_PX = 24.0
"""Side of the steps into which large texels are divided."""
NEAR = 0.3
"""Part of a texel's side within which a keypoint tells the coordinates."""
SIZES = (0.1, 8.0)
"""Area of cloth under a cell, over the usual: any even patch looks like a texel blown up."""


@dataclass(frozen=True)
class FittedCloth:
    """What stays the same while a photo is fitted."""

    photo: Floats
    """(H, W, 3), 0 to 1."""
    canvas: FlatPicture
    """The photo freed of slow changes of light, and where cloth may be."""
    lattice: Lattice
    """The lattice that was found, of steps that may be finer than the texel."""
    M: Floats
    """(2, 2), columns are the texel's sides in steps of the lattice."""
    mesh: ClothMesh
    registration: Registration
    is_divided: bool = False
    """Whether the lattice's steps are parts of a texel that look like nothing of one another."""
    is_woven: bool = False
    """Whether the texel is taken for that of a plaid, which changes along the warp and along the weft alone."""

    @property
    def basis(self) -> Floats:
        """S (2, 2), pixels a texel of the undeformed cloth."""
        return self.lattice.basis @ self.M

    @property
    def valid(self) -> Bools:
        """Pixels (H, W) that may be cloth."""
        return np.asarray(self.canvas.valid[..., 0] > 0, np.bool_)

    @property
    def in_region(self) -> bool:
        """Whether the user said where the cloth is."""
        return not self.valid.all()

    @cached_property
    def valid_shares(self) -> Floats:
        """Share of each cell (rows, columns) that may be cloth."""
        return self.mesh.cell_means(self.valid.astype(float))

    @property
    def allowed(self) -> Bools:
        """Cells that may be cloth."""
        return np.asarray(self.valid_shares > 0.3, np.bool_)

    @cached_property
    def brightness(self) -> Floats:
        """Local brightness at the nodes (R, C), over the usual one."""
        colours, flat = (plane @ np.full(3, 1 / 3, plane.dtype) for plane in (self.photo, self.canvas.image))
        at = np.clip(np.rint(self.mesh.positions()).astype(int), 0, np.array(self.valid.shape[::-1]) - 1)
        bright = np.where(self.valid, colours / np.maximum(flat, 1e-3), np.nan)[at[..., 1], at[..., 0]]
        middle = float(np.nanmedian(bright))
        # Half of a black cloth may have no brightness at all.
        return np.clip(np.nan_to_num(bright / middle, nan=1.0), 0.1, 5.0) if middle > 0 else np.ones(bright.shape)

    @property
    def step_px(self) -> float:
        """Side of a square of the area of one lattice step."""
        return float(np.sqrt(self.lattice.texel_area))

    @property
    def quarter_step(self) -> int:
        """Cells to a quarter of a lattice step: one, or about so, of the mesh that is followed."""
        return max(1, round(self.step_px / 4 / self.mesh.cell))

    @property
    def side_px(self) -> float:
        """Side of a square of the area of one texel."""
        return float(np.sqrt(abs(np.linalg.det(self.basis))))

    @property
    def few(self) -> bool:
        """Whether the cloth shows so few texels that each of them says much."""
        return len(self.lattice) < LEAST_VERTICES

    @property
    def texel_samples(self) -> tuple[int, int]:
        """Height and width of the texel in samples."""
        width, height = DENSITY * np.linalg.norm(self.basis, axis=0)
        return max(4, round(float(height))), max(4, round(float(width)))

    @property
    def sigma_px(self) -> float:
        """Width of the neighbourhood in which a fit is judged: lines of a large texel with what is between them."""
        return max(0.35 * max(self.step_px, self.side_px / 2), 3.0)

    @property
    def without_results(self) -> "FittedCloth":
        """The cloth without what was worked out and kept of it, which takes memory."""
        weight = self.canvas.valid[..., 0].astype(np.float64)
        smoothness = self.registration.smoothness
        return replace(self, registration=Registration(self.mesh, self.photo, weight, self.basis, smoothness))

    @property
    def can_be_coarser(self) -> bool:
        """Whether the cells of a mesh twice as coarse still are small beside a texel."""
        return CELLS * 2 * self.mesh.cell <= self.side_px

    @cached_property
    def coarser(self) -> "FittedCloth":
        """The cloth of the photo halved, on every second node of the mesh."""
        photo, flat, valid = (shrunk(plane, 2) for plane in (self.photo, self.canvas.image, self.canvas.valid))
        canvas = FlatPicture(flat.astype(np.float32), (valid > 0.5).astype(np.float32))
        mesh, lattice = ClothMesh(photo.shape[:2], self.mesh.cell), self.lattice.shrunk(2)
        registration = Registration(mesh, photo, valid[..., 0], lattice.basis @ self.M)
        return replace(self, photo=photo, canvas=canvas, lattice=lattice, mesh=mesh, registration=registration)

    def near_points(self, points: Points) -> tuple[Bools, Bools]:
        """Return the pixels (H, W) that may be cloth within `NEAR` of points (n, 2), and the cells that lie there."""
        at = np.clip(np.rint(points).astype(int), 0, np.array(self.valid.shape[::-1]) - 1)
        told = np.zeros(self.valid.shape, np.bool_)
        told[at[:, 1], at[:, 0]] = True
        near = within(told, NEAR * self.side_px) & self.valid
        return near, np.asarray(self.mesh.cell_means(near.astype(float)) > 0.5, np.bool_)

    def as_woven(self, texel: Texel) -> Texel:
        """Return a texel, of a plaid what changes along warp and weft alone."""
        return texel.woven(self.basis) if self.is_woven else texel

    def steps_of(self, cells: Bools) -> float:
        """Return the area of cells in lattice steps."""
        return float(cells.sum()) * self.mesh.cell**2 / self.step_px**2


@dataclass(frozen=True)
class Fit:
    """A texel and the pieces of cloth that it is registered with; their cells do not overlap."""

    texel: Texel
    pieces: tuple[ClothState, ...]
    tolerance: Tolerance

    @property
    def cells(self) -> Bools:
        """Cells of all pieces."""
        return np.asarray(np.any([piece.cells for piece in self.pieces], axis=0), np.bool_)


def make_cloth(photo: Floats, canvas: FlatPicture, lattice: Lattice, M: Floats) -> FittedCloth:
    """Return the cloth of a photo whose texel is M of a lattice's steps."""
    # About four cells to a step (NRT sec. 3.2: finer than the lattice).
    cell = int(np.clip(2 * round(np.sqrt(lattice.texel_area) / 8), 4, 14))
    mesh = ClothMesh(photo.shape[:2], cell)
    registration = Registration(mesh, photo, canvas.valid[..., 0].astype(np.float64), lattice.basis @ M)
    return FittedCloth(photo, canvas, lattice, M, mesh, registration)


def make_divided_cloth(photo: Floats, canvas: FlatPicture, lattice: Lattice) -> FittedCloth:
    """Return the cloth of a photo whose texels are a lattice's, divided into steps as small as motifs."""
    steps = max(1, round(float(np.sqrt(lattice.texel_area)) / STEP_PX))
    cloth = make_cloth(photo, canvas, lattice.divided(steps), steps * np.eye(2))
    return replace(cloth, is_divided=steps > 1)


def starting_state(cloth: FittedCloth, lattice: Lattice) -> ClothState:
    """Return coordinates spread from a lattice, in its own texels, and shading from the local brightness."""
    uv = spread(cloth.mesh, lattice)
    cells = near_lattice(cloth.mesh, lattice, uv) & (cloth.valid_shares > 0.5)
    return ClothState(np.nan_to_num(uv), cloth.brightness, np.asarray(cells, np.bool_))


def near_lattice(mesh: ClothMesh, lattice: Lattice, uv: Floats) -> Bools:
    """Return the cells whose corners are nearer to a vertex of the lattice than to any place that lacks one."""
    known = set(map(tuple, lattice.keys.tolist()))
    spread_to = np.isfinite(uv[..., 0])
    near = np.zeros(mesh.nodes, bool)
    near[spread_to] = [tuple(key) in known for key in np.rint(uv[spread_to]).astype(int).tolist()]
    return np.asarray(near[:-1, :-1] & near[1:, :-1] & near[:-1, 1:] & near[1:, 1:], np.bool_)


def estimate(cloth: FittedCloth, pieces: tuple[ClothState, ...], *, by_mean: bool = False) -> Texel:
    """Return the texel that most of the pieces show, or their mean (`estimate_from`)."""
    seen = look_at(cloth.registration, pieces)
    return estimate_from(cloth, seen, seen.weight, by_mean=by_mean)


def estimate_from(cloth: FittedCloth, seen: SeenCells, weight: Singles, *, by_mean: bool = True) -> Texel:
    """Return the texel that cells show under weights (K, n), by their mean or by what most of them show.

    The mean is for cloth that is registered: before that, places and light are guesses, and some are outliers. Of a
    plaid all is an outlier that changes along neither warp nor weft, so that it is told by what most show in any case.
    """
    at, light, is_robust = seen.at[..., :2], seen.at[..., 2], cloth.is_woven or not by_mean
    texel = estimate_texel(seen.photo, at, light, weight, cloth.texel_samples, is_robust=is_robust)
    return cloth.as_woven(texel)


def measure(cloth: FittedCloth, texel: Texel, pieces: tuple[ClothState, ...]) -> Fit:
    """Return the fit of a texel and pieces with the tolerance that they suggest."""
    sums = look_at(cloth.registration, pieces).sums(texel)
    return Fit(texel, pieces, tolerance_of(sums, texel, IN_REGION if cloth.in_region else 1.0))


def misfits(cloth: FittedCloth, state: ClothState, found: Fit) -> Floats:
    """Return the misfit (rows, columns) of the cells in use, by the measure of what has been found."""
    sums = look_at(cloth.registration, [state]).sums(found.texel)
    strict, mild = misfit_of_cells(cloth.mesh, state.cells, sums, found.tolerance, cloth.sigma_px)
    # Beyond the cloth, half a motif at the border would correlate well enough.
    return mild if cloth.in_region else strict


def fitting_cells(cloth: FittedCloth, state: ClothState, found: Fit, *, limit: float = LIMIT) -> Bools:
    """Return the cells in use in which the texture explains the photo, neither blown up nor crushed."""
    usual = cloth.mesh.cell**2 / abs(np.linalg.det(cloth.basis))
    sizes = np.abs(cloth.mesh.areas(state.uv, state.cells)) / usual
    sound = state.cells.copy()
    sound[state.cells] = (sizes.min(1) > SIZES[0]) & (sizes.max(1) < SIZES[1])
    return np.asarray(sound & (misfits(cloth, state, found) < limit), np.bool_)


def stage(cloth: FittedCloth, found: Fit) -> Stage:
    """Return what a fit can show."""
    uv = np.full((*cloth.valid.shape, 2), np.nan)
    for piece in found.pieces:
        inside = cloth.mesh.pixels_of(piece.cells) & cloth.valid
        uv[inside] = cloth.mesh.to_pixels(piece.uv, piece.cells)[inside]
    return Stage("mesh", None, found.texel, uv, cloth.mesh.shape)
