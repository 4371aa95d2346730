"""The document: everything the artist made, and nothing that can be computed from it.

Every edit is a function `Document -> Document`. Places are stored normalised, (0, 0) the picture's top left corner and
(1, 1) its bottom right one, so that a project keeps its meaning when the picture is swapped for a larger one.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Literal, TypeAlias

import numpy as np

from core.arrays import InputError, Points, as_points, readonly
from core.document.feature import Feature
from core.document.keys import Span, Track
from core.document.overlay_settings import Cloth
from core.document.ring import Ring
from core.imaging.images import Image
from core.rasters.raster import Raster
from core.retexture.defaults import VARIETY
from core.surfaces.surface import Surface
from core.warps.map_file import WarpMap

Keep: TypeAlias = Literal["similarity", "rigid", "none"]
Method: TypeAlias = Literal["exact", "per-quad"]
Frame: TypeAlias = Literal["held", "free"]
Mode: TypeAlias = Literal["warp", "retexture", "overlay"]
"""A way of working, and the result that belongs to it."""
Place: TypeAlias = tuple[float, float]
"""A normalised position."""

SIDE, RING = 4, 12
"""Control points of one side of an outline, and of all four."""


@dataclass(frozen=True)
class WarpSettings:
    """Which W, and how strictly features are kept."""

    preset: str | None = None
    """A name of `core.warps.presets.PRESETS`, or None for no preset."""
    bend: float = 0.0
    horizontal: float = 0.0
    vertical: float = 0.0
    """Per cent, -100 to 100."""
    vertical_axis: bool = False
    values: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}), hash=False)
    """Further parameters of the preset, by name."""
    aspect: Place = (1.0, 1.0)
    """Width and height of the result over the picture's: resizing to another aspect ratio."""
    frame: Frame = "held"
    """Whether pins and curves leave the outline where it is, or draw it along."""
    keep: Keep = "similarity"
    method: Method = "exact"
    weight: float = 10.0
    """wF of FAT sec. 2.1."""
    falloff: float = 2.0
    """rho of FAT eq. 6, in cells."""
    straight: bool = False
    """Whether long straight lines of the picture stay straight beside features."""
    cell_px: float | None = None
    """Side of a grid cell; None for a grid of 20 000 to 50 000 nodes."""


@dataclass(frozen=True)
class RetextureSettings:
    """How texture is regrown along moved feature curves."""

    along_px: int | None = None
    """Side of a patch along the curve; None, here and below, chooses by the picture's size."""
    across_px: int | None = None
    search_along_px: int | None = None
    """Side of the region from which candidates are taken, along the curve."""
    search_across_px: int | None = None
    reach: float | None = None
    """How far from a target curve texture is regrown, as a share of the picture's longer side; None chooses."""
    move_within: float | None = None
    """Beyond this distance of the target curves, such a share too, nothing moves; None holds only the border."""
    variety: float = VARIETY
    """Cost of showing a place of the picture once more."""
    mirrored: bool = False
    """Whether patches may be mirrored across the curve's normal."""
    long_edges: bool = True
    """Whether long edges near moved curves are kept as passive curves would be."""
    left_out: tuple[Place, ...] = ()
    """Points on long edges, normalised, that are not to be kept."""
    seed: int = 0


@dataclass(frozen=True)
class Pin:
    """A point of the picture and where it is to go."""

    at: Place
    to: Place
    ring: Ring | None = None
    """How the picture is turned and scaled around it; None leaves that open."""
    keys: Track = ()
    """Where it is to go at single frames, normalised as `to`, which holds where there are none."""
    stiff: float = 0.0
    """So far around it, as a share of the picture's diagonal, the picture keeps its shape."""


@dataclass(frozen=True, eq=False)
class CurvePair:
    """A curve on the picture and where it is to go: control points (3k + 1, 2) of k cubic Bezier segments each."""

    source: Points
    target: Points
    closed: bool = False
    passive: bool = False
    corners: frozenset[int] = frozenset()
    """Numbers of the knots at which the curve may turn; at the others both handles stay in one line."""

    def __post_init__(self) -> None:
        for name in ("source", "target"):
            object.__setattr__(self, name, readonly(as_points(getattr(self, name), "a curve's points").copy()))


@dataclass(frozen=True, eq=False)
class Outline:
    """Where the picture's edge goes: four cubic Bezier sides as one ring of control points.

    `ring` is (12, 2), clockwise from the top left corner: corners at 0, 3, 6 and 9, two handles after each.
    """

    ring: Points

    def __post_init__(self) -> None:
        ring = as_points(self.ring, "outline")
        if len(ring) != RING:
            raise InputError(f"outline: needs {RING} points, not {len(ring)}")
        object.__setattr__(self, "ring", readonly(ring.copy()))

    @classmethod
    def straight(cls) -> "Outline":
        """Return the outline that leaves the edge where it is."""
        corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        step = (np.roll(corners, -1, axis=0) - corners) / 3
        return cls(np.stack([corners, corners + step, corners + 2 * step], axis=1).reshape(RING, 2))

    @property
    def sides(self) -> tuple[Points, Points, Points, Points]:
        """Top, right, bottom and left side, (4, 2) each, clockwise."""
        top, right, bottom, left = (np.take(self.ring, range(k, k + SIDE), axis=0, mode="wrap") for k in (0, 3, 6, 9))
        return top, right, bottom, left


UNSAID = 127
"""Grey level of `Document.regrow` where the artist has said nothing."""


@dataclass(frozen=True, eq=False)
class Document:
    """Inputs only; arrays inside are read-only. An edit that changes nothing returns the document itself."""

    image: Image
    mask: Raster
    """The picture's size; over 127 is feature."""
    numbers: Raster | None = None
    """The picture's size; the number of the feature that a pixel of the mask is of, as `core.selection.features` says;
    None where none has one."""
    features: tuple[Feature, ...] = ()
    """Those of which something is said, by number."""
    warp: WarpSettings = field(default_factory=WarpSettings)
    outline: Outline | None = None
    pins: tuple[Pin, ...] = ()
    curves: tuple[CurvePair, ...] = ()
    """Inner curves of Warp mode."""
    cloth: Cloth = field(default_factory=Cloth)
    """What Overlay mode works with."""
    retexture: RetextureSettings = field(default_factory=RetextureSettings)
    feature_curves: tuple[CurvePair, ...] = ()
    """Curves of Retexture mode; both sides are places in the picture, whose size is the result's."""
    matte: Raster | None = None
    """The picture's size; over 127 is where texture may be regrown. None, or nothing painted, for everywhere."""
    source_mask: Raster | None = None
    """The picture's size; over 127 is where texture may be taken from. None, or nothing painted, for everywhere."""
    regrow: Raster | None = None
    """The picture's size; 255 where texture is regrown whatever is found, 0 where it is not, `UNSAID` elsewhere."""
    mode: Mode = "warp"
    """The mode of the last edit, whose result an export shows."""
    warp_map: WarpMap | None = None
    """A warp that was read from a file; the preset bends what it gives."""
    surface: Surface | None = None
    """The surface in space that the picture is laid on; its chart is the warp, in place of one from a file."""
    tracks: Mapping[str, Track] = field(default_factory=lambda: MappingProxyType({}))
    """Keys of parameters of the warp by name: `core.document.animated` says which. `size` is in times the picture."""
    span: Span = field(default_factory=Span)
    """The frames of the timeline."""

    @classmethod
    def of(cls, image: Image) -> "Document":
        """Return the document that holds nothing but `image`."""
        return cls(image, Raster.filled(*image.size_px))

    @cached_property
    def canvas_px(self) -> tuple[int, int]:
        """Width and height of the result: the picture's, times `WarpSettings.aspect`; on a surface, its chart's."""
        if self.surface is not None:
            return self.surface.chart.size_px(self.size_px)
        width, height = (
            max(1, round(side * factor)) for side, factor in zip(self.size_px, self.warp.aspect, strict=True)
        )
        return width, height

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the picture."""
        return self.image.size_px

    def changed(self, **changes: object) -> "Document":
        """Return the document with some of its parts exchanged, itself where each is the one it has."""
        if all(getattr(self, name) is part for name, part in changes.items()):
            return self
        return replace(self, **changes)  # type: ignore[arg-type]

    @property
    def retexture_masks(self) -> dict[str, Raster | None]:
        """What bounds Retexture, by name."""
        return {"matte": self.matte, "source_mask": self.source_mask, "regrow": self.regrow}

    def with_image(self, image: Image) -> "Document":
        """Return the document with another picture; what was done keeps its places, the masks are stretched."""
        size = image.size_px
        masks = {name: part and part.resized(*size) for name, part in self.retexture_masks.items()}
        return self.changed(
            image=image,
            mask=self.mask.resized(*size),
            numbers=self.numbers and self.numbers.resized(*size, blends=False),
            **masks,
            cloth=self.cloth.resized(*size),
        )

    def with_cloth(self, **changes: object) -> "Document":
        """Return the document with some of its `Cloth` exchanged."""
        return self.changed(cloth=self.cloth.changed(**changes))

    def with_warp(self, **changes: object) -> "Document":
        """Return the document with some of its `WarpSettings` changed, itself where they are so already."""
        warp = replace(self.warp, **changes)  # type: ignore[arg-type]
        return self if warp == self.warp else replace(self, warp=warp)

    def with_retexture(self, **changes: object) -> "Document":
        """Return the document with some of its `RetextureSettings` changed, itself where they are so already."""
        settings = replace(self.retexture, **changes)  # type: ignore[arg-type]
        return self if settings == self.retexture else replace(self, retexture=settings)

    @property
    def given_up(self) -> frozenset[int]:
        """Numbers of the features that are not to keep their shape, though perhaps their straight lines."""
        return frozenset(feature.number for feature in self.said if not feature.is_kept or feature.keeps_lines)

    @property
    def said(self) -> tuple[Feature, ...]:
        """What is said of features, where there are numbers."""
        return self.features if self.numbers is not None else ()

    @property
    def result_px(self) -> tuple[int, int]:
        """Width and height of the result of the mode; on a surface, of its texture."""
        return self.canvas_px if self.mode == "warp" and self.surface is None else self.size_px


def places_from_pixels(size_px: tuple[int, int], points: Points) -> Points:
    """Return normalised places of pixel positions (..., 2)."""
    return np.divide(points + 0.5, size_px)


def pixels_from_places(size_px: tuple[int, int], places: Points) -> Points:
    """Return pixel positions of normalised places (..., 2)."""
    return np.multiply(places, size_px) - 0.5
