"""The search for a lattice: seeds from several detectors grow, and the best result wins."""

import numpy as np

from core.arrays import Bools, Floats, InputError, Points
from core.overlay.detection.alignment import FlatPicture, PatchFrames, Template, align, correlate
from core.overlay.detection.basis import is_about
from core.overlay.detection.correlation import Proposal, propose, snap
from core.overlay.detection.keypoints import alike_keypoints, propose_from_keypoints
from core.overlay.detection.lattice import (
    LEAST_VERTICES,
    Lattice,
    grow,
    mean_template,
    nearest_vertices,
    neighbour_rows,
    refine,
    seed,
    step_errors,
)
from core.overlay.detection.stages import Stage
from core.overlay.filters.smoothing import LIGHT_PX, flatten
from core.progress import Job, Progress

LEAST_MARKED = 2
"""Vertices of a lattice at least where the user marked a texel."""
GROWING = "growing the lattice"
PLACES, ALIGNED = 700, 120
"""Places at which a further piece is looked for, and how many of the best are aligned."""
SAMPLES = 10
"""Samples along a side of a texel with which places are compared before they are aligned."""
LEAST_LIKENESS = 0.6
"""Least correlation of the first texel of a further piece."""
TRIALS, FINALISTS = 60, 4
TRIAL_VERTICES = 25
SIZE_CLASS, TURN = 0.35, 3
"""Logarithm of the sides that count as one size, and proposals of a size that are tried before other sizes' next."""
ENOUGH = 4
"""Seeds that agree before no more are tried."""
OFF, SAME_PART = 0.3, 0.6
"""Most by which a vector of a part differs from whole ones of a lattice, and least share of its vertices, less what
differs in their phase, that are the lattice's."""
FAR = 4 * TRIAL_VERTICES
"""Vertices of a lattice whose parts are not grown too; those of one that ended sooner may go farther."""
WORSE = 0.3
"""Promise, over the best one's, below which a seed is dropped."""
NEARLY, UNEVEN, MORE = 0.75, 2.0, 1.05
"""Merit, over the best one's, with which a finer lattice is preferred of which the best one's texels are several; how
much less evenly it may lie if its texels are more alike, and by how much they have to be."""
SAME_PHASE, COVERED = 0.35, 0.8
"""Mean of the phases in which a lattice's vertices lie in a finer one's texels: 1 where all are the same, and of n by
chance about 1 / sqrt(n); and share of them that the finer one reaches."""


class NoPatternError(InputError):
    """Nothing repeats in the picture, or not in both directions."""

    def __init__(self, where: str = "the picture") -> None:
        super().__init__(f"no repeating texture found in {where}")


def flat_canvas(photo: Floats, valid: Bools) -> FlatPicture:
    """Return the photo (H, W, 3) freed of slow changes of light, to be looked at inside `valid`."""
    return FlatPicture(flatten(photo.astype(np.float32), valid, LIGHT_PX), valid.astype(np.float32)[..., None])


def find_lattices(
    canvas: FlatPicture,
    rng: "np.random.Generator",
    *,
    texel_px: float | None = None,
    start: Proposal | None = None,
    most_px: float = np.inf,
) -> Job[list[Lattice]]:
    """Return the lattices that grow from several seeds and detectors, the most likely one first.

    `texel_px` is the side of a texel where the user knows it, `most_px` what it is less than; a `start` is the only
    seed if it is given, its vectors those that it has or others of about its size, whichever fit. Raises
    `NoPatternError` if there is no lattice.
    """
    if start is not None:
        marked = [try_out(canvas, proposal) for proposal in (start, *snap(canvas.image, start))]
        best = max(marked, key=promise)
        return rank([(yield from full_grown(canvas, best, Progress(0.3, GROWING)))], LEAST_MARKED)
    valid = canvas.valid[..., 0] > 0
    yield Progress(0.0, "correlating patches")
    proposals = propose(canvas.image, valid, rng)
    yield Progress(0.1, "clustering keypoints")
    groups = alike_keypoints(canvas.image, valid, rng)
    yield Progress(0.2, "clustering keypoints", Stage("keypoints", groups=tuple(groups), shape=canvas.shape))
    proposals = of_size(proposals + propose_from_keypoints(groups), texel_px)
    small = [proposal for proposal in proposals if abs(np.linalg.det(proposal.basis)) < most_px**2]
    return (yield from grow_proposals(canvas, small))


def grow_proposals(canvas: FlatPicture, proposals: list[Proposal]) -> Job[list[Lattice]]:
    """Return the lattices that grow from proposals, best first, until some agree; the most likely lattice first.

    Raises `NoPatternError` if there is none.
    """
    proposals = in_turn(proposals)[:TRIALS]
    seeds = tuple((proposal.point, proposal.basis) for proposal in proposals)
    lattices: list[Lattice] = []
    repeated: list[Lattice] = []
    for number, proposal in enumerate(proposals):
        yield Progress(0.2 + 0.3 * number / TRIALS, "trying seeds", Stage("seeds", seeds=seeds, shape=canvas.shape))
        holder = next((lattice for lattice in lattices if holds(lattice, proposal)), None)
        if holder is None:
            lattices.append(try_out(canvas, proposal))
        else:
            repeated.append(holder)
        if agree(lattices + repeated):
            break
    grown: list[Lattice] = []
    for lattice in finalists(lattices):
        if len(grown) == FINALISTS:
            break
        if not is_grown(lattice, grown):
            grown.append((yield from full_grown(canvas, lattice, Progress(0.5 + 0.12 * len(grown), GROWING))))
    return rank([lattice for lattice in grown if not lattice.is_row], LEAST_VERTICES)


def rank(lattices: list[Lattice], least: int) -> list[Lattice]:
    """Return the lattices of the `least` vertices or more, the most likely one first, the others by their merit.

    Raises `NoPatternError` if there are none.
    """
    large = sorted((lattice for lattice in lattices if len(lattice) >= least), key=merit, reverse=True)
    if not large:
        raise NoPatternError
    best = large[0]
    finer = [
        other
        for other in large
        if merit(other) > NEARLY * merit(best) and lies_well(other, best) and divides(other, best)
    ]
    first = min(finer, key=lambda other: other.texel_area, default=best)
    return [first, *(lattice for lattice in large if lattice is not first)]


def lies_well(fine: Lattice, coarse: Lattice) -> bool:
    """Return whether a lattice lies as evenly as a coarser one, or not much less and its texels are more alike."""
    uneven = bend_px(fine) / max(bend_px(coarse), 1e-9)
    return uneven <= 1 or (uneven < UNEVEN and score_likeness(fine) > MORE * score_likeness(coarse))


def divides(fine: Lattice, coarse: Lattice) -> bool:
    """Return whether a lattice has smaller texels than another that it covers, at whose vertices they look the same."""
    if len(fine) < LEAST_VERTICES or fine.texel_area * 1.5 > coarse.texel_area:
        return False
    nearest, away = nearest_vertices(coarse.frames.points, fine)
    rest = np.linalg.solve(fine.frames.bases[nearest], away[..., None])[..., 0]
    rest = rest[np.abs(rest).max(1) < 1]
    least = max(SAME_PHASE, 2 / np.sqrt(max(len(rest), 1)))
    return (
        len(rest) >= max(LEAST_VERTICES, COVERED * len(coarse))
        and float(np.abs(np.exp(2j * np.pi * rest).mean(0)).min()) > least
    )


def holds(lattice: Lattice, proposal: Proposal) -> bool:
    """Return whether a small lattice has grown to where a proposal lies, by vectors that span the same texels."""
    start = PatchFrames(proposal.point[None], proposal.basis[None], np.ones(1))
    return len(lattice) >= TRIAL_VERTICES and part_of(Lattice(np.zeros((1, 2), np.int64), start), lattice)


def is_grown(small: Lattice, grown: list[Lattice]) -> bool:
    """Return whether a small lattice is part of one that has grown far."""
    return any(len(other) >= FAR and part_of(small, other) for other in grown)


def part_of(small: Lattice, grown: Lattice) -> bool:
    """Return whether a small lattice is a part of a grown one: its vectors span the same texels, at one phase."""
    nearest, away = nearest_vertices(small.frames.points, grown)
    there = grown.frames.bases[nearest]
    rest = np.linalg.solve(there, away[..., None])[..., 0]
    change = np.linalg.solve(there, small.frames.bases)
    whole = np.rint(change)
    same = (np.abs(change - whole).max((1, 2)) < OFF) & (np.abs(np.abs(np.linalg.det(whole)) - 1) < 0.5)
    same &= np.abs(rest).max(1) < 1
    return float(np.abs(np.exp(2j * np.pi * rest[same]).sum(0)).min()) > SAME_PART * len(small)


def of_size(proposals: list[Proposal], texel_px: float | None) -> list[Proposal]:
    """Return the proposals, best first, of about the wanted size if one is given."""
    alike = [proposal for proposal in proposals if is_about(proposal.basis, texel_px)]
    return sorted(alike, key=lambda proposal: -proposal.support)


def in_turn(proposals: list[Proposal]) -> list[Proposal]:
    """Return the proposals, best first, in an order in which each size has its turn."""
    seen: dict[int, int] = {}
    turns: list[int] = []
    for proposal in proposals:
        size = round(float(np.log(abs(np.linalg.det(proposal.basis)))) / 2 / SIZE_CLASS)
        turns.append(seen.get(size, 0) // TURN)
        seen[size] = seen.get(size, 0) + 1
    return [proposals[row] for row in np.argsort(turns, kind="stable").tolist()]


def try_out(canvas: FlatPicture, proposal: Proposal) -> Lattice:
    """Return the small lattice that grows around a proposal."""
    lattice, template = seed(canvas, proposal.point, proposal.basis)
    for grown in grow(canvas, lattice, template, most=TRIAL_VERTICES):
        lattice = grown
    return refine(canvas, lattice, rounds=4)[0] if len(lattice) > 4 else lattice


def agree(lattices: list[Lattice]) -> bool:
    """Return whether enough seeds have grown well, and into texels of one size."""
    good = [
        lattice.texel_area for lattice in lattices if len(lattice) >= TRIAL_VERTICES and score_likeness(lattice) > 0.42
    ]
    return len(good) >= ENOUGH and max(good) < 1.5 * min(good)


def finalists(lattices: list[Lattice]) -> list[Lattice]:
    """Return the promising small lattices, the best of each size of texels before others of that size.

    A lattice that ends soon from where the pattern is seen foreshortened may go far from another place.
    """
    best = max(map(promise, lattices), default=0.0)
    first: list[Lattice] = []
    others: list[Lattice] = []
    for lattice in sorted(lattices, key=promise, reverse=True):
        if promise(lattice) <= WORSE * best:
            break
        sizes = [abs(np.log(lattice.texel_area / other.texel_area)) for other in first]
        (first if min(sizes, default=1.0) > 0.4 else others).append(lattice)
    return first + others


def full_grown(canvas: FlatPicture, lattice: Lattice, step: Progress, *, rounds: int = 2) -> Job[Lattice]:
    """Return the lattice grown to its end, its template and outliers looked at anew in between."""
    for _ in range(rounds):
        for grown in grow(canvas, lattice, mean_template(canvas, lattice.frames)):
            lattice = grown
            yield Progress(step.fraction, step.note, Stage("lattice", lattice, shape=canvas.shape))
        lattice, _ = refine(canvas, lattice)
    return lattice


def score_likeness(lattice: Lattice) -> float:
    """Return how much better than chance the vertices match, 0 to 0.5."""
    return float(np.clip(lattice.frames.scores.mean() - 0.5, 0, None)) if len(lattice) else 0.0


def promise(lattice: Lattice) -> float:
    """Return what a small lattice is worth: all of them may have grown alike, so area counts little."""
    return score_likeness(lattice) ** 2 * min(len(lattice), TRIAL_VERTICES) if len(lattice) > 3 else 0.0


def merit(lattice: Lattice) -> float:
    """Return what a grown lattice is worth: the area it covers, by how alike its texels are."""
    return evidence(lattice) * lattice.texel_area


def evidence(lattice: Lattice) -> float:
    """Return how much speaks for a grown lattice, wherever it lies and however large its texels are."""
    return score_likeness(lattice) ** 2 * len(lattice)


def bend_px(lattice: Lattice) -> float:
    """Return the usual distance of a vertex from where a neighbour's vectors and its own lead (NRT sec. 3.1)."""
    near = neighbour_rows(lattice.keys)
    wrong = step_errors(lattice.frames.points, lattice.frames.bases, lattice.frames, near)[near >= 0]
    return float(np.median(wrong)) * float(np.sqrt(lattice.texel_area)) if len(wrong) else 0.0


def scatter(valid: Bools, rng: "np.random.Generator", count: int) -> Points:
    """Return up to `count` random places (n, 2) in `valid`."""
    y, x = np.nonzero(valid)
    chosen = rng.permutation(len(x))[:count]
    return np.stack([x[chosen], y[chosen]], -1).astype(np.float64)


def find_texels(canvas: FlatPicture, known: Lattice, rng: "np.random.Generator") -> PatchFrames:
    """Return places, best first, that look like the vertices of a known lattice, turned in any direction.

    `canvas` is valid where to look.
    """
    template = mean_template(canvas.everywhere(), known.frames, reach=0.5)
    points = scatter(canvas.valid[..., 0] > 0, rng, PLACES)
    angles = np.arange(0, 2 * np.pi, np.pi / 9)
    turns = np.array([[[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]] for a in angles])
    where = np.repeat(points, len(turns), 0)
    scores = correlate(canvas, template.resized(SAMPLES), where, np.tile(turns @ known.basis, (len(points), 1, 1)))
    # The best direction at every place, then the best places.
    # A texel that looks alike when turned is taken as turned least.
    habit = 0.05 * np.abs((angles + np.pi) % (2 * np.pi) - np.pi) / np.pi
    turn = (scores.reshape(len(points), -1) - habit).argmax(1)
    scores = scores.reshape(len(points), -1).max(1)
    best = np.argsort(-scores)[:ALIGNED]
    found = align(canvas, template, PatchFrames(points[best], turns[turn[best]] @ known.basis, scores[best]))
    sizes = np.abs(np.linalg.det(found.bases)) / known.texel_area
    good = (found.scores > LEAST_LIKENESS) & (sizes > 0.3) & (sizes < 3)
    return space_out(found[good], 0.7 * float(np.sqrt(known.texel_area)))


def space_out(frames: PatchFrames, least_px: float) -> PatchFrames:
    """Return the frames, best first, without those closer than `least_px` to a better one."""
    kept: list[int] = []
    for row in np.argsort(-frames.scores).tolist():
        if not kept or np.linalg.norm(frames.points[kept] - frames.points[row], axis=1).min() > least_px:
            kept.append(row)
    return frames[np.array(kept, np.int64)]


def grown_piece(canvas: FlatPicture, template: Template, frame: PatchFrames) -> Lattice:
    """Return the lattice that grows from one frame with the appearance of a known one."""
    lattice = Lattice(np.zeros((1, 2), np.int64), frame)
    for grown in grow(canvas, lattice, template):
        lattice = grown
    return lattice
