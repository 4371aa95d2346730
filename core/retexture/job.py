"""Retexturing as a job: deformation, coordinates, a coarse result at once, patches, and the result."""

from dataclasses import dataclass, replace
from random import Random

import numpy as np

from core.arrays import Bools, Bytes, CurveError, InputError, Pixels, Singles
from core.curves.feature_curves import FeatureCurve, disjoint
from core.imaging import color
from core.progress import Job, Progress, part
from core.retexture.defaults import VARIETY
from core.retexture.deformation import diffusion
from core.retexture.region import Region, Wishes
from core.retexture.result import Retexture, plain_place
from core.retexture.retract import retract
from core.retexture.sampling import Kernel, read
from core.retexture.synthesis.candidate_pool import Bounds, prefetch_candidates
from core.retexture.synthesis.graph_cut import GrownPicture
from core.retexture.synthesis.long_edges import LongEdges, find_long_edges
from core.retexture.synthesis.patches import Patches, PatchShape, lay_coarsely
from core.retexture.synthesis.placement import order_origins
from core.retexture.synthesis.scene import RetextureScene, prepare
from core.retexture.synthesis.synthesis import Painter, lattice, synthesise
from core.retexture.windows import place_in, window_around
from core.stopwatch import Stopwatch

REACH, REACH_PER_MOVE = 0.12, 1.25
"""Texture is regrown this far from a target curve: a share of the picture's longer side, less if nothing moves far."""
LEAST_REACH_PX = 40.0
FAR_SIDES = 32
"""A control point may lie so many of the picture's longer sides from its middle; a curve that runs farther would cost
time and memory for places that no picture has."""
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
    variety: float = VARIETY
    """Cost of showing a place of the source once more."""
    refine: float = 0.35
    """Share of the patches that is done again, over the worst seams."""
    mirrored: bool = False
    """Whether candidates may be mirrored across the curve's normal."""
    long_edges: bool = True
    """Whether long edges near moved curves are kept as passive curves would be."""
    left_out: tuple[tuple[float, float], ...] = ()
    """Points on long edges, px, that are not to be kept."""
    seed: int = 0

    def patch_for(self, height: int, width: int) -> PatchShape:
        """Return the sizes for a picture of that height and width."""
        return self.patch or PatchShape.for_picture(height, width)


def retexture(
    pixels: Pixels,
    curves: list[FeatureCurve],
    settings: Settings | None = None,
    *,
    linear: bool = False,
    matte: Bytes | None = None,
    source_mask: Bytes | None = None,
    regrow: Bytes | None = None,
    previews: bool = True,
) -> Job[Retexture]:
    """Move feature curves of a picture (H, W, C) and regrow the texture along them.

    Each preview is a `Retexture` too: the plain deformation, the coarse result, then better ones; without `previews`
    none but the first is made. `matte` (H, W), over 127, bounds where the result may differ from the plain
    deformation, `source_mask` where texture is taken from. Where `regrow` (H, W) is over 191 texture is regrown, and
    under 64 it is not, whatever would be found.
    Raises `InputError` for curves or masks that cannot be used.
    """
    settings = settings or Settings()
    shape = pixels.shape[0], pixels.shape[1]
    check(shape, curves, matte, source_mask)
    wishes = Wishes.of(matte, regrow)
    patch = settings.patch_for(*shape)
    watch = Stopwatch("diffuse", "coordinates", "search", "seams", "blend")
    with watch.measure("diffuse"):
        pieces = disjoint(curves)
        found = deform(shape, pieces, settings.diffusion_reach_px)
    yield Progress(0.05, "deforming", found)
    with watch.measure("coordinates"):
        picture = compare(pixels, linear=linear)
        reach = settings.reach_px or usual_reach(found)
        edges = find_long_edges(picture, pieces, patch, reach) if settings.long_edges else LongEdges()
        edges = edges.but(settings.left_out, patch.rib)
        scene = prepare(pieces, found, picture, patch, reach, wishes, edges)
        found = replace(found, compression=scene.way.compression, edges=edges.curves)
        usable = None if source_mask is None else source_mask > 127
        asked = wishes.regrown
        rough = lay(sparser(scene, patch), scene.area, found) if previews else None
        rough = rough and cut_back(rough, found, picture, usable, asked)
    yield Progress(0.15, "laying patches", rough)
    # Not kept: a picture's worth of places is a hundred megabytes for a large one.
    del rough
    painter, work = begin(picture, scene, found, usable, settings, watch)
    work = part(work, 0.15, 1.0)
    yield from with_previews(work, found, painter, usable, asked) if previews else work
    canvas, found = painter.canvas, replace(found, origins=tuple(painter.origins), candidates=painter.candidates)
    # Of a large picture, what patches are laid by takes as much memory as what follows.
    del painter, work, scene
    with watch.measure("seams"):
        retract(canvas, picture, found.place, usable, asked)
    del picture
    return finish(found, canvas, watch)


def begin(
    picture: Singles,
    scene: RetextureScene,
    plain: Retexture,
    usable: Bools | None,
    settings: Settings,
    watch: Stopwatch,
) -> tuple[Painter, Job[None]]:
    """Return a painter before the plain deformation of a picture (H, W, 3), and the job that lays its patches.

    `usable` (H, W) is where texture may be taken from, None for everywhere.
    """
    patch = settings.patch_for(*plain.grid.shape)
    with watch.measure("coordinates"):
        bounds = Bounds(scene.area.may, scene.area.free, usable, scene.kept, scene.drawn)
        origins = order_origins(scene.way, scene.area.must, lattice(patch))
        first = prefetch_candidates(Patches(origins, patch, scene.fields, scene.way), picture, bounds)
    # Patches reach no farther than this, and nothing beyond is looked at.
    window = window_around(scene.area.may, patch.window)
    place = plain.place[window]
    shown = place_in(window, read(picture, place, Kernel.CUBIC), picture.shape)
    place = place_in(window, place, plain.place.shape)
    canvas = GrownPicture(shown, place, must=scene.area.must, may=scene.area.may)
    # The generator of the standard library: loading NumPy's takes longer than all that is drawn here.
    chance = Random(settings.seed)
    painter = Painter(picture, bounds, canvas, patch, settings.variety, settings.mirrored, chance, watch)
    return painter, synthesise(painter, scene, first, len(origins), refine=settings.refine)


def deform(shape: tuple[int, int], pieces: list[FeatureCurve], reach_px: float | None) -> Retexture:
    """Return the plain deformation of a picture of `shape`, (H, W)."""
    grid, move = diffusion.deformation(shape, pieces, reach_px=reach_px)
    place = plain_place(grid, move, (slice(0, shape[0]), slice(0, shape[1])))
    return Retexture(grid, move, place, np.zeros(shape, np.int32))


def usual_reach(plain: Retexture) -> float:
    """Return how far from the targets texture is regrown when nobody says."""
    farthest = float(np.linalg.norm(plain.field, axis=-1).max())
    return max(min(REACH * max(plain.grid.shape), REACH_PER_MOVE * farthest), LEAST_REACH_PX)


def finish(plain: Retexture, canvas: GrownPicture, watch: Stopwatch) -> Retexture:
    """Return what the canvas shows in the end, and what it took."""
    seconds = {**watch.seconds, "total": watch.total}
    return replace(plain, place=shown_places(plain, canvas), label=canvas.label, seconds=seconds, final=True)


def shown_places(plain: Retexture, canvas: GrownPicture) -> Singles:
    """Return the places (H, W, 2) that are shown: the canvas's where something is regrown, else the deformation's."""
    place, window = plain.place.copy(), window_around(canvas.label > 0)
    place[window] = np.where((canvas.label[window] > 0)[..., None], canvas.place[window], place[window])
    return place


def cut_back(
    preview: Retexture,
    plain: Retexture,
    picture: Singles,
    usable: Bools | None,
    asked: Bools | None,
    seams: Singles | None = None,
) -> Retexture:
    """Return a preview that shows the plain deformation again where that costs less, see `retract`.

    `seams` (2, H, W) are the costs of those between its patches, None for nothing.
    """
    nowhere = np.zeros(plain.label.shape, bool)
    shown = read(picture, preview.place, Kernel.CUBIC)
    canvas = GrownPicture(shown, preview.place.copy(), must=nowhere, may=~nowhere)
    canvas.label = preview.label.copy()
    canvas.seams = canvas.seams if seams is None else seams.copy()
    retract(canvas, picture, plain.place, usable, asked)
    return replace(preview, place=canvas.place, label=canvas.label)


def with_previews(
    work: Job[None], plain: Retexture, painter: Painter, usable: Bools | None, asked: Bools | None
) -> Job[None]:
    """Run `work` and show the painter's canvas whenever a stage of it is done, as far as it will stay."""
    stage, canvas = "", painter.canvas
    for step in work:
        if stage and step.note != stage:
            place = shown_places(plain, canvas)
            shown = replace(plain, place=place, label=canvas.label, origins=tuple(painter.origins))
            step = replace(step, preview=cut_back(shown, plain, painter.picture, usable, asked, canvas.seams))
        stage = step.note
        yield step


def compare(pixels: Pixels, *, linear: bool) -> Singles:
    """Return what patches are compared by: encoded RGB (H, W, 3) from 0 to 1, before grey where transparent."""
    light = color.unit(pixels)
    split = color.color_channels(light.shape[2])
    colours = color.encode(light[..., :split]) if linear else light[..., :split]
    if split < light.shape[2]:
        colours = colours * light[..., split:] + np.float32(0.5) * (1 - light[..., split:])
    return np.ascontiguousarray(np.broadcast_to(colours, (*light.shape[:2], 3)), np.float32)


def lay(patches: Patches, area: Region, plain: Retexture) -> Retexture:
    """Return the result without any choice: every pixel from the most central patch, at its corresponding place."""
    best = np.where(area.must, np.inf, -1).astype(np.float32)
    place, label, count = plain.place.copy(), plain.label.copy(), 0
    for batch in patches:
        lay_coarsely(batch, best, place, label, count + 1)
        count += len(batch.origins)
    return replace(plain, place=place, label=label, origins=(patches.origins,))


def sparser(scene: RetextureScene, patch: PatchShape) -> Patches:
    """Return patches for the coarse result alone, that hardly overlap and hold no candidates to choose from."""
    origins = order_origins(scene.way, scene.area.must, lattice(patch, stride=COARSE_STRIDE))
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
            if np.abs(line.points - limit / 2).max() > FAR_SIDES * max(shape):
                raise CurveError(i, f"its {name} has a point that lies over {FAR_SIDES} pictures away")
            points = line.at(line.parameters(step=1.0))
            if not ((points >= -0.5) & (points <= limit)).all(axis=1).any():
                raise CurveError(i, f"its {name} lies outside the picture")
            if line.length < SHORTEST_PX:
                raise CurveError(i, f"its {name} is shorter than {SHORTEST_PX:.0f} px")
    for name, mask in (("matte", matte), ("source mask", source_mask)):
        if mask is not None and not (mask > 127).any():
            raise InputError(f"the {name} is empty")
