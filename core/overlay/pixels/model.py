"""What is known of a cloth at every pixel of its photo, from the registered mesh to the finished parts."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.filters.shrinking import scale_between, shrunk_mask
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.registration import ClothState
from core.overlay.texel import Texel


@dataclass(frozen=True)
class PixelModel:
    """A cloth of which every stage tells more; a stage returns another model and leaves its own as it is.

    What is of the photo's size (H, W) is NaN, or False, where there is no cloth.
    """

    cloth: FittedCloth
    """The cloth as it was fitted."""
    found: Fit
    own_photo: Floats | Singles
    """The photo at its own size, 0 to 1."""
    own_valid: Bools
    """Where cloth may be, at that size."""
    photo: Floats | Singles
    """(H, W, 3), the photo as it was searched, up to the stage that takes the cloth to its own size."""
    valid: Bools
    """(H, W), where cloth may be."""
    is_told: bool
    """Whether somebody said that there is cloth."""
    pieces: tuple[ClothState, ...]
    masks: tuple[Bools, ...]
    """The pixels that each piece explains, of the searched photo."""
    uv: Singles
    """(H, W, 2), texels."""
    shading: Singles
    """(H, W), the light on a texel as the mesh knows it."""
    followed: Bools
    """(H, W), what was registered; the rest was carried on from there."""
    hidden: Bools
    """(h, w), which pixels of the searched photo show another thing than the cloth."""
    texel: Texel
    outline: Bools
    """(H, W), the cloth without the soft pixels at its border."""
    light: Singles
    """(H, W, 1) or (H, W, 3), the factor Wp."""
    texture: Singles
    """(H, W, 3), T(Wg), 0 outside."""
    coverage: Singles
    """(H, W), the share of cloth in each pixel."""

    @property
    def modelled(self) -> Singles:
        """Wp T(Wg) (H, W, 3), 0 outside; computed as where the layers are read from a file, to the bit."""
        return self.modelled_at(np.s_[:])

    def modelled_at(self, where: Any) -> Singles:
        """Return Wp T(Wg) at some of the pixels, by slices or a mask (H, W); all of a large photo's is much memory."""
        light = self.light[where]
        modelled: Singles = self.texture[where] * light
        modelled[np.isnan(light[..., 0])] = 0
        return modelled

    @property
    def inside(self) -> Bools:
        """Pixels (H, W) that are cloth so far."""
        return np.asarray(np.isfinite(self.shading), np.bool_)

    @property
    def has_cloth(self) -> bool:
        """Whether any pixel is."""
        return bool(self.inside.any())

    @property
    def scale(self) -> int:
        """How much larger the photo is than the one that was searched."""
        return scale_between(len(self.valid), len(self.cloth.valid))

    @property
    def as_searched(self) -> "PixelModel":
        """The model, not yet at the photo's own size, as one of the photo that was searched."""
        return replace(self, own_photo=self.photo, own_valid=self.valid)

    @property
    def basis(self) -> Floats:
        """S (2, 2), pixels of the undeformed cloth a texel."""
        return np.asarray(self.cloth.basis * self.scale, np.float64)


def begin(cloth: FittedCloth, found: Fit, photo: Floats | Singles, valid: Bools, *, is_told: bool) -> PixelModel:
    """Return what the registration alone tells: each piece has its own cells, and no pixel is laid yet.

    `photo` and `valid` are of the photo's own size, (H, W) or larger.
    """
    shape = cloth.valid.shape
    scale = scale_between(len(valid), len(cloth.valid))
    unknown, nowhere = np.float32(np.nan), np.False_
    return PixelModel(
        cloth=cloth,
        found=found,
        own_photo=photo,
        own_valid=valid,
        photo=photo if scale == 1 else cloth.photo,
        valid=shrunk_mask(valid, scale),
        is_told=is_told,
        pieces=found.pieces,
        masks=tuple(cloth.mesh.pixels_of(piece.cells) & cloth.valid for piece in found.pieces),
        # Views of one number: nothing is kept for what is not known.
        uv=np.broadcast_to(unknown, (*shape, 2)),
        shading=np.broadcast_to(unknown, shape),
        followed=np.broadcast_to(nowhere, shape),
        hidden=np.broadcast_to(nowhere, shape),
        texel=found.texel,
        outline=np.broadcast_to(nowhere, shape),
        light=np.broadcast_to(unknown, (*shape, 1)),
        texture=np.broadcast_to(np.float32(0), (*shape, 3)),
        coverage=np.broadcast_to(np.float32(0), shape),
    )
