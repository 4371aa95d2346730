"""Retexturing as a job: deformation, coordinates, a coarse result at once, patches, and the result."""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from scipy.spatial import cKDTree

from core import color
from core.arrays import Bytes, InputError, Ints, Pixels, Singles
from core.curve_fitting import fit
from core.curves import Curve
from core.feature_curves import FeatureCurve, disjoint
from core.progress import Job, Progress, part
from core.retexture import diffusion
from core.retexture.canvas import Canvas
from core.retexture.coordinates import CurveSet, DirectionField
from core.retexture.layout import Correspondence, along_curves, ordered_origins
from core.retexture.patches import Fields, Patches, PatchShape, coarse
from core.retexture.region import Region, contrast, region
from core.retexture.result import Retexture, plain_place
from core.retexture.sampling import Kernel, read
from core.retexture.stopwatch import Stopwatch
from core.retexture.synthesis import Painter, lattice, synthesised

REACH, REACH_PER_MOVE = 0.12, 1.25
"""Texture is regrown this far from a target curve: a share of the picture's longer side, less if nothing moves far."""
LEAST_REACH_PX = 40.0
KEPT_PX = 2.0
"""Patches stop this short of another curve (DPD sec. 3.2)."""
SHORTEST_PX = 4.0
COARSE_STRIDE = 0.9


@dataclass(frozen=True)
class Settings:
    """What the artist may choose."""

    patch: PatchShape | None = None
    """Sizes of patches and of the search for them; None chooses by the picture's size."""
    reach_px: float | None = None
    """How far from a target curve texture is regrown; None chooses by the picture's size."""
    diffusion_reach_px: float | None = None
    """Beyond this distance of the target curves nothing moves; None holds only the picture's border."""
    variety: float = 0.5
    """Cost of showing a place of the source once more."""
    refine: float = 0.35
    """Share of the patches that is done again, over the worst seams."""
    mirrored: bool = False
    """Whether candidates may be mirrored across the curve's normal."""
    seed: int = 0


@dataclass(frozen=True, eq=False)
class Scene:
    """What is known before a patch is grown."""

    way: Correspondence
    area: Region
    fields: Fields
    kept: tuple[Ints, Ints] | None
    """See `Painter.kept`."""


def retexture(
    pixels: Pixels,
    curves: list[FeatureCurve],
    settings: Settings | None = None,
    *,
    linear: bool = False,
    matte: Bytes | None = None,
    source_mask: Bytes | None = None,
) -> Job[Retexture]:
    """Move feature curves of a picture (H, W, C) and regrow the texture along them.

    Each preview is a `Retexture` too: the plain deformation, the coarse result, then better ones. `matte` (H, W), over
    127, bounds where the result may differ from the plain deformation, `source_mask` where texture is taken from.
    Raises `InputError` for curves or masks that cannot be used.
    """
    settings = settings or Settings()
    shape = pixels.shape[0], pixels.shape[1]
    check(shape, curves, matte, source_mask)
    watch = Stopwatch("diffuse", "coordinates", "search", "seams", "blend")
    with watch("diffuse"):
        pieces = disjoint(curves)
        grid, move = diffusion.deformation(shape, pieces, reach_px=settings.diffusion_reach_px)
        place = plain_place(grid, move, (slice(0, shape[0]), slice(0, shape[1])))
    found = Retexture(grid, move, place, np.zeros(shape, np.int32))
    yield Progress(0.05, "deforming", found)
    with watch("coordinates"):
        picture = compared(pixels, linear=linear)
        shown = read(picture, place, Kernel.CUBIC)
        patch = settings.patch or PatchShape.for_picture(*shape)
        scene = prepared(pieces, found, contrast(picture), patch, settings.reach_px, matte)
        found = replace(found, compression=scene.way.compression)
        origins = ordered_origins(scene.way, scene.area.must, lattice(patch))
        patches = Patches(origins, patch, scene.fields, scene.way)
        coarse_patches = patches if patches.kept else sparser(scene, patch)
    # Handed over and not kept: a picture's worth of places is a hundred megabytes for a large one.
    yield Progress(0.15, "laying patches", laid(coarse_patches, scene.area, found))
    canvas = Canvas(shown, place, must=scene.area.must, may=scene.area.may)
    usable = None if source_mask is None else source_mask > 127
    rng = np.random.default_rng(settings.seed)
    painter = Painter(picture, usable, canvas, patch, settings.variety, settings.mirrored, rng, watch, scene.kept)
    work = synthesised(painter, scene.way, scene.fields, patches, refine=settings.refine)
    yield from with_previews(part(work, 0.15, 1.0), found, canvas)
    return Retexture(
        grid,
        move,
        canvas.place,
        canvas.label,
        origins=tuple(painter.origins),
        compression=scene.way.compression,
        candidates=painter.candidates,
        seconds={**watch.seconds, "total": watch.total},
        final=True,
    )


def with_previews(work: Job[None], plain: Retexture, canvas: Canvas) -> Job[None]:
    """Run `work` and show the canvas whenever a stage of it is done."""
    stage = ""
    for step in work:
        if stage and step.note != stage:
            step = replace(step, preview=replace(plain, place=canvas.place.copy(), label=canvas.label.copy()))
        stage = step.note
        yield step


def compared(pixels: Pixels, *, linear: bool) -> Singles:
    """Return what patches are compared by: encoded RGB (H, W, 3) from 0 to 1, before grey where transparent."""
    light = color.unit(pixels)
    split = color.color_channels(light.shape[2])
    colours = color.encode(light[..., :split]) if linear else light[..., :split]
    if split < light.shape[2]:
        colours = colours * light[..., split:] + np.float32(0.5) * (1 - light[..., split:])
    return np.ascontiguousarray(np.broadcast_to(colours, (*light.shape[:2], 3)), np.float32)


def prepared(
    pieces: list[FeatureCurve],
    plain: Retexture,
    fine: Singles,
    patch: PatchShape,
    reach_px: float | None,
    matte: Bytes | None,
) -> Scene:
    """Return the coordinates around both sides of the curves, and where to regrow."""
    targets = [piece.target or followed(piece.source, plain) for piece in pieces]
    source, target = CurveSet([piece.source for piece in pieces]), CurveSet(targets)
    shape = plain.grid.shape
    farthest = float(np.linalg.norm(plain.field, axis=-1).max())
    reach_px = reach_px or max(min(REACH * max(shape), REACH_PER_MOVE * farthest), LEAST_REACH_PX)
    # What a place shows comes from where the deformation has it, or from where it lies along the curve.
    fine = np.maximum(read(fine, plain.place), plain.grid.at_pixels(beside(source, target, fine, plain))[..., 0])
    edge_px = 1.5 * patch.rib
    area = region(plain.grid, plain.field, target, fine, reach_px=reach_px, edge_px=edge_px, matte=matte)
    compression = diffusion.compression(plain.grid, plain.field)
    way = Correspondence(source, target, plain.grid, plain.field, compression, area.inner, area.nearness, fine)
    margin = patch.spine + patch.search_along + 4
    y, x = (np.flatnonzero(area.may.any(axis=axis)) for axis in (1, 0))
    bounds = (x[0], y[0], x[-1], y[-1]) if len(x) else (0, 0, 1, 1)
    box = source.points.min(axis=0), source.points.max(axis=0)
    far = 1.2 * reach_px + margin
    fields = (
        DirectionField(target, (bounds[0] - margin, bounds[1] - margin, bounds[2] + margin, bounds[3] + margin)),
        DirectionField(source, (*(box[0] - far), *(box[1] + far))),
    )
    kept = (near_curves(source, shape), near_curves(target, shape)) if len(pieces) > 1 else None
    return Scene(way, area, fields, kept)


def beside(source: CurveSet, target: CurveSet, values: Singles, plain: Retexture) -> Singles:
    """Return at the grid's nodes (R, C, 1) the `values` (H, W) of the places that correspond along the curves.

    They are looked up at every second node, which is near enough to tell texture from none.
    """
    nodes = plain.grid.nodes
    some = nodes[::2, ::2]
    found = read(values, along_curves(source, target, some.reshape(-1, 2))[1]).reshape(some.shape[:2])
    return found.repeat(2, axis=0).repeat(2, axis=1)[: nodes.shape[0], : nodes.shape[1], None]


def followed(source: Curve, plain: Retexture) -> Curve:
    """Return where the plain deformation takes a passive curve: the places q with q + D(q) on it."""
    nodes = plain.grid.nodes.reshape(-1, 2)
    origin = nodes + plain.field.reshape(-1, 2)
    line = source.at(source.parameters(step=2.0))
    _, near = cKDTree(origin).query(line)
    place = nodes[near]
    for _ in range(8):
        place = place + 0.5 * (line - place - plain.grid.at(plain.field, place))
    return fit(place, tolerance=1.0, closed=source.closed)


def near_curves(curves: CurveSet, shape: tuple[int, int]) -> Ints:
    """Return which curve runs within `KEPT_PX` of each pixel (H, W); -1 where none does."""
    kept = np.full(shape, -1, np.int32)
    for i in range(len(curves.curves)):
        line = curves.points[curves.index == i]
        cv2.polylines(kept, [np.rint(line).astype(np.int32)], curves.curves[i].closed, i, int(2 * KEPT_PX + 1))
    return kept.astype(np.int64)


def laid(patches: Patches, area: Region, plain: Retexture) -> Retexture:
    """Return the result without any choice: every pixel from the most central patch, at its corresponding place."""
    best = np.where(area.must, np.inf, -1).astype(np.float32)
    place, label, count = plain.place.copy(), plain.label.copy(), 0
    for batch in patches:
        coarse(batch, best, place, label, count + 1)
        count += len(batch.origins)
    return replace(plain, place=place, label=label, origins=(patches.origins,))


def sparser(scene: Scene, patch: PatchShape) -> Patches:
    """Return patches for the coarse result alone, that hardly overlap and hold no candidates to choose from."""
    origins = ordered_origins(scene.way, scene.area.must, lattice(patch, stride=COARSE_STRIDE))
    return Patches(origins, replace(patch, search_along=1, search_across=1), scene.fields, scene.way)


def check(shape: tuple[int, int], curves: list[FeatureCurve], matte: Bytes | None, source_mask: Bytes | None) -> None:
    """Raise `InputError` for curves and masks without any effect, or of which nothing sensible can be made."""
    if all(curve.passive for curve in curves):
        raise InputError("no curve has a target")
    limit = np.array([shape[1], shape[0]]) - 0.5
    for i, curve in enumerate(curves, 1):
        for name, line in (("source", curve.source), ("target", curve.target)):
            if line is None:
                continue
            points = line.at(line.parameters(step=1.0))
            if not ((points >= -0.5) & (points <= limit)).all(axis=1).any():
                raise InputError(f"curve {i}: its {name} lies outside the picture")
            if line.length < SHORTEST_PX:
                raise InputError(f"curve {i}: its {name} is shorter than {SHORTEST_PX:.0f} px")
    for name, mask in (("matte", matte), ("source mask", source_mask)):
        if mask is not None and not (mask > 127).any():
            raise InputError(f"the {name} is empty")
