"""Texels so large that the cloth shows few of them: no lattice grows there, but alike places lie a texel apart.

Votes of pairs of them, keypoints or patches, tell the lattice (`displacement_votes`). The same pairs then lay the mesh:
a thin plate whose coordinates differ by whole numbers between the two places of a pair.
"""

from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
import scipy

from core.arrays import Bools, Floats
from core.linalg.factor import Factor
from core.overlay.detection.alignment import FlatPicture, PatchFrames
from core.overlay.detection.alike_patches import find_alike_patches
from core.overlay.detection.basis import is_about
from core.overlay.detection.displacement_votes import LIKELY, SURE, Pairs, count_votes, find_alike, find_bases
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError
from core.overlay.filters.magnifying import LEAST_SIZE_PX, TIMES, can_be_magnified, enlarged, enlarged_mask
from core.overlay.filters.shrinking import to_small
from core.overlay.mesh import ClothMesh
from core.overlay.registration.cloth import Fit, FittedCloth, estimate, make_divided_cloth, measure
from core.overlay.registration.coarse_mesh import at_finer_nodes
from core.overlay.registration.evidence import Evidence, choose_weave, weigh
from core.overlay.registration.fitting import refit
from core.overlay.registration.region_growing import followed, prune
from core.overlay.registration.registration import ClothState
from core.overlay.registration.thin_plate import interpolation
from core.overlay.texel import draw_sample
from core.overlay.tolerances import SMOOTH_PX
from core.progress import Job, Progress, part

Correspondences: TypeAlias = Literal["keypoints", "patches"]

NOTE = "looking for large texels"
LARGE_PX = 30.0
"""Side of a large texel at least."""
LEAST_TEXELS = 3.0
"""Area, in texels, that has to be seen: one, and its neighbour along either vector; twice that without a region."""
TRIED = 3
"""Lattices that are laid: votes propose, what the texel explains decides."""
UNTOLD: dict[Correspondences, float] = {"keypoints": LIKELY, "patches": 35.0}
"""Surplus of votes from which a lattice is likely where nobody said that there is cloth. Patches along stripes are
alike, with 33 at most; prints and plaids have 38 to 88 (of 160 clothes drawn by chance)."""
TOLERANCES = np.geomspace(0.25, 0.08, 8)
"""Texels by which a pair may miss a whole number, while the plate is fitted again and again (Tukey's biweight)."""
BEND = 1.0
"""Weight of the plate's second differences on a mesh whose cells are one texel, over that of a pair."""
MOST_PAIRS = 200_000
"""Pairs that are drawn by chance where there are more: large prints show fewer."""
BLUR = 0.16
"""Blur, over the side of a texel, under which the mesh is registered first; then under half of it, and so on."""


@dataclass(frozen=True)
class LaidLattice:
    """A lattice laid on the cloth by its pairs of alike places."""

    sure: float
    """Surplus of its votes."""
    cloth: FittedCloth
    start: Fit
    """The cloth as the pairs lay it."""


def find_large(
    photo: Floats,
    canvas: FlatPicture,
    *,
    alike: Correspondences = "keypoints",
    least: float | None = None,
    texel_px: float | None = None,
) -> Job[list[tuple[FittedCloth, Fit, Evidence]]]:
    """Return what may be the cloth, registered and followed from pairs of alike places that lie whole texels apart.

    Of few texels what one foretells of another tells little of which lattice is right: all that are followed are
    returned, at most `TRIED`, those that explain most. Votes have to be certain of them, in a region, or more has to
    speak for them than against them. Unless the user says that there is cloth, what one texel foretells of another has
    to be related to that (`Evidence.is_related`). Where the user does, and more speaks against all of them than for
    them, motifs alone are asked too, without their ground.
    `least` tells how many texels have to be seen; without it those of a region count, which the user says is cloth.
    `texel_px` is about the side of a texel where that is known. Raises `NoPatternError` where there is none, or too
    little of it.
    """
    yield Progress(0.0, NOTE)
    is_bounded = not (canvas.valid > 0).all()
    is_cloth = least is None and is_bounded
    least = least or (LEAST_TEXELS if is_cloth else 2 * LEAST_TEXELS)
    finds: list[tuple[FittedCloth, Fit, Evidence]] = []
    for view, done in ((canvas, 0.0), (canvas.of_motifs, 0.5)) if is_cloth else ((canvas, 0.0),):
        job = lay_likely(photo, canvas, view, alike, least, is_cloth=is_cloth, texel_px=texel_px)
        laid = yield from part(job, done, done + 0.25)
        step = Progress(done + 0.25, NOTE)
        for one in laid:
            is_certain = is_bounded and one.sure > SURE
            yield step
            cloth, found, weight = choose_weave(one.cloth, one.start, register_coarsely)
            if not (is_cloth or is_certain or weight.explained > 0):
                continue
            found = yield from followed(cloth, prune(cloth, found), step)
            if not found.cells.any():
                continue
            found = refit(cloth, found, rounds=3)
            texels = float((cloth.valid & cloth.mesh.pixels_of(found.cells)).sum()) / cloth.side_px**2
            weight = weigh(cloth, found)
            if (is_certain or weight.explained > 0) and (is_cloth or (weight.is_related and texels > least)):
                finds.append((cloth, found, weight))
        if any(weight.explained > 0 for *_, weight in finds):
            break
    if not finds:
        raise NoPatternError
    return sorted(finds, key=lambda find: -find[2].explained)[:TRIED]


def lay_likely(
    photo: Floats,
    canvas: FlatPicture,
    view: FlatPicture,
    alike: Correspondences,
    least: float,
    *,
    is_cloth: bool,
    texel_px: float | None,
) -> Job[list[LaidLattice]]:
    """Return the likeliest lattices, of which `least` texels may be seen, laid on what may be, or `is_cloth`.

    Their pairs are those of a `view` of the canvas: itself, or its motifs alone.
    """
    pairs, likely = find_likely(view) if alike == "keypoints" else find_likely_of_patches(view)
    least_sure, room_px = LIKELY if is_cloth else UNTOLD[alike], int((canvas.valid > 0).sum())
    likely = [(sure, basis) for sure, basis in likely if sure > least_sure and is_about(basis, texel_px)]
    laid: list[LaidLattice] = []
    for number, (sure, basis) in enumerate(likely[:TRIED]):
        area_px = float(np.linalg.det(basis))
        if LEAST_TEXELS * area_px > room_px:
            continue
        # What the votes are less sure of are other steps of what has just been told.
        if least * area_px > room_px:
            break
        yield Progress(number / TRIED, NOTE)
        with suppress(NoPatternError):
            # Of what the user says is cloth all is seen, however much of it can be followed.
            laid.append(LaidLattice(sure, *lay(photo, canvas, pairs, basis, 0.0 if is_cloth else least * area_px)))
    return laid


def find_likely(canvas: FlatPicture) -> tuple[Pairs, list[tuple[float, Floats]]]:
    """Return the pairs of alike keypoints, `LARGE_PX` or more apart, and what `find_bases` makes of their votes.

    A small photo is enlarged to tell them. There are three times as many keypoints then, which surpass chance by more:
    only what is certain is likely, and where nothing is, the photo's own pixels tell.
    """
    valid = np.asarray(canvas.valid[..., 0] > 0, np.bool_)
    if can_be_magnified(canvas.shape):
        large, inside = enlarged(canvas.image), enlarged_mask(valid)
        pairs = find_alike(large, inside, TIMES * LARGE_PX, least_size_px=TIMES * LEAST_SIZE_PX)
        likely = find_bases(count_votes(pairs, TIMES * LARGE_PX))
        certain = [(sure, basis / TIMES) for sure, basis in likely if sure > SURE]
        if certain:
            return replace(pairs, points=to_small(pairs.points, TIMES)), certain
    pairs = find_alike(canvas.image, valid, LARGE_PX)
    return pairs, find_bases(count_votes(pairs, LARGE_PX))


def find_likely_of_patches(canvas: FlatPicture) -> tuple[Pairs, list[tuple[float, Floats]]]:
    """Return the pairs of alike patches, `LARGE_PX` or more apart, and what `find_bases` makes of their votes."""
    pairs = find_alike_patches(canvas.image, np.asarray(canvas.valid[..., 0] > 0, np.bool_), LARGE_PX)
    return pairs, find_bases(count_votes(pairs, LARGE_PX))


def lay(photo: Floats, canvas: FlatPicture, pairs: Pairs, basis: Floats, least_px: float) -> tuple[FittedCloth, Fit]:
    """Return the cloth laid around the pairs that lie whole texels of a `basis` (2, 2), pixels, apart.

    The plate through them is told on every second node: between nodes so close to one another it hardly bends. Raises
    `NoPatternError` where no more than `least_px` pixels of cloth lie near the pairs.
    """
    kept = draw_sample(np.ones(len(pairs.first), np.bool_), MOST_PAIRS)
    pairs = replace(pairs, first=pairs.first[kept], second=pairs.second[kept])
    middle = np.median(pairs.points, axis=0)
    lattice = Lattice(np.zeros((1, 2), np.int64), PatchFrames(middle[None], basis[None], np.ones(1)))
    cloth = make_divided_cloth(photo, canvas, lattice)
    wide = ClothMesh(cloth.mesh.shape, 2 * cloth.mesh.cell)
    plate, kept = fit_plate(wide, pairs, (wide.positions() - middle) @ np.linalg.inv(basis).T)
    near, cells = cloth.near_points(pairs.points[np.unique([pairs.first[kept], pairs.second[kept]])])
    if near.sum() <= least_px or not cells.any():
        raise NoPatternError
    rough = ClothState(at_finer_nodes(plate, cloth.mesh.nodes), cloth.brightness, cells)
    return cloth, measure(cloth, estimate(cloth, (rough,)), (rough,))


def register_coarsely(cloth: FittedCloth, found: Fit) -> Fit:
    """Return a fit whose coordinates are rough registered under one blur after another.

    In a region cloth is stiff under a blur; without one ground beside it is registered too, and would draw it along.
    """
    widest = BLUR * cloth.side_px
    blurs_px = widest / 2.0 ** np.arange(max(np.log2(widest / SMOOTH_PX), 0))
    return refit(cloth, found, rounds=5, blurs_px=[*blurs_px.tolist(), SMOOTH_PX], is_stiff=cloth.in_region)


def fit_plate(mesh: ClothMesh, pairs: Pairs, uv: Floats) -> tuple[Floats, Bools]:
    """Return coordinates (R, C, 2), texels, that differ by whole numbers over most pairs, and the pairs (m,) that fit.

    Begins at `uv` (R, C, 2), which turns and scales only.
    """
    ends = (interpolation(mesh, pairs.points[rows]) for rows in (pairs.second, pairs.first))
    differences = scipy.sparse.csr_array(next(ends) - next(ends))
    bending = mesh.bending(np.ones(mesh.nodes, np.bool_))
    stiffness = BEND / abs(np.linalg.det(slope_of(uv))) * (bending.T @ bending)
    # Differences leave a shift free: all nodes are held by very little where they were.
    hold = 1e-6 * scipy.sparse.eye_array(bending.shape[1])
    for tolerance in TOLERANCES:
        found = differences @ uv.reshape(-1, 2)
        whole = np.rint(found)
        off = np.linalg.norm(found - whole, axis=1)
        kept = (off < tolerance) & whole.any(1)
        weight, own = (1 - (off[kept] / tolerance) ** 2) ** 2, differences[kept]
        pull = own.T @ (weight[:, None] * whole[kept]) + hold @ uv.reshape(-1, 2)
        system = own.T @ scipy.sparse.diags_array(weight) @ own + stiffness + hold
        uv = np.asarray(Factor(scipy.sparse.csc_array(system)).solve(pull), np.float64).reshape(uv.shape)
    return uv, np.asarray(kept, np.bool_)


def slope_of(uv: Floats) -> Floats:
    """Return how coordinates (R, C, 2) change from node to node along rows and columns (2, 2), on the whole."""
    return np.stack([(uv[-1, -1] - uv[-1, 0]) / (uv.shape[1] - 1), (uv[-1, -1] - uv[0, -1]) / (uv.shape[0] - 1)], -1)
