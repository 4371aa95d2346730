"""What was found of a photo of cloth, as layers of its pixels, and the same put right by hand."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.document.document import Document, pixels_from_places, places_from_pixels
from core.document.overlay_settings import LatticeVertices, Mending
from core.imaging import color
from core.imaging.image import Image
from core.overlay.composition import differ, finite, light_of, middle_of
from core.overlay.detail.bare_layers import find_bare_layers, update_bare_layers
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError
from core.overlay.filters.distances import within
from core.overlay.laying.compositing import encode
from core.overlay.mending import Corrections, LaidCloth, mend
from core.overlay.mesh import boxes_of
from core.overlay.storage.layers_file import detail_of
from core.overlay.texel import Texel
from core.overlay.tolerances import RIM_PX
from core.progress import Job, Progress
from core.rasters.raster import Raster

if TYPE_CHECKING:
    from core.overlay.decomposition import Decomposition
    from core.overlay.found_cloth import FoundCloth

MENDING = "mending the lattice"
COPIES = 2.5
"""How many copies of a new texture go across the cloth unless the artist says otherwise."""


@dataclass(frozen=True, eq=False)
class OverlayLayers:
    """What was found of a photo; pixels outside the cloth are NaN in `uv`, `shading` and `detail`."""

    uv: Singles
    """(H, W, 2), texels."""
    shading: Singles
    """(H, W) or (H, W, 3)."""
    detail: Singles
    """(H, W, 3), with what it has of the old pattern."""
    bare_shading: Singles
    """As `shading`, without what that has of the old pattern."""
    bare_detail: Singles
    """(H, W, 3), what `bare_shading` leaves of the photo, without what that has of the old pattern."""
    coverage: Singles
    """(H, W)."""
    texel: Floats
    """(h, w, 3), encoded, 0 to 1."""
    basis: Floats
    """(2, 2), pixels of the undeformed cloth a texel."""
    lattice: Lattice
    explained: float = 0.0
    """What speaks for it beside another find of the same photo (`Evidence`)."""
    found: "FoundCloth | None" = None
    """What was split, from which a search for more of the cloth goes on; None where the layers come from files."""
    uncovered: "OverlayLayers | None" = None
    """The layers before some were covered by hand: a texture lies as on those."""
    painted: Raster | None = None
    """What was covered by hand."""

    @cached_property
    def pattern(self) -> Image:
        """The texel as a picture; it is rounded to 8 bits as it is."""
        return Image(color.quantise(self.texel.astype(np.float32), np.uint8))

    @cached_property
    def usual_light(self) -> float:
        """The median of the shading."""
        return light_of(self.shading)

    @cached_property
    def usual_size(self) -> float:
        """Whole texels of which about `COPIES` go across the cloth, 1 at least."""
        if self.uncovered is not None:
            return self.uncovered.usual_size
        texel_px = float(np.linalg.norm(self.basis[:, 0]))
        return float(max(1, round(np.sqrt(self.covered.sum()) / texel_px / COPIES)))

    @cached_property
    def middle(self) -> Floats:
        """What a texture is turned and scaled about (2,), texels: the middle of the cloth."""
        return middle_of(self.uv) if self.uncovered is None else self.uncovered.middle

    @cached_property
    def bare(self) -> "OverlayLayers":
        """The layers that go with a new texture."""
        return replace(self, shading=self.bare_shading, detail=self.bare_detail)

    @property
    def covered(self) -> Bools:
        """Pixels that have texture coordinates."""
        return finite(self.uv)

    @property
    def nbytes(self) -> int:
        """Bytes that its pixels take, and those of the picture that was searched."""
        bare = self.bare_shading, self.bare_detail
        planes = sum(part.nbytes for part in (self.uv, self.shading, self.detail, *bare, self.coverage))
        return planes + (0 if self.found is None else 2 * self.found.cloth.photo.nbytes)

    @cached_property
    def covered_share(self) -> float:
        """How much of the picture has texture coordinates, 0 to 1."""
        return float(self.covered.mean())

    @cached_property
    def repeats(self) -> int:
        """How many repeats of the old pattern fill as much of the picture as is covered."""
        return max(round(float(self.covered.sum()) / abs(float(np.linalg.det(self.basis)))), 1)


def mend_layers(document: Document, layers: OverlayLayers, mending: Mending) -> Job[OverlayLayers]:
    """Return the layers put right around the vertices that were moved, removed or added.

    The first step shows them as they lie then, in the light and with the detail of before; an added vertex has none.
    """
    keys, size_px = np.rint(mending.lattice.keys).astype(np.int64), document.size_px
    held = {(int(i), int(j)) for i, j in np.rint(mending.held)}
    wanted = Corrections(
        keys,
        pixels_from_places(size_px, mending.lattice.places),
        np.array([(i, j) in held for i, j in keys.tolist()], np.bool_),
        tuple(pixels_from_places(size_px, seam) for seam in mending.seams),
    )
    yield Progress(0.0, MENDING)
    cloth = mend(LaidCloth(layers.uv, layers.shading, layers.coverage, layers.lattice), wanted)
    if not finite(cloth.uv).any():
        raise NoPatternError("what is left of the lattice")
    laid = replace(layers, uv=cloth.uv, shading=cloth.shading, coverage=cloth.coverage, lattice=cloth.lattice)
    is_lit = set(map(tuple, keys.tolist())) <= set(map(tuple, layers.lattice.keys.tolist()))
    yield Progress(0.0, MENDING, laid if is_lit else None)
    return _with_detail(document, layers, laid)


def cover_layers(document: Document, layers: OverlayLayers, painted: Raster) -> OverlayLayers:
    """Return the layers that go on over what is painted."""
    # A window opens sooner without the engine.
    from core.overlay.covering import cover_painted

    before, opacity = (layers.uv, layers.shading), color.unit(painted.array)
    (uv, shading), coverage = cover_painted(before, layers.coverage, opacity, layers.basis)
    laid = replace(layers, uv=uv, shading=shading, coverage=coverage, uncovered=layers, painted=painted)
    return _with_detail(document, layers, laid)


def _with_detail(document: Document, before: OverlayLayers, laid: OverlayLayers) -> OverlayLayers:
    """Return layers of cloth that is `laid` otherwise than before, with the detail that is left around what differs."""
    texel, detail = Texel(laid.texel), before.detail.copy()
    # What a pixel shows of the texture depends on those beside it, too.
    changed = within(differ(laid.uv, before.uv) | differ(laid.shading, before.shading), RIM_PX)
    for box in boxes_of(changed, 2 * RIM_PX):
        part = document.image.with_pixels(document.image.pixels[box])
        known = detail_of(encode(part), laid.uv[box], laid.shading[box], texel)
        detail[box][changed[box]] = known[changed[box]]
    bare = before.bare_shading, before.bare_detail
    light, rest = update_bare_layers(bare, detail, laid.uv, laid.shading, texel, laid.basis, changed)
    return replace(laid, detail=detail, bare_shading=light, bare_detail=rest)


def layers_of(result: "Decomposition") -> OverlayLayers:
    """Return what is kept of a decomposition."""
    return OverlayLayers(
        result.uv,
        result.shading,
        result.detail,
        *find_bare_layers(result.detail, result.uv, result.shading, result.texel, result.basis),
        result.coverage,
        result.texel.pixels,
        result.basis,
        result.lattice,
        result.explained,
        result.found,
    )


def vertices_of(document: Document, layers: OverlayLayers) -> LatticeVertices:
    """Return the lattice that was found, for the artist to correct."""
    places = places_from_pixels(document.size_px, layers.lattice.frames.points)
    return LatticeVertices(layers.lattice.keys.astype(np.float64), places)
