"""What Overlay mode adds to a document: where the pattern is sought, and how the new texture lies on the cloth."""

from dataclasses import dataclass, field, replace

import numpy as np

from core.arrays import InputError, Points, as_points, readonly
from core.imaging.image import Image
from core.rasters.raster import Raster


@dataclass(frozen=True)
class Laying:
    """How the new texture lies on the cloth, and how much of the photo shows in it."""

    size: float | None = None
    """Width of a copy, in texels of the old pattern; None for one that suits the cloth."""
    stretch: float = 1.0
    """Height of a copy over that of an undistorted one."""
    rotate_deg: float = 0.0
    """Clockwise, in the plane of the undeformed cloth."""
    offset: tuple[float, float] = (0.0, 0.0)
    """By how many copies the texture is moved."""
    mirror: bool = False
    upright: bool = True
    """Whether a copy is a rectangle, upright on the cloth; otherwise it leans as the old pattern's repeats do."""
    tile: bool = True
    """Whether the texture repeats; otherwise there is one copy."""
    detail: float = 1.0
    """alpha, the share of the photo's fine detail."""
    shading: float = 1.0
    """Times the contrast of the shading."""


@dataclass(frozen=True, eq=False)
class LatticeVertices:
    """A lattice that the artist corrected: whole coordinates (n, 2) and normalised places (n, 2)."""

    keys: Points
    places: Points

    def __post_init__(self) -> None:
        for name in ("keys", "places"):
            object.__setattr__(self, name, readonly(as_points(getattr(self, name), f"a lattice's {name}").copy()))
        if len(self.keys) != len(self.places):
            raise InputError("a lattice needs as many places as keys")


@dataclass(frozen=True, eq=False)
class Mending:
    """What the artist put right by hand of a lattice that was found: no search is run for it."""

    of: "Search"
    """What was found is that of this search."""
    lattice: LatticeVertices
    """All vertices as they are to be; those that are not held follow what is done beside them."""
    held: Points
    """Coordinates (k, 2) of the vertices that were moved, or are locked."""
    seams: tuple[Points, ...] = ()
    """Lines (n, 2) that separate pieces of the cloth, in places of the picture."""
    removed: Points = field(default_factory=lambda: np.empty((0, 2)))
    """Places (m, 2) of vertices that were removed."""

    def __post_init__(self) -> None:
        for name in ("held", "removed"):
            points = as_points(getattr(self, name), f"the vertices that are {name}").copy()
            object.__setattr__(self, name, readonly(points))
        seams = tuple(readonly(as_points(seam, "a seam").copy()) for seam in self.seams)
        object.__setattr__(self, "seams", seams)


@dataclass(frozen=True, eq=False)
class Search:
    """What the pattern is found from; the decomposition belongs to this object and to the picture."""

    region: Raster | None = None
    """The picture's size; over 127 is where cloth may be. None, or nothing painted, for everywhere."""
    texel: tuple[tuple[float, float], tuple[float, float]] | None = None
    """Places of two opposite corners of one texel, as the artist marked it."""
    lattice: LatticeVertices | None = None
    """A corrected lattice to go on from; there is no search then."""
    seed: int = 0
    whole_of: "Search | None" = None
    """The search whose find is followed on over the object that stands out there; there is no other one then."""
    mending: Mending | None = None
    """What was put right by hand since; all else is that of the search that is mended."""

    def resized(self, width_px: int, height_px: int) -> "Search":
        """Return the search in a picture of another size."""
        region = self.region and self.region.resized(width_px, height_px)
        mending = self.mending and replace(self.mending, of=self.mending.of.resized(width_px, height_px))
        whole_of = self.whole_of and self.whole_of.resized(width_px, height_px)
        return replace(self, region=region, whole_of=whole_of, mending=mending)


@dataclass(frozen=True, eq=False)
class Cloth:
    """Inputs of Overlay mode."""

    region: Raster | None = None
    """What is painted now; the next search takes it."""
    protected: Raster | None = None
    """The picture's size; how much of the photo stays as it is, though it lies on the cloth: buttons, a label."""
    covered: Raster | None = None
    """The picture's size; how much is covered though it was left out: a thing on the cloth, or a part not found."""
    search: Search | None = None
    """None while no pattern is sought."""
    texture: Image | None = None
    """None for the pattern that was found."""
    texture_name: str = ""
    laying: Laying = field(default_factory=Laying)
    seed: int = 0

    def changed(self, **changes: object) -> "Cloth":
        """Return the inputs with some of them exchanged, themselves where each is the one there is."""
        if all(getattr(self, name) is part for name, part in changes.items()):
            return self
        return replace(self, **changes)  # type: ignore[arg-type]

    def with_laying(self, **changes: object) -> "Cloth":
        """Return the inputs with some of `Laying` changed, themselves where they are so already."""
        laying = replace(self.laying, **changes)  # type: ignore[arg-type]
        return self if laying == self.laying else replace(self, laying=laying)

    def resized(self, width_px: int, height_px: int) -> "Cloth":
        """Return the inputs for a picture of another size."""
        region = self.region and self.region.resized(width_px, height_px)
        search = self.search and self.search.resized(width_px, height_px)
        protected = self.protected and self.protected.resized(width_px, height_px)
        covered = self.covered and self.covered.resized(width_px, height_px)
        return self.changed(region=region, protected=protected, covered=covered, search=search)
