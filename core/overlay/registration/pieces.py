"""Further pieces of the cloth: beyond seams, sleeves, folds that hide the connection.

They begin at places that look like texels of the cloth that is followed, then at keypoints that match its own. Of large
texels, divided into steps that look like nothing of one another, only keypoints tell.
"""

from dataclasses import replace
from itertools import islice

import numpy as np

from core.arrays import Bools, Floats
from core.overlay.detection.alignment import FlatPicture
from core.overlay.detection.corrections import LEAST_VERTICES
from core.overlay.detection.lattice import Lattice, mean_template
from core.overlay.detection.seeding import find_texels, grown_piece
from core.overlay.mesh import ClothMesh
from core.overlay.registration.cloth import Fit, FittedCloth, fitting_cells, misfits, stage, starting_state
from core.overlay.registration.matched_keypoints import OFF, by_chance, find_starts, match
from core.overlay.registration.orientation import turned
from core.overlay.registration.region import LIMIT, continue_on, ring
from core.overlay.registration.region_growing import followed
from core.overlay.registration.registration import ClothState
from core.overlay.tolerances import SMOOTH_PX
from core.progress import Job, Progress

MOST_PIECES, MOST_CANDIDATES = 12, 16
LARGEST_BREAK = 0.3
"""Lattice steps by which two pieces may miss each other and still be one."""
LEAST_START, LEAST_PIECE = (0.5, 0.25), (3.0, 1.2)
"""Least area with which a further piece begins and ends, in lattice steps; of texels that the cloth shows few of, one
is unlike all else."""
LEAST_SHARE = 0.03
"""The same over the first piece; three times that without a region."""


def with_more_pieces(
    cloth: FittedCloth,
    found: Fit,
    rng: "np.random.Generator",
    fraction: float,
) -> Job[Fit]:
    """Return the fit with further parts of the cloth: beyond seams, sleeves, folds that hide the connection.

    `fraction` is the progress made. Where one was followed in vain none is looked for again.
    """
    if free(cloth, found.cells).valid.sum() < 3 * cloth.step_px**2:
        return found
    yield Progress(fraction, "looking for further pieces", stage(cloth, found))
    step = Progress(fraction, "following the cloth")
    if not cloth.is_divided:
        found = yield from with_like_texels(cloth, found, rng, step)
    matches, taken = match(cloth, found), found.cells.copy()
    for start in islice(find_starts(cloth, matches, taken), MOST_CANDIDATES):
        if len(found.pieces) < MOST_PIECES:
            piece = yield from follow_from(cloth, found, start, step)
            if matches.confirm(cloth.mesh, piece) > by_chance(MOST_CANDIDATES):
                found = join(cloth, found, piece)
                taken |= found.cells
    return found


def with_like_texels(cloth: FittedCloth, found: Fit, rng: "np.random.Generator", step: Progress) -> Job[Fit]:
    """Return the fit with the pieces that begin at places which look like the mean step of the lattice."""
    tried = found.cells
    rest = free(cloth, tried)
    template = mean_template(cloth.canvas.everywhere(), cloth.lattice.frames)
    candidates = find_texels(rest, cloth.lattice, rng)
    for row in range(min(len(candidates), MOST_CANDIDATES)):
        x, y = np.rint(candidates.points[row]).astype(int)
        if len(found.pieces) < MOST_PIECES and rest.valid[y, x]:
            piece = grown_piece(rest, template, candidates[np.array([row])])
            if len(piece) >= (1 if cloth.few else LEAST_VERTICES):
                start = starting_state(cloth, piece)
                new = yield from follow_steps(cloth, found, start, step)
                found, tried = join(cloth, found, new), tried | start.cells | new.cells
                rest = free(cloth, tried)
    return found


def free(cloth: FittedCloth, cells: Bools) -> FlatPicture:
    """Return the canvas limited to what is not in these cells."""
    rest = cloth.valid & ~cloth.mesh.pixels_of(cells)
    return FlatPicture(cloth.canvas.image, rest.astype(np.float32)[..., None])


def join_by(cloth: FittedCloth, found: Fit, lattice: Lattice, step: Progress) -> Job[Fit]:
    """Return the fit with the piece that begins at another lattice of texels, if the texture explains enough of it."""
    start = starting_state(cloth, lattice)
    start = replace(start, uv=start.uv @ cloth.M.T)
    return join(cloth, found, (yield from follow_steps(cloth, found, start, step)))


def follow_steps(cloth: FittedCloth, found: Fit, start: ClothState, step: Progress) -> Job[ClothState]:
    """Return the piece that begins so, in lattice steps, as far as it was followed; what is too small is not."""
    start = replace(start, cells=start.cells & ~found.cells)
    if cloth.steps_of(start.cells) < LEAST_START[cloth.few]:
        return start
    return (yield from follow_registered(cloth, found, in_step(cloth, start, found), step))


def follow_from(cloth: FittedCloth, found: Fit, start: ClothState, step: Progress) -> Job[ClothState]:
    """Return the piece that begins about so, in texels, as far as it was followed; what is too small is not."""
    if cloth.steps_of(start.cells) < LEAST_START[cloth.few]:
        return start
    for blur_px in (OFF * cloth.side_px / 2, OFF * cloth.side_px / 4, SMOOTH_PX):
        start = cloth.registration.run(start, found.texel, rounds=4, blur_px=blur_px)
    return (yield from follow_registered(cloth, found, start, step))


def follow_registered(cloth: FittedCloth, found: Fit, start: ClothState, step: Progress) -> Job[ClothState]:
    """Return the piece that begins so, registered, as far as it was followed; what is too small is not."""
    start = replace(start, cells=fitting_cells(cloth, start, found, limit=LIMIT))
    if cloth.steps_of(start.cells) < LEAST_START[cloth.few]:
        return start
    return (yield from followed(cloth, replace(found, pieces=(*found.pieces, start)), step)).pieces[-1]


def join(cloth: FittedCloth, found: Fit, new: ClothState) -> Fit:
    """Return the fit with a new piece if that is large enough."""
    if cloth.steps_of(new.cells) <= 1:
        return found
    pieces = merge(cloth, found.pieces, new)
    apart = len(pieces) > len(found.pieces)
    share = LEAST_SHARE if cloth.in_region else 3 * LEAST_SHARE
    least = max(LEAST_PIECE[cloth.few], share * cloth.steps_of(found.pieces[0].cells)) if apart else 1.0
    return replace(found, pieces=pieces) if cloth.steps_of(new.cells) > least else found


def merge(cloth: FittedCloth, pieces: tuple[ClothState, ...], new: ClothState) -> tuple[ClothState, ...]:
    """Return the pieces with a new one, made one with an old one that it continues without a break."""
    for number, old in enumerate(pieces):
        near = ring(old.cells, new.cells, 3)
        if near.sum() < 4:
            continue
        carried = continue_on(cloth.mesh, old, old.cells | near)
        nodes = cloth.mesh.nodes_of(near) & ~cloth.mesh.nodes_of(old.cells)
        gap = (carried.uv - new.uv)[nodes]
        step = np.rint(np.median(gap, axis=0)) if len(gap) else np.zeros(2)
        rest = np.abs((gap - step) @ cloth.basis.T).max(1) / cloth.step_px
        if len(gap) and np.median(rest) < LARGEST_BREAK:
            mine = cloth.mesh.nodes_of(new.cells) & ~cloth.mesh.nodes_of(old.cells)
            uv = np.where(mine[..., None], new.uv + step, old.uv)
            whole = ClothState(uv, np.where(mine, new.rho, old.rho), old.cells | new.cells)
            if not is_folded(cloth.mesh, whole):
                return (*pieces[:number], whole, *pieces[number + 1 :])
    return (*pieces, new)


def is_folded(mesh: ClothMesh, state: ClothState) -> bool:
    """Return whether the triangles of a state turn in different senses."""
    areas = mesh.areas(state.uv, state.cells)
    return bool(areas.min() < 0 < areas.max())


def in_step(cloth: FittedCloth, state: ClothState, found: Fit) -> ClothState:
    """Return a state in lattice steps registered in texels: of a texel's several steps the one that fits best.

    Where the texture is alike when turned, it lies as the cloth beside it.
    """
    count = round(abs(float(np.linalg.det(cloth.M))))
    inverse = np.linalg.inv(cloth.M)
    run, tried = cloth.registration.run, list[tuple[float, ClothState]]()
    for shift in classes(cloth.M, count):
        moved = replace(state, uv=(state.uv + shift) @ inverse.T)
        moved = run(moved, found.texel, rounds=6 if count == 1 else 4, blur_px=1.0)
        tried.append((float(misfits(cloth, moved, found)[state.cells].mean()), moved))
    best = min(tried, key=lambda pair: pair[0])[1]
    lying = turned(cloth.mesh, best, found.pieces, found.texel, cloth.basis)
    return best if lying is best else run(lying, found.texel, rounds=4, blur_px=1.0)


def classes(M: Floats, count: int) -> Floats:
    """Return one integer vector (count, 2) of every class of Z² modulo the columns of M."""
    steps = np.stack(np.meshgrid(np.arange(count), np.arange(count)), -1).reshape(-1, 2)
    places = np.round(steps @ np.linalg.inv(M).T % 1, 6) % 1
    return np.asarray(steps[np.unique(places, axis=0, return_index=True)[1]], np.float64)
