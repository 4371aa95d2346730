"""A picture in memory: pixels, and what else its file held."""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from core.arrays import InputError, Pixels, readonly


class Attribute(NamedTuple):
    """One entry of a file's metadata, in OpenImageIO's naming: `Exif:ExposureTime`, `float`, 0.01."""

    name: str
    kind: str
    value: Any


@dataclass(frozen=True, eq=False)
class Image:
    """A picture: pixels, how they are to be read, and what else its file held."""

    pixels: Pixels
    """(H, W, C) read-only uint8, uint16 or float32; C: 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA; alpha is straight."""
    linear: bool = False
    """Whether the colours are linear light (float pictures) rather than sRGB."""
    icc: bytes | None = None
    metadata: tuple[Attribute, ...] = ()

    def __post_init__(self) -> None:
        pixels = self.pixels
        if pixels.ndim != 3 or not 1 <= pixels.shape[2] <= 4 or min(pixels.shape) < 1:
            raise InputError(f"image: pixels of shape {pixels.shape}, not (H, W, 1 to 4)")
        if pixels.dtype not in (np.uint8, np.uint16, np.float32):
            raise InputError(f"image: pixels of {pixels.dtype}, not uint8, uint16 or float32")
        if pixels.flags.writeable:
            object.__setattr__(self, "pixels", readonly(pixels))

    @property
    def height_px(self) -> int:
        """Number of rows."""
        return int(self.pixels.shape[0])

    @property
    def width_px(self) -> int:
        """Number of columns."""
        return int(self.pixels.shape[1])

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height."""
        return self.width_px, self.height_px

    @property
    def channels(self) -> int:
        """Number of channels, alpha included."""
        return int(self.pixels.shape[2])

    @property
    def has_alpha(self) -> bool:
        """Whether the last channel is alpha."""
        return self.channels in (2, 4)

    def with_pixels(self, pixels: Pixels) -> "Image":
        """Return the same picture with other pixels; profile and metadata stay."""
        return replace(self, pixels=pixels)


def usable_profile(icc: bytes | None, channels: int) -> bytes | None:
    """Return `icc` if it is an ICC profile for `channels` channels, else None (a damaged one stops PNG writers)."""
    if icc is None or len(icc) < 132 or icc[36:40] != b"acsp" or int.from_bytes(icc[:4], "big") != len(icc):
        return None
    space = b"GRAY" if channels <= 2 else b"RGB "
    return icc if icc[16:20] == space else None
