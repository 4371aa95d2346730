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
from core.overlay.region import (
    LIMIT,
    Tolerance,
    continued,
    misfit_of_cells,
    ring,
    sums_of_cells,
    tolerance_of,
    without_specks,
)
from core.overlay.registration import Registration, Smoothness, State
from core.overlay.seeding import NoPatternError, find_texels, grown_piece
from core.overlay.stages import Stage
from core.overlay.texel import Texel, estimate_texel
from core.overlay.thin_plate import spread
from core.progress import Job, Progress

IN_REGION = 1.25
"""Leniency where a region is given: nothing but cloth should be there."""
MOST_PIECES, MOST_CANDIDATES = 12, 16
LEAST_EVENNESS = 0.12
"""Change of colour along stripes over that across them, below which only one direction repeats."""
SIZES = (0.1, 8.0)
"""Area of cloth under a cell, over the usual: any even patch looks like a texel blown up."""
LARGEST_BREAK = 0.3
"""Lattice steps by which two pieces may miss each other and still be one."""
LEAST_STEPS, LEAST_PIECE, LEAST_SHARE = 4, 3, 0.03
"""Area, in lattice steps, below which nothing was found, and of a further piece, also over the first."""
LEAST_RHO = 0.02


@dataclass(frozen=True)
class Cloth:
    """What stays the same while a photo is fitted."""

    photo: Floats
    """(H, W, 3), 0 to 1."""
    canvas: Canvas
    """The photo freed of slow changes of light, and where cloth may be."""
    lattice: Lattice
    """The lattice that was found, of steps that may be finer than the texel."""
    M: Floats
    """(2, 2), columns are the texel's sides in steps of the lattice."""
    mesh: Mesh
    registration: Registration

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

    @property
    def allowed(self) -> Bools:
        """Cells that may be cloth."""
        return np.asarray(self.mesh.cell_means(self.valid.astype(float)) > 0.3, np.bool_)

    @property
    def step_px(self) -> float:
        """Side of a square of the area of one lattice step."""
        return float(np.sqrt(self.lattice.texel_area))

    @property
    def texel_samples(self) -> tuple[int, int]:
        """Height and width of the texel in samples."""
        width, height = DENSITY * np.linalg.norm(self.basis, axis=0)
        return max(4, round(float(height))), max(4, round(float(width)))

    @property
    def sigma_px(self) -> float:
        """Width of the neighbourhood in which a fit is judged."""
        return max(0.35 * self.step_px, 3.0)

    def steps_of(self, cells: Bools) -> float:
        """Return the area of cells in lattice steps."""
        return float(cells.sum()) * self.mesh.cell**2 / self.step_px**2


@dataclass(frozen=True)
class Fit:
    """A texel and the pieces of cloth that it is registered with; their cells do not overlap."""

    texel: Texel
    pieces: tuple[State, ...]
    tolerance: Tolerance

    @property
    def cells(self) -> Bools:
        """Cells of all pieces."""
        return np.asarray(np.any([piece.cells for piece in self.pieces], axis=0), np.bool_)


def make_cloth(photo: Floats, canvas: Canvas, lattice: Lattice, M: Floats) -> Cloth:
    """Return the cloth of a photo whose texel is M of a lattice's steps."""
    # About four cells to a step (NRT sec. 3.2: finer than the lattice).
    cell = int(np.clip(2 * round(np.sqrt(lattice.texel_area) / 8), 4, 14))
    mesh = Mesh(photo.shape[:2], cell)
    registration = Registration(mesh, photo, canvas.valid[..., 0].astype(np.float64), lattice.basis @ M)
    return Cloth(photo, canvas, lattice, M, mesh, registration)


def fit(
    photo: Floats, canvas: Canvas, lattices: list[Lattice], seed: int, *, trusted: bool = False
) -> Job[tuple[Cloth, Fit]]:
    """Return the cloth registered from the lattice of its largest part, and of others if there are.

    A `trusted` lattice is the user's: its steps are the texel.
    """
    lattice = lattices[0]
    cloth = make_cloth(photo, canvas, lattice, np.eye(2))
    start = starting_state(cloth, lattice)
    if not trusted:
        cloth = make_cloth(photo, canvas, lattice, true_period(cloth, start, seed))
    start = replace(start, uv=start.uv @ np.linalg.inv(cloth.M).T)
    found = measured(cloth, estimated(cloth, (start,)), (start,))
    if found.texel.blurred(0.1 * cloth.step_px, cloth.basis).evenness(cloth.basis) < LEAST_EVENNESS:
        raise NoPatternError
    for number, blur_px in enumerate((1.5, 0.7)):
        yield Progress(0.05 + 0.1 * number, "registering", stage(cloth, found))
        found = refitted(cloth, found, rounds=5, blur_px=blur_px)
    found = yield from followed(cloth, found, Progress(0.25, "following the cloth"))
    if cloth.steps_of(found.cells) < LEAST_STEPS:
        raise NoPatternError
    for other in lattices[1:]:
        found = yield from joined_by(cloth, found, other, Progress(0.4, "following the cloth"))
    found = yield from with_more_pieces(cloth, found, np.random.default_rng(seed))
    for number in range(2):
        yield Progress(0.8 + 0.1 * number, "registering finely", stage(cloth, found))
        found = refitted(cloth, found, rounds=4)
    return cloth, found


def starting_state(cloth: Cloth, lattice: Lattice) -> State:
    """Return coordinates spread from the lattice, in its own texels, and shading from the local brightness."""
    uv = spread(cloth.mesh, lattice)
    cells = near_lattice(cloth.mesh, lattice, uv) & (cloth.mesh.cell_means(cloth.valid.astype(float)) > 0.5)
    brightness = cloth.photo.mean(-1) / np.maximum(cloth.canvas.image.mean(-1), 1e-3)
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


def true_period(cloth: Cloth, state: State, seed: int) -> Floats:
    """Return the sides (2, 2), in lattice steps, of the smallest texel that explains the photo in colour."""
    M = np.eye(2)
    weight = cloth.mesh.pixels_of(state.cells) * cloth.valid.astype(float)
    at = cloth.mesh.to_pixels(state.uv)
    for count in (2, 3, 2):
        if len(cloth.lattice) < 8 * count**2 * abs(np.linalg.det(M)):
            continue
        halves = estimate_halves(cloth.canvas.image.astype(float), at @ np.linalg.inv(M).T, weight, count, seed)
        finer = cloth.lattice.basis @ M
        M = M @ np.rint(np.linalg.solve(finer, reduced(finer @ coarser(halves))))
    return M


def estimated(cloth: Cloth, pieces: tuple[State, ...]) -> Texel:
    """Return the texel that the pieces show."""
    uv, rho, weight = np.zeros((*cloth.valid.shape, 2)), np.ones(cloth.valid.shape), np.zeros(cloth.valid.shape)
    for piece in pieces:
        at = cloth.mesh.to_pixels(piece.values)
        inside = cloth.mesh.pixels_of(piece.cells) & cloth.valid
        uv[inside], rho[inside], weight[inside] = at[inside, :2], at[inside, 2], 1.0
    return estimate_texel(cloth.photo, uv, rho, weight, cloth.texel_samples)


def measured(cloth: Cloth, texel: Texel, pieces: tuple[State, ...]) -> Fit:
    """Return the fit of a texel and pieces with the tolerance that they suggest."""
    whole = cloth.registration.by_cells()
    sums = np.concatenate([sums_of_cells(cloth.mesh, *whole, piece, texel) for piece in pieces])
    return Fit(texel, pieces, tolerance_of(sums, texel, IN_REGION if cloth.in_region else 1.0))


def refitted(cloth: Cloth, found: Fit, *, rounds: int, blur_px: float = 0.0) -> Fit:
    """Return the pieces registered anew and the texel estimated anew from them."""
    run = cloth.registration.run
    pieces = tuple(run(piece, found.texel, Smoothness(), rounds=rounds, blur_px=blur_px) for piece in found.pieces)
    return measured(cloth, estimated(cloth, pieces), pieces)


def followed(cloth: Cloth, found: Fit, step: Progress) -> Job[Fit]:
    """Return the fit with its last piece grown until the cloth ends (NRT sec. 3.2)."""
    state = found.pieces[-1]
    free_cells = cloth.allowed & ~(found.cells & ~state.cells)
    refused = np.zeros(state.cells.shape, np.int64)
    width = max(1, round(0.4 * cloth.step_px / cloth.mesh.cell))
    for _ in range(60):
        trial = ring(state.cells, free_cells & (refused < 2), width)
        if not trial.any():
            break
        before = state
        state = widened(cloth, state, trial, found)
        refused += trial & ~state.cells
        yield Progress(step.fraction, step.note)
        if (state.cells & ~before.cells).sum() < 3:
            break
    return replace(found, pieces=(*found.pieces[:-1], state))


def widened(cloth: Cloth, state: State, trial: Bools, found: Fit) -> State:
    """Return the state with those of the trial cells that the texture explains once they are registered.

    Only the trial cells move; a band of old ones is registered with them, to hold them.
    """
    wider = continued(cloth.mesh, state, state.cells | trial)
    band = trial | ring(trial, state.cells, 4)
    moved = cloth.registration.run(replace(wider, cells=band), found.texel, Smoothness(), rounds=3, blur_px=0.7)
    free_nodes = cloth.mesh.nodes_of(trial)
    wider = replace(
        wider,
        uv=np.where(free_nodes[..., None], moved.uv, wider.uv),
        rho=np.where(free_nodes, moved.rho, wider.rho),
    )
    kept = fitting_cells(cloth, replace(wider, cells=band), found)
    return replace(wider, cells=without_specks((state.cells & ~band) | kept, 4))


def misfits(cloth: Cloth, state: State, found: Fit) -> Floats:
    """Return the misfit (rows, columns) of the cells in use, by the measure of what has been found."""
    sums = sums_of_cells(cloth.mesh, *cloth.registration.by_cells(), state, found.texel)
    return misfit_of_cells(cloth.mesh, state.cells, sums, found.tolerance, cloth.sigma_px)


def fitting_cells(cloth: Cloth, state: State, found: Fit) -> Bools:
    """Return the cells in use in which the texture explains the photo, neither blown up nor crushed."""
    usual = cloth.mesh.cell**2 / abs(np.linalg.det(cloth.basis))
    sizes = np.abs(cloth.mesh.areas(state.uv, state.cells)) / usual
    sound = state.cells.copy()
    sound[state.cells] = (sizes.min(1) > SIZES[0]) & (sizes.max(1) < SIZES[1])
    return np.asarray(sound & (misfits(cloth, state, found) < LIMIT), np.bool_)


def with_more_pieces(cloth: Cloth, found: Fit, rng: np.random.Generator) -> Job[Fit]:
    """Return the fit with further parts of the cloth: beyond seams, sleeves, folds that hide the connection."""
    for attempt in range(2):
        rest = free(cloth, found)
        if rest.valid.sum() < 3 * cloth.step_px**2:
            break
        yield Progress(0.4 + 0.2 * attempt, "looking for further pieces", stage(cloth, found))
        candidates = find_texels(rest, cloth.lattice, rng)
        for row in range(min(len(candidates), MOST_CANDIDATES)):
            x, y = np.rint(candidates.points[row]).astype(int)
            if len(found.pieces) < MOST_PIECES and rest.valid[y, x]:
                step = Progress(0.4 + 0.2 * attempt, "following the cloth")
                piece = grown_piece(rest, cloth.lattice, candidates[np.array([row])])
                found = yield from joined_by(cloth, found, piece, step)
                rest = free(cloth, found)
    return found


def free(cloth: Cloth, found: Fit) -> Canvas:
    """Return the canvas limited to what no piece has."""
    rest = cloth.valid & ~cloth.mesh.pixels_of(found.cells)
    return Canvas(cloth.canvas.image, rest.astype(np.float32)[..., None])


def joined_by(cloth: Cloth, found: Fit, lattice: Lattice, step: Progress) -> Job[Fit]:
    """Return the fit with the piece that begins at another lattice, if the texture explains enough of it."""
    start = starting_state(cloth, lattice)
    start = replace(start, cells=start.cells & ~found.cells)
    if cloth.steps_of(start.cells) < 0.5:
        return found
    start = in_step(cloth, start, found)
    start = replace(start, cells=fitting_cells(cloth, start, found))
    if cloth.steps_of(start.cells) < 0.5:
        return found
    wider = yield from followed(cloth, replace(found, pieces=(*found.pieces, start)), step)
    new = wider.pieces[-1]
    pieces = merged(cloth, found.pieces, new)
    apart = len(pieces) > len(found.pieces)
    share = LEAST_SHARE if cloth.in_region else 3 * LEAST_SHARE
    least = max(LEAST_PIECE, share * cloth.steps_of(found.pieces[0].cells)) if apart else 1.0
    return replace(found, pieces=pieces) if cloth.steps_of(new.cells) > least else found


def merged(cloth: Cloth, pieces: tuple[State, ...], new: State) -> tuple[State, ...]:
    """Return the pieces with a new one, made one with an old one that it continues without a break."""
    for number, old in enumerate(pieces):
        near = ring(old.cells, new.cells, 3)
        if near.sum() < 4:
            continue
        carried = continued(cloth.mesh, old, old.cells | near)
        nodes = cloth.mesh.nodes_of(near) & ~cloth.mesh.nodes_of(old.cells)
        gap = (carried.uv - new.uv)[nodes]
        step = np.rint(np.median(gap, axis=0)) if len(gap) else np.zeros(2)
        rest = np.abs((gap - step) @ cloth.basis.T).max(1) / cloth.step_px
        if len(gap) and np.median(rest) < LARGEST_BREAK:
            mine = cloth.mesh.nodes_of(new.cells) & ~cloth.mesh.nodes_of(old.cells)
            uv = np.where(mine[..., None], new.uv + step, old.uv)
            whole = State(uv, np.where(mine, new.rho, old.rho), old.cells | new.cells)
            if not folded(cloth.mesh, whole):
                return (*pieces[:number], whole, *pieces[number + 1 :])
    return (*pieces, new)


def folded(mesh: Mesh, state: State) -> bool:
    """Return whether the triangles of a state turn in different senses."""
    areas = mesh.areas(state.uv, state.cells)
    return bool(areas.min() < 0 < areas.max())


def in_step(cloth: Cloth, state: State, found: Fit) -> State:
    """Return a state in lattice steps registered in texels: of a texel's several steps the one that fits best."""
    count = round(abs(float(np.linalg.det(cloth.M))))
    inverse = np.linalg.inv(cloth.M)
    tried: list[tuple[float, State]] = []
    for shift in classes(cloth.M, count):
        moved = replace(state, uv=(state.uv + shift) @ inverse.T)
        moved = cloth.registration.run(moved, found.texel, Smoothness(), rounds=6 if count == 1 else 4, blur_px=1.0)
        tried.append((float(misfits(cloth, moved, found)[state.cells].mean()), moved))
    return min(tried, key=lambda pair: pair[0])[1]


def classes(M: Floats, count: int) -> Floats:
    """Return one integer vector (count, 2) of every class of Z² modulo the columns of M."""
    steps = np.stack(np.meshgrid(np.arange(count), np.arange(count)), -1).reshape(-1, 2)
    places = np.round(steps @ np.linalg.inv(M).T % 1, 6) % 1
    return np.asarray(steps[np.unique(places, axis=0, return_index=True)[1]], np.float64)


def stage(cloth: Cloth, found: Fit) -> Stage:
    """Return what a fit can show."""
    uv = np.full((*cloth.valid.shape, 2), np.nan)
    for piece in found.pieces:
        inside = cloth.mesh.pixels_of(piece.cells) & cloth.valid
        uv[inside] = cloth.mesh.to_pixels(piece.uv)[inside]
    return Stage("mesh", None, found.texel, uv, cloth.mesh.size)
