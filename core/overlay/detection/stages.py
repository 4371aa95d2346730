"""What a running decomposition can show."""

from dataclasses import dataclass

from core.arrays import Floats, Points
from core.overlay.detection.lattice import Lattice
from core.overlay.texel import Texel


@dataclass(frozen=True)
class Stage:
    """What is known so far, at the working size; the preview of a step."""

    name: str
    """"keypoints", "seeds", "lattice", "mesh"."""
    lattice: Lattice | None = None
    texel: Texel | None = None
    uv: Floats | None = None
    """(H, W, 2), texels, NaN where not covered."""
    shape: tuple[int, int] | None = None
    """(H, W) of the picture at the working size, where they are known."""
    groups: tuple[Points, ...] = ()
    """Keypoints (n, 2) that look alike, pixels."""
    seeds: tuple[tuple[Points, Floats], ...] = ()
    """Places (2,) and lattice vectors (2, 2), columns, from which a lattice is tried, best first."""
