"""What is known before a patch is grown: coordinates around both sides of the curves, and where to regrow."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import cv2
import numpy as np

from core.arrays import Bools, Floats, Ints, Points, Singles
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve
from core.curves.fitting import fit
from core.linalg.nearest import Nearest
from core.retexture.deformation import diffusion
from core.retexture.deformation.coordinates import DirectionField, SpineCurves
from core.retexture.deformation.diffusion import Diffusion
from core.retexture.region import Apart, Region, Sizes, Standing, Wishes, contrast, region
from core.retexture.result import Retexture
from core.retexture.saliency import find_landmarks
from core.retexture.sampling import Kernel, read
from core.retexture.source_outside_frame import far_outside
from core.retexture.synthesis.candidate_pool import within
from core.retexture.synthesis.long_edges import LongEdges, Side
from core.retexture.synthesis.patches import Fields, PatchShape
from core.retexture.synthesis.placement import Correspondence, along_curves, find_missed, pace
from core.retexture.windows import place_in, window_around

TORN = 3.0
"""Where curves meet, or ribs of one, coordinates are torn if places in the source part so many times as far as here."""
SAMPLES = 0.4
"""Distance of the samples that landmarks are found by, in half widths of a patch."""
KEPT_PX = 2.0
"""Patches stop this short of another curve (DPD sec. 3.2)."""


@dataclass(frozen=True, eq=False)
class RetextureScene:
    """Coordinates, and the region to regrow."""

    way: Correspondence
    area: Region
    fields: Fields
    kept: tuple[Ints, Ints] | None
    drawn: int
    """See `candidate_pool.Bounds`."""


def prepare(
    pieces: list[FeatureCurve],
    plain: Retexture,
    picture: Singles,
    patch: PatchShape,
    reach_px: float,
    wishes: Wishes | None,
    edges: LongEdges | None = None,
) -> RetextureScene:
    """Return the scene of drawn curves in `pieces`, with texture regrown as far as `reach_px` from their targets.

    Long `edges` of the picture follow the deformation, as passive curves do.
    """
    edges = edges or LongEdges()
    drawn, pieces = len(pieces), [*pieces, *map(FeatureCurve, edges.curves)]
    targets = [piece.target or follow(piece.source, plain) for piece in pieces]
    source, target = SpineCurves([piece.source for piece in pieces]), SpineCurves(targets)
    with ThreadPoolExecutor(1) as helper:
        stands = helper.submit(find_standing, picture, source, plain, patch, reach_px)
        fine = contrast(picture)
        beside, paces, nearest, lost, missing = along_nodes(source, target, plain.grid, patch.rib)
        structured = in_sides(SpineCurves(targets[:drawn]), edges.structured, plain.grid)
        # What a place shows comes from where the deformation has it, or from where it lies along the curve.
        along = spread(read(fine, beside), plain.grid)
        fine = read(fine, plain.place)
        np.maximum(fine, plain.grid.at_pixels(along)[..., 0], out=fine)
        between = apart(beside, nearest, lost, missing, plain)
    sizes = Sizes(reach_px, 1.5 * patch.rib, patch.search_along)
    area = region(
        plain.grid,
        plain.field,
        SpineCurves(targets[:drawn]),
        fine,
        between,
        sizes,
        Standing(stands.result(), structured),
        wishes=wishes,
    )
    # It is read where patches begin: beside what is regrown.
    window = window_around(area.may, patch.window)
    fine = place_in(window, fine[window], fine.shape)
    # Each share of a place's source compresses as its own map does.
    near = read(area.nearness, plain.grid.nodes, Kernel.NEAREST)
    pressed = near * spread(paces, plain.grid)[..., 0] + (1 - near) * diffusion.compression(plain.grid, plain.field)
    reached = np.ones((2 * patch.rib + 1, 2 * patch.rib + 1), np.uint8)
    way = Correspondence(
        source,
        target,
        plain.grid,
        plain.field,
        np.clip(pressed, 1, 3),
        area.inner,
        area.nearness,
        fine,
        area.free,
        cv2.dilate(plain.grid.at_pixels(spread(missing, plain.grid)), reached) > 0.5,
        patch.rib,
    )
    shape = plain.grid.shape
    kept = (near_curves(source, shape), near_curves(target, shape)) if len(pieces) > 1 else None
    return RetextureScene(way, area, direction_fields(way, area, patch, reach_px), kept, drawn)


def direction_fields(way: Correspondence, area: Region, patch: PatchShape, reach_px: float) -> Fields:
    """Return the directions around the targets and the sources, as far as patches reach."""
    margin = patch.spine + patch.search_along + 4
    y, x = (np.flatnonzero(area.may.any(axis=axis)) for axis in (1, 0))
    bounds = (x[0], y[0], x[-1], y[-1]) if len(x) else (0, 0, 1, 1)
    low, high = way.source.points.min(axis=0), way.source.points.max(axis=0)
    far = 1.2 * reach_px + margin
    height, width = way.grid.shape  # texture is taken from the picture, wherever else a curve runs
    low, high = np.clip(low, 0, (width, height)), np.clip(high, 0, (width, height))
    return (
        DirectionField(way.target, (bounds[0] - margin, bounds[1] - margin, bounds[2] + margin, bounds[3] + margin)),
        DirectionField(way.source, (*(low - far), *(high + far))),
    )


def along_nodes(
    source: SpineCurves, target: SpineCurves, grid: Diffusion, rib: int
) -> tuple[Points, Floats, Ints, Bools, Bools]:
    """Return what corresponds along the curves to every second node of the grid.

    That is its place (r, c, 2), the pace (r, c), the nearest curve (r, c), and whether the place lies outside the
    picture: (r, c) where nothing stands for it, and (r, c) where another part of the curve does.
    """
    some = grid.nodes[::2, ::2]
    nodes, size = some.reshape(-1, 2), some.shape[:2]
    feet, place, _ = along_curves(source, target, nodes)
    lost = ~within(place, grid.shape)
    far = far_outside(place.reshape(some.shape), grid.shape, rib).ravel()
    far[far] = find_missed(source, target, feet.taken(far), nodes[far], grid.shape, rib)[0]
    paces = pace(source, target, feet).reshape(size)
    return place.reshape(some.shape), paces, feet.curve.reshape(size), (lost & ~far).reshape(size), far.reshape(size)


def in_sides(targets: SpineCurves, sides: frozenset[Side], grid: Diffusion) -> Bools:
    """Return which pixels (H, W) lie on one of some sides of the target they are nearest to."""
    if not sides:
        return np.zeros(grid.shape, bool)
    some = grid.nodes[::2, ::2]
    feet = targets.feet(some.reshape(-1, 2))
    inside = np.zeros(len(feet.curve), bool)
    for number, positive in sides:
        inside |= (feet.curve == number) & ((feet.offset > 0) == positive)
    return np.asarray(grid.at_pixels(spread(inside.reshape(some.shape[:2]), grid))[..., 0] > 0.5)


def apart(along: Points, nearest: Ints, lost: Bools, missing: Bools, plain: Retexture) -> Apart:
    """Return how the places `along` the `nearest` curves (r, c, 2), of every second node, are off the deformation's.

    None of them is where they are `lost` (r, c); where they are `missing` (r, c), others stand for them.
    """
    gap = np.linalg.norm(along - (plain.grid.nodes + plain.field)[::2, ::2], axis=-1)
    torn = lost.astype(np.float64)
    creased = np.zeros(torn.shape)
    for axis in (0, 1):
        far = np.linalg.norm(np.diff(along, axis=axis), axis=-1) > TORN * 2 * plain.grid.step
        meets = np.diff(nearest, axis=axis) != 0
        torn += np.pad(far & meets, [(int(axis == i), 0) for i in (0, 1)])
        creased += np.pad(far & ~meets, [(int(axis == i), 0) for i in (0, 1)])
    gap_px, grid = plain.grid.at_pixels(spread(gap, plain.grid))[..., 0], plain.grid
    parts = [grid.at_pixels(spread(values, grid))[..., 0] > 0.5 for values in (torn, creased, lost | missing)]
    return Apart(gap_px, *parts)


def find_standing(picture: Singles, source: SpineCurves, plain: Retexture, patch: PatchShape, reach_px: float) -> Bools:
    """Return where the plain deformation shows landmarks (H, W)."""
    places = (plain.grid.nodes + plain.field)[::2, ::2]
    found = find_landmarks(picture, source, places.reshape(-1, 2), reach_px=reach_px, sample_px=SAMPLES * patch.rib)
    marked = found.astype(np.float32).reshape(places.shape[:2])
    return np.asarray(plain.grid.at_pixels(spread(marked, plain.grid))[..., 0] > 0.5)


def spread(values: Floats | Singles | Bools, grid: Diffusion) -> Floats:
    """Return at all nodes of the grid (R, C, 1) the `values` (r, c) of every second one."""
    return np.asarray(values.repeat(2, axis=0).repeat(2, axis=1)[: grid.rows, : grid.columns, None], np.float64)


def follow(source: Curve, plain: Retexture) -> Curve:
    """Return where the plain deformation takes a passive curve: the places q with q + D(q) on it."""
    nodes = plain.grid.nodes.reshape(-1, 2)
    origin = nodes + plain.field.reshape(-1, 2)
    line = source.at(source.parameters(step=2.0))
    _, near = Nearest(origin).to(line)
    place = nodes[near]
    for _ in range(8):
        place = place + 0.5 * (line - place - plain.grid.at(plain.field, place))
    return fit(place, tolerance=1.0, closed=source.closed)


def near_curves(curves: SpineCurves, shape: tuple[int, int]) -> Ints:
    """Return which curve runs within `KEPT_PX` of each pixel (H, W), numbered from 1; 0 where none does."""
    kept: Ints = np.zeros(shape, np.int16)
    # The round ends of steps this short widen a line by a pixel on either side.
    wide = int(2 * KEPT_PX) - 1
    for i in range(len(curves.curves)):
        line = curves.points[curves.index == i]
        cv2.polylines(kept, [np.rint(line).astype(np.int32)], curves.curves[i].closed, i + 1, wide)
    return kept
