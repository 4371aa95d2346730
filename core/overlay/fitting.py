"""From a lattice to the registered cloth: start, growth to the cloth's end, further pieces, texel and mesh in turn."""

from dataclasses import dataclass, replace

import numpy as np

from core.arrays import Bools, Floats
from core.overlay.alignment import Canvas
from core.overlay.basis import reduced
from core.overlay.composition import DENSITY
from core.overlay.lattice import Lattice
from core.overlay.mesh import Mesh
from core.overlay.period import coarser, estimate_halves
from core.overlay.region import LIMIT, continued, misfit, model, ring, without_specks
from core.overlay.registration import Registration, Smoothness, State
from core.overlay.seeding import NoPatternError, find_piece
from core.overlay.stages import Stage
from core.overlay.texel import Texel, estimate_texel
from core.overlay.thin_plate import spread
from core.overlay.vertices import vertices
from core.progress import Job, Progress

MOST_PIECES = 8
LEAST_TEXELS = 4
"""Area of cloth, in texels, below which nothing was found."""
LEAST_RHO = 0.02


@dataclass(frozen=True)
class Cloth:
    """What stays the same while a photo is fitted."""

    photo: Floats
    """(H, W, 3), 0 to 1."""
    flat: Floats
    """(H, W, 3), the photo freed of slow changes of light."""
    valid: Bools
    """(H, W), where cloth may be."""
    mesh: Mesh
    basis: Floats
    """S (2, 2), pixels a texel of the undeformed cloth."""
    registration: Registration
    allowed: Bools
    """Cells where cloth may be."""

    @property
    def side_px(self) -> float:
        """Side of a square of a texel's area."""
        return float(np.sqrt(abs(np.linalg.det(self.basis))))

    @property
    def texel_samples(self) -> tuple[int, int]:
        """Height and width of the texel in samples."""
        width, height = DENSITY * np.linalg.norm(self.basis, axis=0)
        return max(4, round(float(height))), max(4, round(float(width)))

    @property
    def sigma_px(self) -> float:
        """Width of the neighbourhood in which a fit is judged."""
        return max(0.35 * self.side_px, 3.0)


@dataclass(frozen=True)
class Fit:
    """A texel and the pieces of cloth that it is registered with; their cells do not overlap."""

    texel: Texel
    pieces: tuple[State, ...]

    @property
    def cells(self) -> Bools:
        """Cells of all pieces."""
        return np.asarray(np.any([piece.cells for piece in self.pieces], axis=0), np.bool_)


def make_cloth(photo: Floats, canvas: Canvas, basis: Floats) -> Cloth:
    """Return the cloth of a photo with texels of that basis."""
    valid = canvas.valid[..., 0] > 0
    side = float(np.sqrt(abs(np.linalg.det(basis))))
    # Even, so that every second pixel lies alike in every cell; about four cells to a texel (NRT: finer than a texel).
    mesh = Mesh(photo.shape[:2], int(np.clip(2 * round(side / 8), 4, 14)))
    registration = Registration(mesh, photo, valid.astype(float), basis)
    allowed = np.asarray(mesh.cell_means(valid.astype(float)) > 0.3, np.bool_)
    return Cloth(photo, canvas.image.astype(float), valid, mesh, basis, registration, allowed)


def fit(photo: Floats, canvas: Canvas, lattice: Lattice, seed: int) -> Job[tuple[Cloth, Fit]]:
    """Return the cloth registered from a lattice."""
    basis = lattice.basis
    cloth = make_cloth(photo, canvas, basis)
    start, M = with_true_period(cloth, lattice, starting_state(cloth, lattice), seed)
    cloth = make_cloth(photo, canvas, basis @ M)
    if cloth.mesh.cell != start_cell(basis):
        start = resampled(cloth, lattice, M)
    found = Fit(estimated(cloth, (start,)), (start,))
    for number, blur_px in enumerate((1.5, 0.7)):
        yield Progress(0.05 + 0.1 * number, "registering", stage(cloth, found))
        found = refitted(cloth, found, rounds=5, blur_px=blur_px)
    found = yield from followed(cloth, found, Progress(0.25, "following the cloth"))
    if found.cells.sum() * cloth.mesh.cell**2 < LEAST_TEXELS * cloth.side_px**2:
        raise NoPatternError
    found = yield from with_more_pieces(cloth, canvas, found, M, np.random.default_rng(seed))
    for number in range(2):
        yield Progress(0.8 + 0.1 * number, "registering finely", stage(cloth, found))
        found = refitted(cloth, found, rounds=4)
    return cloth, found


def start_cell(basis: Floats) -> int:
    """Return the cell that `make_cloth` chooses for a basis."""
    return int(np.clip(2 * round(float(np.sqrt(abs(np.linalg.det(basis)))) / 8), 4, 14))


def resampled(cloth: Cloth, lattice: Lattice, M: Floats) -> State:
    """Return the starting state on a cloth whose texel is M of the lattice's."""
    state = starting_state(cloth, lattice)
    return replace(state, uv=state.uv @ np.linalg.inv(M).T)


def starting_state(cloth: Cloth, lattice: Lattice) -> State:
    """Return coordinates spread from the lattice, in its own texels, and shading from the local brightness."""
    uv = spread(cloth.mesh, lattice)
    cells = near_lattice(cloth.mesh, lattice, uv) & (cloth.mesh.cell_means(cloth.valid.astype(float)) > 0.5)
    brightness = cloth.photo.mean(-1) / np.maximum(cloth.flat.mean(-1), 1e-3)
    at = np.clip(np.rint(cloth.mesh.positions()).astype(int), 0, np.array(cloth.valid.shape[::-1]) - 1)
    rho = np.where(cloth.valid, brightness, np.nan)[at[..., 1], at[..., 0]]
    middle = float(np.nanmedian(rho))
    rho = np.clip(np.nan_to_num(rho / middle, nan=1.0), 0.1, 5.0)
    return State(uv, rho, np.asarray(cells, np.bool_))


def near_lattice(mesh: Mesh, lattice: Lattice, uv: Floats) -> Bools:
    """Return the cells whose corners are nearer to a vertex of the lattice than to any place that lacks one."""
    known = set(map(tuple, lattice.keys.tolist()))
    nearest = np.rint(uv).astype(int).reshape(-1, 2).tolist()
    near = np.array([tuple(key) in known for key in nearest]).reshape(mesh.nodes)
    return np.asarray(near[:-1, :-1] & near[1:, :-1] & near[:-1, 1:] & near[1:, 1:], np.bool_)


def with_true_period(cloth: Cloth, lattice: Lattice, state: State, seed: int) -> tuple[State, Floats]:
    """Return the state in the smallest texel that explains the photo in colour, and that texel's matrix M (2, 2)."""
    M = np.eye(2)
    weight = cloth.mesh.pixels_of(state.cells) * cloth.valid.astype(float)
    at = cloth.mesh.to_pixels(state.uv)
    for count in (2, 3, 2):
        if len(lattice) < 8 * count**2 * abs(np.linalg.det(M)):
            continue
        halves = estimate_halves(cloth.flat, at @ np.linalg.inv(M).T, weight, count, seed)
        finer = cloth.basis @ M
        M = M @ np.linalg.solve(finer, reduced(finer @ coarser(halves)))
    return replace(state, uv=state.uv @ np.linalg.inv(M).T), M


def estimated(cloth: Cloth, pieces: tuple[State, ...]) -> Texel:
    """Return the texel that the pieces show."""
    uv, rho, weight = np.zeros((*cloth.valid.shape, 2)), np.ones(cloth.valid.shape), np.zeros(cloth.valid.shape)
    for piece in pieces:
        at = cloth.mesh.to_pixels(piece.values)
        inside = cloth.mesh.pixels_of(piece.cells) & cloth.valid
        uv[inside], rho[inside], weight[inside] = at[inside, :2], at[inside, 2], 1.0
    return estimate_texel(cloth.photo, uv, rho, weight, cloth.texel_samples)


def refitted(cloth: Cloth, found: Fit, *, rounds: int, blur_px: float = 0.0) -> Fit:
    """Return the pieces registered anew and the texel estimated anew from them."""
    run = cloth.registration.run
    pieces = tuple(run(piece, found.texel, Smoothness(), rounds=rounds, blur_px=blur_px) for piece in found.pieces)
    return Fit(estimated(cloth, pieces), pieces)


def followed(cloth: Cloth, found: Fit, step: Progress) -> Job[Fit]:
    """Return the fit with its last piece grown until the cloth ends (NRT sec. 3.2)."""
    state = found.pieces[-1]
    others = found.cells & ~state.cells
    refused = np.zeros(state.cells.shape, np.int64)
    width = max(1, round(0.4 * cloth.side_px / cloth.mesh.cell))
    for _ in range(60):
        trial = ring(state.cells, cloth.allowed & ~others & (refused < 2), width)
        if not trial.any():
            break
        wider = continued(cloth.mesh, state, state.cells | trial)
        wider = cloth.registration.run(wider, found.texel, Smoothness(), rounds=3, blur_px=0.7)
        keep = fitting_cells(cloth, wider, found.texel)
        refused += trial & ~keep
        gained = int((keep & ~state.cells).sum())
        state = replace(wider, cells=keep)
        found = Fit(found.texel, (*found.pieces[:-1], state))
        yield Progress(step.fraction, step.note, stage(cloth, found))
        if gained < 3:
            break
    return found


def fitting_cells(cloth: Cloth, state: State, texel: Texel) -> Bools:
    """Return the cells in use in which the texture explains the photo."""
    bad = misfit(cloth.photo, *model(cloth.mesh, state, texel), cloth.valid.astype(float), texel, cloth.sigma_px)
    return without_specks(np.asarray(state.cells & (cloth.mesh.cell_means(bad) < LIMIT), np.bool_), 4)


def with_more_pieces(cloth: Cloth, canvas: Canvas, found: Fit, M: Floats, rng: np.random.Generator) -> Job[Fit]:
    """Return the fit with further parts of the cloth: beyond seams, sleeves, folds that hide the connection."""
    for number in range(MOST_PIECES - 1):
        free = cloth.valid & ~cloth.mesh.pixels_of(found.cells)
        if free.sum() < 6 * cloth.side_px**2:
            break
        yield Progress(0.4 + 0.05 * number, "looking for further pieces", stage(cloth, found))
        rest = Canvas(canvas.image, free.astype(np.float32)[..., None])
        known = vertices(cloth.mesh, found.pieces[0])
        lattice = find_piece(rest, known, cloth.basis, rng)
        if lattice is None:
            break
        start = starting_state(cloth, lattice)
        start = replace(start, cells=start.cells & ~found.cells)
        start = cloth.registration.run(start, found.texel, Smoothness(), rounds=6, blur_px=1.0)
        start = replace(start, cells=fitting_cells(cloth, start, found.texel))
        if start.cells.sum() * cloth.mesh.cell**2 < 2 * cloth.side_px**2:
            break
        wider = Fit(found.texel, (*found.pieces, start))
        found = yield from followed(cloth, wider, Progress(0.42 + 0.05 * number, "following the cloth"))
    return found


def stage(cloth: Cloth, found: Fit) -> Stage:
    """Return what a fit can show."""
    uv = np.full((*cloth.valid.shape, 2), np.nan)
    for piece in found.pieces:
        inside = cloth.mesh.pixels_of(piece.cells) & cloth.valid
        uv[inside] = cloth.mesh.to_pixels(piece.uv)[inside]
    return Stage("mesh", None, found.texel, uv)
