"""From a lattice to the registered cloth: start, growth to the cloth's end, further pieces, texel and mesh in turn."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from core.arrays import Floats
from core.overlay.detection.alignment import FlatPicture
from core.overlay.detection.basis import reduce
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.period import coarser, estimate_halves, far_period
from core.overlay.detection.seeding import NoPatternError
from core.overlay.registration.cloth import (
    Fit,
    FittedCloth,
    estimate,
    make_cloth,
    make_divided_cloth,
    measure,
    stage,
    starting_state,
)
from core.overlay.registration.coarse_mesh import coarsen, correct
from core.overlay.registration.evidence import choose_weave
from core.overlay.registration.pieces import join_by, with_more_pieces
from core.overlay.registration.region import look_at
from core.overlay.registration.region_growing import followed, prune
from core.overlay.registration.registration import ClothState
from core.overlay.texel import Texel
from core.overlay.tolerances import SMOOTH_PX
from core.progress import Job, Progress

LEAST_EVENNESS = 0.12
"""Change of colour along stripes over that across them, below which only one direction repeats."""
LEAST_STEPS = 4
"""Area, in lattice steps, below which nothing was found."""
LEAST_BLUR_PX = 1.0
"""Blur, in pixels of a halved photo, from which that shows as much as the photo."""
DRAWS = 3
"""Times that the texels are drawn anew where they seem to differ."""


def fit(
    photo: Floats, canvas: FlatPicture, lattices: list[Lattice], seed: int, *, trusted: bool
) -> Job[tuple[FittedCloth, Fit]]:
    """Return the cloth registered from the lattice of its largest part, and of others if there are.

    A `trusted` lattice is the user's: its steps are the texel. Raises `NoPatternError` where nothing can be followed.
    """
    cloth, found = yield from begun(photo, canvas, lattices[0], seed, trusted=trusted)
    return (yield from complete(cloth, found, lattices[1:], seed))


def begun(
    photo: Floats, canvas: FlatPicture, lattice: Lattice, seed: int, *, trusted: bool = False
) -> Job[tuple[FittedCloth, Fit]]:
    """Return the cloth registered where its lattice lies.

    Raises `NoPatternError` where there are stripes only, and where no texel lies on what may be cloth.
    """
    cloth = make_divided_cloth(photo, canvas, lattice) if trusted else make_cloth(photo, canvas, lattice, np.eye(2))
    start = starting_state(cloth, lattice)
    if not start.cells.any():
        raise NoPatternError
    if not trusted:
        M = true_period(cloth, start, seed)
        if abs(np.linalg.det(M)) > 1.5:
            # Vertices that lie badly make texels look different: what counts is how they look once registered.
            found = measure(cloth, estimate(cloth, (start,)), (start,))
            start = refit(cloth, found, rounds=5, blurs_px=(1.5,)).pieces[0]
            M = true_period(cloth, start, seed)
        cloth = cloth if np.array_equal(M, cloth.M) else make_cloth(photo, canvas, lattice, M)
        start = replace(start, uv=start.uv @ np.linalg.inv(cloth.M).T)
    found = measure(cloth, estimate(cloth, (start,)), (start,))
    if evenness(cloth, found) < LEAST_EVENNESS:
        raise NoPatternError
    yield Progress(0.05, "registering", stage(cloth, found))
    return choose_weave(cloth, found, lambda cloth, found: refit(cloth, found, rounds=5, blurs_px=(1.5, 0.7)))[:2]


def complete(cloth: FittedCloth, found: Fit, others: list[Lattice], seed: int) -> Job[tuple[FittedCloth, Fit]]:
    """Return the cloth followed to its end from where it has been registered, with its further pieces.

    Raises `NoPatternError` where hardly anything can be followed.
    """
    found = yield from followed(cloth, prune(cloth, found), Progress(0.25, "following the cloth"))
    if cloth.steps_of(found.cells) < LEAST_STEPS:
        raise NoPatternError
    for other in others:
        found = yield from join_by(cloth, found, other, Progress(0.4, "following the cloth"))
    found = yield from with_the_rest(cloth, found, seed)
    yield Progress(0.9, "registering finely", stage(cloth, found))
    return cloth, refit(cloth, found, rounds=4)


def with_the_rest(cloth: FittedCloth, found: Fit, seed: int) -> Job[Fit]:
    """Return the cloth with its further pieces, the first one followed anew where it proves to lie wrong.

    Raises `NoPatternError` where following gives up all of it.
    """
    rng = np.random.default_rng(seed)
    for fraction in (0.4, 0.6):
        before = found
        found = yield from with_more_pieces(cloth, found, rng, fraction)
        if found is before:
            break
    yield Progress(0.8, "registering finely", stage(cloth, found))
    found = refit(cloth, found, rounds=3)
    # What is wrong shows now that the texel is sharp; the rest of the cloth may lead there another way.
    found = prune(cloth, replace(found, pieces=(*found.pieces[1:], found.pieces[0])))
    found = yield from followed(cloth, found, Progress(0.85, "following the cloth"))
    pieces = tuple(piece for piece in (found.pieces[-1], *found.pieces[:-1]) if piece.cells.any())
    if not pieces:
        raise NoPatternError
    return replace(found, pieces=pieces)


def evenness(cloth: FittedCloth, found: Fit) -> float:
    """Return how much the texel changes along its stripes over across them, without its grain."""
    return found.texel.blurred(0.1 * cloth.step_px, cloth.basis).evenness(cloth.basis)


def true_period(cloth: FittedCloth, state: ClothState, seed: int) -> Floats:
    """Return the sides (2, 2), in lattice steps, of the smallest texel that explains the photo in colour."""
    M = np.diag(far_period(cloth.canvas, cloth.lattice)).astype(float)
    seen = look_at(cloth.registration, [state])
    flat, at = cloth.mesh.in_cells(cloth.canvas.image)[state.cells], seen.at[..., :2]
    for count in (2, 3, 2):
        if len(cloth.lattice) < 8 * count**2 * abs(np.linalg.det(M)):
            continue
        drawn = partial(estimate_halves, flat, at @ np.linalg.inv(M).T, seen.weight, count)
        steps = coarser(drawn(seed))
        if abs(np.linalg.det(steps)) > 1.5:
            # Few texels look different by chance: others have to agree.
            steps = coarser(*(drawn(seed + k) for k in range(DRAWS)))
        finer = cloth.lattice.basis @ M
        M = M @ np.rint(np.linalg.solve(finer, reduce(finer @ steps)))
    return M


def refit(
    cloth: FittedCloth, found: Fit, *, rounds: int, blurs_px: Sequence[float] = (0.0,), is_stiff: bool = False
) -> Fit:
    """Return the pieces registered anew, under one blur after another, and the texel estimated anew from them.

    What `is_stiff` is the smoother the wider the blur is (`register_under`). What cloth may miss is told by what most
    texels show, which misses less of even ground than the mean does: by the mean, cloth would be followed beyond its
    end.
    """
    texel, pieces = found.texel, found.pieces
    for blur_px in blurs_px:
        texel, pieces = register_under(cloth, texel, pieces, rounds, blur_px, is_stiff=is_stiff)
    return replace(measure(cloth, estimate(cloth, pieces), pieces), texel=texel)


def register_under(
    cloth: FittedCloth,
    texel: Texel,
    pieces: tuple[ClothState, ...],
    rounds: int,
    blur_px: float,
    *,
    is_stiff: bool = False,
) -> tuple[Texel, tuple[ClothState, ...]]:
    """Return the pieces registered under a blur, on the coarsest mesh that shows as much, and the texel estimated anew.

    The change is carried to finer meshes (a coarse-grid correction). What `is_stiff` bends within lengths that grow as
    the blur does: lengths grow as the fourth root of the weight of the smoothness.
    """
    if blur_px >= 2 * LEAST_BLUR_PX and cloth.can_be_coarser:
        starts = tuple(coarsen(cloth.mesh, piece) for piece in pieces)
        texel, ends = register_under(cloth.coarser, texel, starts, rounds, blur_px / 2, is_stiff=is_stiff)
        return texel, tuple(map(correct, pieces, starts, ends))
    run, firm = cloth.registration.run, max(1.0, blur_px / SMOOTH_PX) ** 4 if is_stiff else 1.0
    pieces = tuple(run(piece, texel, rounds=rounds, blur_px=blur_px, firm=firm) for piece in pieces)
    return estimate(cloth, pieces, by_mean=True), pieces
