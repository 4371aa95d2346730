"""Texels so large that the cloth shows few of them: a tartan's sett, where its stripes alone seem to repeat.

A handful of vertices make no lattice that could be told from chance. The registration can: a mesh that begins at one or
two texels, and that can be followed over several times their area, has found the pattern again.
"""

from collections.abc import Iterator
from operator import itemgetter

import cv2
import numpy as np

from core.arrays import Bools, Floats, Points, Singles
from core.overlay.detection.alignment import FlatPicture
from core.overlay.detection.basis import reduce
from core.overlay.detection.correlation import Proposal, correlation_surface, find_peaks, seeds
from core.overlay.detection.seeding import LEAST_VERTICES as ENOUGH
from core.overlay.detection.seeding import NoPatternError, full_grown, of_size, try_out
from core.overlay.filters.smoothing import gaussian
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.evidence import weigh
from core.overlay.registration.fitting import LEAST_EVENNESS, begun, refit
from core.overlay.registration.region_growing import followed, prune
from core.overlay.texel import Texel
from core.progress import Job, Progress, part

NOTE = "looking for large texels"
SIDES_PX = (60, 84, 108)
"""Sides of the exemplar patches."""
SIZES = (0.6, 1.5)
"""Side of a texel over that of its exemplar: a smaller patch knows a part of the texel only."""
LEAST_PX, LONGEST = 40.0, 2.0
"""Least side of a large texel, and its longer side over the shorter."""
LEAST_SINE = 0.5
"""Of the angle between its sides."""
BLUR_PX = 2.0
"""Blur of a patch whose slopes are measured: noise has none in particular."""
MOST_PEAKS = 24
LEAST_VERTICES = 2
INSIDE = 0.7
"""Share of a patch that has to be inside the region."""
LEAST_NEIGHBOURS = 3
"""Neighbours of a texel that can be compared with it."""
LEAST_SUPPORT = 0.4
APART = 0.12
"""Change of the sides, over their length, from which two proposals differ."""
PLACES, EACH = 16, 2
"""Places at which an exemplar is taken, and proposals from each."""
TRIALS, FITS = 32, 16
"""Proposals that are tried, and how many of them are registered."""
LEAST_TEXELS, LEAST_GROWTH = 5.0, 2.5
"""Area that has to be followed, in texels and, where it began with few vertices, over the area that they had."""
GOOD = 0.25
"""Share of what may be cloth over which the pattern is followed, with which no other texel is tried."""
REPEATED, LEAST_PART = 0.85, 0.2
"""Correlation of a texel with itself from which it repeats within, and the least part of a side that it is moved by."""
AGAINST = 3
"""Large texels that repeat within after which no more are tried."""
NEIGHBOURS = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j], float)


def find_wide(
    photo: Floats, canvas: FlatPicture, rng: np.random.Generator, *, texel_px: float | None = None
) -> Job[tuple[FittedCloth, Fit]]:
    """Return the cloth followed from where the large texel lies that explains most of the photo (H, W, 3).

    Raises `NoPatternError` if there is none. A texel that repeats within is none: a finer lattice's are, or stripes.
    """
    valid = np.asarray(canvas.valid[..., 0] > 0, np.bool_)
    best: tuple[float, tuple[FittedCloth, Fit] | None] = (0.0, None)
    yield Progress(0.0, NOTE)
    proposals = of_size(distinct(propose_wide(canvas.image, valid, rng)), texel_px)
    fits = several = 0
    for number, proposal in enumerate(proposals[:TRIALS]):
        if fits == FITS or several == AGAINST or is_good(best[1], valid):
            break
        step = Progress(0.1 + 0.9 * number / TRIALS, NOTE)
        yield step
        lattice = try_out(canvas, proposal)
        if len(lattice) >= LEAST_VERTICES:
            lattice = yield from full_grown(canvas, lattice, step)
        if len(lattice) < LEAST_VERTICES:
            continue
        fits += 1
        try:
            cloth, begin = yield from part(begun(photo, canvas, lattice, 0), step.fraction, step.fraction)
        except NoPatternError:
            continue
        found = yield from goes_on(cloth, begin, step)
        if found is None:
            continue
        if repeats_within(found.texel):
            several += 1
        elif (weight := weigh(cloth, found)).is_credible:
            best = max(best, (weight.explained, (cloth, found)), key=itemgetter(0))
    if best[1] is None:
        raise NoPatternError
    return best[1]


def is_good(best: tuple[FittedCloth, Fit] | None, valid: Bools) -> bool:
    """Return whether a pattern is followed over so much of what may be cloth (H, W) that it surely is the cloth's."""
    return best is not None and best[1].cells.sum() * best[0].mesh.cell ** 2 > GOOD * valid.sum()


def propose_wide(image: Singles, valid: Bools, rng: np.random.Generator) -> list[Proposal]:
    """Return proposals of large texels in a flattened `image` (H, W, 3), best first."""
    found: list[Proposal] = []
    for side in SIDES_PX:
        if 1.5 * side < min(image.shape[:2]):
            for point in seeds(valid, side, rng, PLACES):
                found += wide_at(image, valid, point, side)
    return sorted(found, key=lambda proposal: -proposal.support)


def distinct(proposals: list[Proposal]) -> list[Proposal]:
    """Return the proposals, best first, without those much like a better one at the same place: few of each."""
    kept: list[Proposal] = []
    for proposal in proposals:
        limit = APART * float(np.linalg.norm(proposal.basis))
        here = [other for other in kept if np.array_equal(other.point, proposal.point)]
        alike = any(np.linalg.norm(other.basis - proposal.basis) < limit for other in here)
        if len(here) < EACH and not alike:
            kept.append(proposal)
    return kept


def wide_at(image: Singles, valid: Bools, point: Points, side: int) -> list[Proposal]:
    """Return the pairs of peaks of the correlation with the patch around `point` that suit a large texel."""
    surface, middle = correlation_surface(image, point, side)
    if surface is None or evenness(image, point, side) < LEAST_EVENNESS:
        return []
    peaks, heights = find_peaks(surface, middle, side)
    pairs = find_suited(peaks[np.argsort(-heights)[:MOST_PEAKS]], side)
    known = np.where(share_inside(valid, point, side) > INSIDE, surface, np.nan)
    return [
        Proposal(point, reduce(basis), support)
        for basis, support in zip(pairs, supports(known, middle, pairs), strict=True)
        if support > LEAST_SUPPORT
    ]


def evenness(image: Singles, point: Points, side: int) -> float:
    """Return how much a patch changes in the direction of least change over that of most: stripes have no texel."""
    half, (x, y) = side // 2, (int(v) for v in point)
    patch = gaussian(image[y - half : y + half + 1, x - half : x + half + 1], BLUR_PX)
    down, across = (slope.ravel() for slope in np.gradient(patch, axis=(0, 1)))
    slopes = np.stack([across, down])
    low, high = np.linalg.eigvalsh(slopes @ slopes.T)
    return float(np.sqrt(max(low, 0.0) / max(high, 1e-12)))


def find_suited(peaks: Points, side: int) -> Floats:
    """Return the pairs (k, 2, 2) of peaks (n, 2), as columns, that span a texel for an exemplar of that side."""
    first, second = np.triu_indices(len(peaks), 1)
    pairs = np.stack([peaks[first], peaks[second]], -1).reshape(-1, 2, 2)
    lengths = np.linalg.norm(pairs, axis=1)
    area = np.abs(np.linalg.det(pairs))
    size = np.sqrt(area)
    good = (area > LEAST_SINE * lengths.prod(1)) & (lengths.max(1) < LONGEST * lengths.min(1))
    return np.asarray(pairs[good & (size > max(LEAST_PX, SIZES[0] * side)) & (size < SIZES[1] * side)], np.float64)


def share_inside(valid: Bools, point: Points, side: int) -> Singles:
    """Return the share of each patch inside the region (h, w), for the surface that the patch at `point` has."""
    half, reach = side // 2, round(2.2 * side)
    x, y = (int(v) for v in point)
    around = valid[max(y - reach, 0) : y + reach + 1, max(x - reach, 0) : x + reach + 1].astype(np.float32)
    share = cv2.blur(around, (2 * half + 1, 2 * half + 1), borderType=cv2.BORDER_CONSTANT)
    return np.asarray(share[half : len(share) - half, half : share.shape[1] - half], np.float32)


def supports(surface: Singles, middle: Points, pairs: Floats) -> Iterator[float]:
    """Yield the mean of the surface's highest values near the eight neighbours that each pair predicts.

    A neighbour where it is NaN does not count; 0 where there are too few.
    """
    known = np.nan_to_num(surface, nan=-1.0)
    for basis in pairs:
        radius = max(2, round(0.12 * float(np.linalg.norm(basis, axis=0).min())))
        values = []
        for x, y in np.rint(middle + NEIGHBOURS @ basis.T).astype(int):
            if 0 <= y < len(surface) and 0 <= x < surface.shape[1] and np.isfinite(surface[y, x]):
                spot = slice(max(y - radius, 0), y + radius + 1), slice(max(x - radius, 0), x + radius + 1)
                values.append(float(known[spot].max()))
        yield float(np.mean(values)) if len(values) >= LEAST_NEIGHBOURS else 0.0


def repeats_within(texel: Texel) -> bool:
    """Return whether a texel is several texels of a finer lattice."""
    spectrum = np.fft.fft2(texel.pixels - texel.pixels.mean((0, 1)), axes=(0, 1))
    likeness = np.fft.ifft2((np.abs(spectrum) ** 2).sum(-1)).real
    v, u = (np.abs(np.fft.fftfreq(n)) for n in likeness.shape)
    moved = np.maximum(v[:, None], u) >= LEAST_PART
    return bool(likeness[moved].max() > REPEATED * likeness[0, 0])


def goes_on(cloth: FittedCloth, begun: Fit, step: Progress) -> Job[Fit | None]:
    """Return the pattern followed from where it begins, None if it hardly goes on."""
    found = yield from followed(cloth, prune(cloth, begun), step)
    area = cloth.steps_of(found.cells)
    further = area > LEAST_GROWTH * cloth.steps_of(begun.cells) or len(cloth.lattice) >= ENOUGH
    # A texel may look like itself only: it is that of all its copies that has to explain them.
    return refit(cloth, found, rounds=3) if area >= LEAST_TEXELS and further else None
