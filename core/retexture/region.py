"""Where texture is regrown, and where the plain deformation stands."""

from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Bools, Bytes, Floats, Singles
from core.retexture.deformation.coordinates import SpineCurves
from core.retexture.deformation.diffusion import Diffusion, distortion
from core.retexture.windows import Window, place_in, window_around

CALM = 0.06
"""Where the deformation stretches by less than this (as a logarithm), near a curve, it stands."""
STRAINED = 0.3
"""Where it stretches by more, texture is regrown beyond the usual reach too."""
RIGID = 0.45
"""Where it stretches landmarks or structure by more, they are regrown, as texture is."""
FARTHEST = 2.0
"""But no farther from a curve than this many reaches."""
FINE_PX, AROUND_PX = 2.0, 15
"""Detail finer than the first is averaged over a window as wide as the second."""
CONTRAST, SEEN, CLEAR = 0.02, 0.012, 0.04
"""Below the first contrast, of 1, there is nothing to be seen stretched; above, a stretch is seen where contrast times
strain is more than the second. Above the last any is, and texture from elsewhere fits where its source is missing."""
JOIN = 0.3
"""Width of the band that joins both, as a share of the reach."""
GENTLE = 1.1
"""And wider by so many times the gap that it bridges: in less, one thing of the source would be shown twice or torn."""
NEAR = 0.65
"""Up to this share of the reach a place's source is found along the curve, and one reach farther by the deformation."""
MILD, WILD = 0.5, 1.0
"""Where the deformation stretches by less than the first. Where it stretches by more than the second, it shows too
little of the source too often, and begins to count one reach from the curve only."""
GAP_PX, SPECK_PX = 16, 8
"""The region has no gaps narrower than twice the first, and no parts narrower than twice the second, unless patches are
small."""
SMOOTH_PX = 6.0
"""Strain is averaged over about so far."""
BAND = 128
"""Rows worked on at a time."""
ROOM_PX = 64
"""More than gaps, specks and the rim reach beyond what is wanted."""
RIM_PX = 12
"""Width of the rim in which the seam between both may run."""
ASKED, REFUSED = 191, 64
"""Grey levels over which, or under which, the artist has painted that texture is regrown, or is not."""


@dataclass(frozen=True, eq=False)
class Wishes:
    """What the artist has painted: masks over the picture (H, W), None where that is nothing."""

    regrown: Bools | None = None
    """Texture is regrown here, whatever is found."""
    allowed: Bools | None = None
    """And nowhere but here."""

    @classmethod
    def of(cls, matte: Bytes | None, regrow: Bytes | None) -> "Wishes":
        """Return what a matte and a raster of more or less say (H, W): over 127, and by `ASKED` and `REFUSED`."""
        allowed = None if matte is None else matte > 127
        if regrow is None:
            return cls(None, allowed)
        kept = regrow >= REFUSED
        return cls(regrow > ASKED, kept if allowed is None else kept & allowed)


@dataclass(frozen=True, eq=False)
class Apart:
    """How the two ways to a place's source, the deformation and the curves' own coordinates, differ."""

    gap_px: Singles
    """(H, W) how far apart they lead."""
    torn: Bools
    """(H, W) where the coordinates of two curves meet and lead to different places, or where they lead out of the
    picture and nothing stands for what is missing."""
    creased: Bools
    """(H, W) the same where the ribs of one curve meet, inside a bend."""
    missing: Bools
    """(H, W) where the coordinates lead out of the picture, whether or not anything stands for what is missing."""


@dataclass(frozen=True, eq=False)
class Standing:
    """What the plain deformation shows, and had better go on to show: masks (H, W)."""

    landmarks: Bools
    """Things that are rarer than what lies along the curves."""
    structured: Bools
    """Sides of curves with long edges that go their own way: to break one is worse than to stretch it."""


@dataclass(frozen=True)
class Sizes:
    """Distances that bound a region."""

    reach_px: float
    """From a target curve to where texture is regrown for little strain."""
    edge_px: float
    """To where it is regrown without detail too, so that the feature's edge stays sharp."""
    search_px: float
    """From a patch's corresponding place to its farthest candidate."""


@dataclass(frozen=True, eq=False)
class Region:
    """Masks over the picture (H, W)."""

    must: Bools
    """Texture is regrown here."""
    may: Bools
    """And may be here: the rim around it."""
    inner: Singles
    """(H, W) 1 well inside, falling to 0 at the outer edge: the share of texture at its own scale, which gives way to
    the deformation's, so that both join without a seam."""
    nearness: Singles
    """(H, W) the same, falling with the distance from the curves too: how much of a place's source is found along the
    curve's own coordinates, the rest being found by the deformation."""
    free: Singles
    """(H, W) 0 at the outer edge and where curves meet, where a patch shows its corresponding place so that it joins
    what lies beyond, to 1 where any candidate will do."""


def region(
    grid: Diffusion,
    field: Floats,
    curves: SpineCurves,
    detail: Singles,
    apart: Apart,
    sizes: Sizes,
    shown: Standing,
    *,
    wishes: Wishes | None = None,
) -> Region:
    """Return where to regrow texture: near the target curves, as far as the deformation is not rigid.

    Farther off, too, where it stretches much. And wherever the deformed picture has no `detail` (H, W) that would show
    its strain, there is nothing to regrow, but close to a curve: a seam, or an edge that is bent anew, would show more.
    The deformation stands where it shows landmarks or structure without stretching them much. The artist's `wishes` go
    before all of that.
    """
    wishes = wishes or Wishes()
    reach_px, edge_px, shape = sizes.reach_px, sizes.edge_px, grid.shape
    all_strain = grid.at_pixels(_smooth(distortion(grid, field), SMOOTH_PX / grid.step)[..., None])[..., 0]
    all_allowed, all_distance = ~_kept(shown.landmarks, all_strain), _distance(curves, shape)
    reached = all_distance < max(FARTHEST * reach_px, edge_px)
    if wishes.regrown is not None:
        reached |= wishes.regrown
        all_allowed |= wishes.regrown
    if wishes.allowed is not None:
        all_allowed &= wishes.allowed
    # Nothing is regrown beyond that, so the rest is worked on in a window: most of a large picture lies outside.
    window = window_around(reached, ROOM_PX)
    must, may = np.zeros(shape, bool), np.zeros(shape, bool)
    inner, nearness, free = (np.zeros(shape, np.float32) for _ in range(3))
    if not reached.any():
        return Region(must, may, inner, nearness, free)
    strain, distance = (plane[window].copy() for plane in (all_strain, all_distance))
    allowed = all_allowed[window].copy()
    del reached, all_strain, all_distance, all_allowed
    near = (distance < reach_px) & (strain > CALM)
    far = (distance < FARTHEST * reach_px) & (strain > STRAINED)
    aside = ~_beyond_ends(curves, distance, FARTHEST * reach_px, window)
    clear = np.where(apart.missing[window], CLEAR, np.clip(SEEN / np.maximum(strain, 1e-3), CONTRAST, CLEAR))
    wanted = (near | far) & aside & (detail[window] > clear) | (distance < edge_px) & (strain > CALM)
    wanted &= ~(shown.structured[window] & (strain < RIGID))
    wanted = _clean(wanted, min(SPECK_PX, edge_px / 2))
    if wishes.regrown is not None:
        wanted |= wishes.regrown[window]
    open_to = may[window]
    open_to[:] = (_away_from(wanted) <= RIM_PX) & allowed
    must[window] = wanted & (_away_from(~allowed) > RIM_PX / 2)
    depth = cv2.distanceTransform(np.pad(open_to, 1, mode="edge").astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    torn, creased = (_away_from(mask)[window].copy() for mask in (apart.torn, apart.creased))
    planes: tuple[Singles, ...] = (
        np.asarray(depth, np.float32),
        torn,
        creased,
        apart.gap_px[window],
        distance,
        strain,
    )
    for top in range(0, len(open_to), BAND):
        rows = slice(top, top + BAND)
        # Outside of what may be regrown each of them is 0.
        if not open_to[rows].any():
            continue
        for share, part in zip(
            (inner, nearness, free), _shares(sizes, *(plane[rows] for plane in planes)), strict=True
        ):
            share[window][rows] = part
    return Region(must, may, inner, nearness, free)


def _shares(
    sizes: Sizes, depth: Singles, torn: Singles, creased: Singles, gap_px: Singles, distance: Singles, strain: Singles
) -> tuple[Singles, Singles, Singles]:
    """Return `Region.inner`, `nearness` and `free` (H, W).

    From the `depth` of a pixel in the region, its distances to what is torn and creased and to the nearest curve, px,
    how far the two ways to its source part, and the strain (H, W).
    """
    reach_px, edge_px = sizes.reach_px, sizes.edge_px
    # A region without an outer edge is infinitely deep.
    inside = np.minimum(depth, 1e4).astype(np.float32) - np.float32(RIM_PX / 2)
    inner = ramp(inside / np.float32(JOIN * reach_px))
    band = np.float32(JOIN * reach_px) + np.float32(GENTLE) * gap_px
    whole = np.minimum(inside, torn)
    free = ramp(whole / np.float32(JOIN * reach_px + GENTLE * sizes.search_px))
    # The feature itself stays on its curve, however tightly that bends.
    uncreased = np.maximum(ramp(creased / band), 1 - ramp(distance / edge_px - 1))
    nearness = ramp(whole / band) * share_along(distance / reach_px, strain, uncreased)
    return inner, nearness, free


def share_along(far: Singles, strain: Singles, uncreased: Singles) -> Singles:
    """Return the share (H, W) of a place's source that is found along the curves, by its distance in reaches.

    The curve's own coordinates keep what is beside it; farther off, and where they are `uncreased` less than 1, they
    bend and tear what the picture shows across the curve, and a deformation that stretches mildly does not.
    """
    late = 1 - ramp(far - 1)
    early = (1 - ramp(far - NEAR)) * uncreased
    return np.asarray(early + ramp((strain - MILD) / (WILD - MILD)) * (late - early), np.float32)


def _smooth(values: Floats, sigma: float) -> Floats:
    """Return Gaussian means of `values` (R, C), mirrored at their border."""
    side = 2 * int(np.ceil(4 * sigma)) + 1
    return np.asarray(cv2.GaussianBlur(values, (side, side), sigma, borderType=cv2.BORDER_REFLECT))


def _kept(landmarks: Bools, strain: Singles) -> Bools:
    """Return the `landmarks` (H, W) that the deformation does not stretch much, on average over each."""
    if not landmarks.any():
        return landmarks
    window = window_around(landmarks)
    inside = landmarks[window]
    count, part, stats, _ = cv2.connectedComponentsWithStats(inside.astype(np.uint8))
    mean = np.bincount(part.ravel(), strain[window].ravel(), count) / np.maximum(stats[:, cv2.CC_STAT_AREA], 1)
    return place_in(window, inside & (mean < RIGID)[part], landmarks.shape)


def _away_from(mask: Bools) -> Singles:
    """Return the distance of every pixel (H, W) to the nearest in `mask`, px; infinity if there is none."""
    if not mask.any():
        return np.full(mask.shape, np.inf, np.float32)
    return np.asarray(cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 5), np.float32)


def smoothstep(x: Singles) -> Singles:
    """Return 0 up to x = 0, 1 from x = 1, and 3x^2 - 2x^3 between."""
    x = np.clip(x, 0, 1)
    return x * x * (3 - 2 * x)


def ramp(x: Singles) -> Singles:
    """Return 0 up to x = 0, 1 from x = 1, and between them the mean of x and `smoothstep`, nowhere steeper than 1.25.

    What goes over from one map to another by these shares folds, or is stretched, where they change fast.
    """
    x = np.clip(x, 0, 1)
    share = np.float32(1.5) - x
    share *= x
    share += np.float32(0.5)
    share *= x
    return np.asarray(share, np.float32)


def _distance(curves: SpineCurves, shape: tuple[int, int]) -> Singles:
    """Return the distance of every pixel (H, W) to the nearest curve, to about a pixel."""
    far = np.ones(shape, np.uint8)
    for curve in curves.curves:
        line = np.rint(curve.at(curve.parameters(step=0.5))).astype(int)
        inside = ((line >= 0) & (line < [shape[1], shape[0]])).all(axis=1)
        far[line[inside, 1], line[inside, 0]] = 0
    return np.asarray(cv2.distanceTransform(far, cv2.DIST_L2, 5), np.float32)


def contrast(picture: Singles) -> Singles:
    """Return the contrast (H, W) of fine texture in colours (H, W, c): how much a blur takes away, on average around.

    The mean of the size rather than the squares: a few strong edges are no texture.
    """
    fine = np.zeros(picture.shape[:2], np.float32)
    for i in range(picture.shape[2]):
        plane = picture[..., i]
        blurred = cv2.GaussianBlur(plane, (0, 0), FINE_PX)
        lost = np.abs(np.subtract(plane, blurred, out=blurred), out=blurred)
        np.maximum(fine, cv2.blur(lost, (AROUND_PX, AROUND_PX)), out=fine)
    return np.asarray(cv2.dilate(fine, _disc(AROUND_PX // 2)), np.float32)


def _beyond_ends(curves: SpineCurves, distance: Singles, reach_px: float, window: Window) -> Bools:
    """Return which pixels (h, w) of a window have an open curve's end for their nearest point, and lie before it.

    Their `distance`s (h, w) to the nearest curve tell.
    """
    beyond = np.zeros(distance.shape, bool)
    first = np.array([window[1].start, window[0].start])
    for curve in curves.curves:
        if curve.closed:
            continue
        for t, sense in ((0.0, -1.0), (float(curve.segments), 1.0)):
            end, outward = curve.at(t), sense * curve.tangent(t)
            low, high = (
                np.clip(side - first, 0, distance.shape[::-1]).astype(int)
                for side in (np.floor(end - reach_px), np.ceil(end + reach_px))
            )
            box = slice(low[1], high[1]), slice(low[0], high[0])
            y, x = np.ogrid[box]
            y, x = y + first[1], x + first[0]
            nearest = np.hypot(x - end[0], y - end[1]) < distance[box] + 1.5
            beyond[box] |= nearest & ((x - end[0]) * outward[0] + (y - end[1]) * outward[1] > 1)
    return beyond


def _clean(mask: Bools, speck_px: float) -> Bools:
    """Close gaps, and drop specks narrower than twice `speck_px`."""
    closed = _away_from(_away_from(mask) > GAP_PX) > GAP_PX
    return _away_from(_away_from(~closed) > speck_px) <= speck_px


def _disc(radius: int) -> Bytes:
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1)), np.uint8)
