"""A new texture on the cloth of a photo: plain data."""

from dataclasses import dataclass
from typing import Protocol

from core.arrays import Floats, Singles
from core.imaging.images import Image
from core.overlay.composition import Placement

PLAIN = Placement()


class ClothParts(Protocol):
    """What laying a new texture needs of a decomposition; NaN where there is no cloth."""

    @property
    def uv(self) -> Singles:
        """(H, W, 2), texels."""

    @property
    def shading(self) -> Singles:
        """(H, W) or (H, W, 3), Wp."""

    @property
    def detail(self) -> Singles:
        """(H, W, 3), HF."""

    @property
    def coverage(self) -> Singles:
        """(H, W), 0 to 1."""

    @property
    def basis(self) -> Floats:
        """(2, 2), pixels of undeformed cloth a texel."""

    @property
    def middle(self) -> Floats:
        """(2,), texels, what a texture is turned and scaled about."""


@dataclass(frozen=True, eq=False)
class OverlayParameters:
    """A texture on the cloth of a photo."""

    parts: ClothParts
    texture: Image
    placement: Placement = PLAIN
    detail: float = 1.0
    """Share of the detail, alpha."""
    shading: float = 1.0
    """Contrast of the shading."""

    def looks_like(self, other: "OverlayParameters | None") -> bool:
        """Return whether `other` shows the same."""
        return (
            other is not None
            and self.parts is other.parts
            and self.texture is other.texture
            and (self.placement, self.detail, self.shading) == (other.placement, other.detail, other.shading)
        )
