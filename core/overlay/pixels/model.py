"""What is known of a cloth at every pixel of its photo, from the registered mesh to the finished parts."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.mesh import ClothMesh
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.registration import ClothState
from core.overlay.texel import Texel


@dataclass(frozen=True)
class PixelModel:
    """A cloth of which every stage tells more; a stage returns another model and leaves its own as it is.

    What is of the photo's size (H, W) is NaN, or False, where there is no cloth.
    """

    cloth: FittedCloth
    """The cloth as it was fitted, on a photo 1 / `scale` of the size."""
    found: Fit
    photo: Floats | Singles
    """(H, W, 3), 0 to 1."""
    valid: Bools
    """(H, W), where cloth may be."""
    is_told: bool
    """Whether somebody said that there is cloth."""
    scale: int
    pieces: tuple[ClothState, ...]
    masks: tuple[Bools, ...]
    """The pixels that each piece explains, at the size of the fit."""
    uv: Singles
    """(H, W, 2), texels."""
    shading: Singles
    """(H, W), the light on a texel as the mesh knows it."""
    followed: Bools
    """(H, W), what was registered; the rest was carried on from there."""
    hidden: Bools
    """(h, w), which of every `scale`-th pixel shows another thing than the cloth."""
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
    def mesh(self) -> ClothMesh:
        """The mesh of the cloth over the photo."""
        return ClothMesh(self.photo.shape[:2], self.cloth.mesh.cell * self.scale)

    @property
    def basis(self) -> Floats:
        """S (2, 2), pixels of the undeformed cloth a texel."""
        return np.asarray(self.cloth.basis * self.scale, np.float64)


def begin(
    cloth: FittedCloth, found: Fit, photo: Floats | Singles, valid: Bools, scale: int, *, is_told: bool
) -> PixelModel:
    """Return what the registration alone tells: each piece has its own cells, and no pixel is laid yet."""
    shape = photo.shape[:2]
    unknown, nowhere = np.float32(np.nan), np.False_
    return PixelModel(
        cloth=cloth,
        found=found,
        photo=photo,
        valid=valid,
        is_told=is_told,
        scale=scale,
        pieces=found.pieces,
        masks=tuple(cloth.mesh.pixels_of(piece.cells) & cloth.valid for piece in found.pieces),
        # Views of one number: nothing is kept for what is not known.
        uv=np.broadcast_to(unknown, (*shape, 2)),
        shading=np.broadcast_to(unknown, shape),
        followed=np.broadcast_to(nowhere, shape),
        hidden=np.broadcast_to(nowhere, cloth.valid.shape),
        texel=found.texel,
        outline=np.broadcast_to(nowhere, shape),
        light=np.broadcast_to(unknown, (*shape, 1)),
        texture=np.broadcast_to(np.float32(0), (*shape, 3)),
        coverage=np.broadcast_to(np.float32(0), shape),
    )
