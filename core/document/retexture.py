"""From a document to its retextured picture: what the window shows stage by stage, and what is exported."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from core.arrays import Bytes, CurveError, InputError, Points
from core.curves import curve_edit
from core.curves.bezier import Curve
from core.curves.feature_curves import FeatureCurve, disjoint, measure_area
from core.document.document import CurvePair, Document, pixels_from_places, places_from_pixels
from core.imaging.image import Image
from core.progress import Job, Progress, Steps
from core.rasters.raster import Raster
from core.retexture import debug_views as overlays
from core.retexture.job import Settings, retexture
from core.retexture.result import Retexture
from core.retexture.synthesis.patches import PatchShape
from core.retexture.synthesis.scene import follow

APPLYING = 0.95
"""Share of the work after which only the picture is to be resampled."""
SIDES = ("along_px", "across_px", "search_along_px", "search_across_px")
"""Fields of `RetextureSettings` that are sides, in the order of `PatchShape`."""
MOST_SIDE_PX, MOST_VARIETY = 501, 100
STILL = 1e-9
"""A target nearer to its source, in shares of the picture, has not been moved."""


@dataclass(frozen=True, eq=False)
class Regrown:
    """A stage of the work: what is known of every pixel, and the picture that makes."""

    found: Retexture
    image: Image | None
    """None while no texture is regrown, which leaves the plain deformation."""
    document: Document
    """What it was made of."""

    @cached_property
    def has_patches(self) -> bool:
        """Whether the result shows any patch, and not the plain deformation everywhere."""
        return bool((self.found.label > 0).any())

    @cached_property
    def regrown(self) -> Raster:
        """Where texture is regrown, in the result; the rest is the plain deformation."""
        return Raster.from_array(np.where(self.found.label > 0, 255, 0).astype(np.uint8))

    @cached_property
    def seams(self) -> Raster:
        """Where patches meet, in the result."""
        return Raster.from_array(overlays.seams(self.found))

    @cached_property
    def compression(self) -> Raster:
        """How the deformation presses the picture together, in the result."""
        return Raster.from_array(overlays.compression(self.found))

    @cached_property
    def grids(self) -> Points:
        """Nodes (n, K, J, 2) of the patches in the result, every fourth of them."""
        pieces = disjoint(feature_curves(self.document))
        lines = [piece.target for piece in pieces if piece.target is not None]
        return overlays.patch_grids(self.found, [*lines, *self.followers], shape_of(self.document))

    @cached_property
    def followers(self) -> list[Curve]:
        """Where passive curves are in the result."""
        pieces = disjoint(feature_curves(self.document))
        return [follow(piece.source, self.found) for piece in pieces if piece.target is None]


def is_moved(pair: CurvePair) -> bool:
    """Return whether a curve has a target anywhere else than where it is."""
    return not pair.passive and (
        pair.source.shape != pair.target.shape or bool(np.abs(pair.source - pair.target).max() > STILL)
    )


def moves(document: Document) -> bool:
    """Return whether any feature curve is to go elsewhere, so that there is something to retexture."""
    return any(is_moved(pair) for pair in document.feature_curves)


def feature_curves(document: Document) -> list[FeatureCurve]:
    """Return the feature curves in pixels; raise `CurveError` for one whose points make no curve."""
    size = document.size_px

    def curve(number: int, pair: CurvePair, side: str) -> Curve:
        try:
            return Curve(pixels_from_places(size, getattr(pair, side)), pair.closed)
        except InputError as fault:
            raise CurveError(number, str(fault)) from None

    return [
        FeatureCurve(curve(number, pair, "source"), None if pair.passive else curve(number, pair, "target"))
        for number, pair in enumerate(document.feature_curves, 1)
    ]


def with_curve(document: Document, curve: Curve) -> Document:
    """Return the document with one more feature curve, in pixels, whose target lies where it is."""
    points = places_from_pixels(document.size_px, curve.points)
    count = curve_edit.knots_of(points, closed=curve.closed)
    around = [curve_edit.handles_at(points, knot, closed=curve.closed) for knot in range(count)]
    corners = frozenset(
        knot
        for knot, (before, after) in enumerate(around)
        if before is None
        or after is None
        or not curve_edit.is_straight(curve.points[before], curve.points[3 * knot], curve.points[after])
    )
    pair = CurvePair(points, points, closed=curve.closed, corners=corners)
    return document.changed(feature_curves=(*document.feature_curves, pair))


def in_pixels(document: Document, share: float | None) -> float | None:
    """Return a share of the picture's longer side in pixels."""
    return None if share is None else share * max(document.size_px)


def usual_sides(size_px: tuple[int, int]) -> dict[str, int]:
    """Return the sides of patches and of the search for a picture of `size_px`, by field of the settings."""
    width, height = size_px
    shape = PatchShape.for_picture(height, width)
    halves = (shape.spine, shape.rib, shape.search_along, shape.search_across)
    return {name: 2 * half + 1 for name, half in zip(SIDES, halves, strict=True)}


def shape_of(document: Document) -> PatchShape:
    """Return the patches that the settings ask for, chosen by the picture's size where they leave that open."""
    usual = usual_sides(document.size_px)
    return PatchShape(*((getattr(document.retexture, name) or usual[name]) // 2 for name in SIDES))


def settings_of(document: Document) -> Settings:
    """Return the engine's settings; raise `InputError` for some that no slider gives."""
    chosen = document.retexture
    sides = [side for side in (getattr(chosen, name) for name in SIDES) if side is not None]
    if not all(1 <= side <= MOST_SIDE_PX for side in sides):
        raise InputError(f"retexture: patches and searches take sides of 1 to {MOST_SIDE_PX} pixels")
    if not 0 <= chosen.variety <= MOST_VARIETY:
        raise InputError(f"retexture: variety {chosen.variety:g}: not from 0 to {MOST_VARIETY}")
    if chosen.seed < 0:
        raise InputError(f"retexture: seed {chosen.seed}: must not be negative")
    left_out = pixels_from_places(document.size_px, np.reshape(chosen.left_out, (-1, 2)))
    return Settings(
        patch=shape_of(document),
        reach_px=in_pixels(document, chosen.reach),
        diffusion_reach_px=in_pixels(document, chosen.move_within),
        variety=chosen.variety,
        mirrored=chosen.mirrored,
        long_edges=chosen.long_edges,
        left_out=tuple((float(x), float(y)) for x, y in left_out),
        seed=chosen.seed,
    )


def bound(raster: Raster | None) -> Bytes | None:
    """Return a mask (H, W) for the engine; one that marks nothing bounds nothing."""
    if raster is None or raster.is_empty:
        return None
    values = raster.array
    return values if (values > 127).any() else None


def found(document: Document) -> Job[Retexture]:
    """Return where every pixel of the retextured picture comes from; raise `InputError` where that cannot be said."""
    curves = feature_curves(document)
    for number, curve in enumerate(curves, 1):
        if (
            curve.target is not None
            and curve.source.closed
            and measure_area(curve.source) * measure_area(curve.target) < 0
        ):
            raise CurveError(number, "its source and its target run round in opposite directions")
    return (
        yield from retexture(
            document.image.pixels,
            curves,
            settings_of(document),
            linear=document.image.linear,
            matte=bound(document.matte),
            source_mask=bound(document.source_mask),
            regrow=None if document.regrow is None else document.regrow.array,
        )
    )


def regrow(document: Document) -> Job[Regrown]:
    """Retexture the document's picture; every step's preview is a `Regrown`, or None before the first."""
    image, steps, stage = document.image, Steps(found(document)), None
    for step in steps:
        if step.preview is not None:
            stage = Regrown(step.preview, _apply(image, step.preview, blend=False), document)
        yield Progress(APPLYING * step.fraction, step.note, stage)
    yield Progress(APPLYING, "resampling", stage)
    return Regrown(steps.result, _apply(image, steps.result, blend=True), document)


def _apply(image: Image, result: Retexture, *, blend: bool) -> Image | None:
    """Return the retextured picture; None where no texture is regrown yet."""
    if not result.patches:
        return None
    return image.with_pixels(result.apply(image.pixels, linear=image.linear, blend=blend))


def picture(document: Document, image: Image) -> Job[Image]:
    """Return `image`, the document's at any depth, retextured; itself where no curve is moved."""
    if not moves(document):
        return image
    result = yield from found(document)
    return image.with_pixels(result.apply(image.pixels, linear=image.linear))
