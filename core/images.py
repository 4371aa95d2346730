"""Pictures and masks: reading, writing and what is kept of a file.

Read is whatever OpenImageIO knows; written are PNG, TIFF, EXR, JPEG and WebP. What happens to the special cases:

- EXIF orientation is applied to the pixels and reset. Other EXIF, IPTC and XMP entries and the ICC profile are kept;
  colours are not converted. (ISO speed is lost in TIFF, and so is a grey profile in WebP, which has no grey.)
- Palettes are expanded. CMYK becomes RGB, its profile goes. Of files with other channel sets red, green, blue and alpha
  are taken by name, else the first channels. Of files with several pictures the first is taken, of EXR the data window.
- Alpha is straight, as in PNG. Files that hold premultiplied colours (EXR, some TIFF) are divided on reading, EXR is
  multiplied on writing, so that a colour without any alpha is lost there.
- Float pictures are linear light; NaN becomes 0, infinities the largest finite number.
- Depth: PNG and TIFF keep 8 and 16 bits, TIFF and EXR keep float. A float picture becomes 16-bit PNG; JPEG and WebP are
  8-bit; an integer picture becomes linear light in EXR.
- JPEG has no alpha: the picture is laid on white, in linear light.
"""

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import OpenImageIO

from core import color, webp_exif
from core.arrays import Bytes, InputError, Pixels, readonly
from core.files import atomic_file

_FORMATS = {
    ".png": "png",
    ".tif": "tiff",
    ".tiff": "tiff",
    ".exr": "openexr",
    ".jpg": "jpeg",
    ".jpeg": "jpeg",
    ".webp": "webp",
}
SUFFIXES = tuple(_FORMATS)
"""Endings of the formats that `save` writes."""


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


def load(path: Path | str) -> Image:
    """Read the picture `path`.

    Raises
    ------
    InputError
        If the file is missing, not an image, or cut short.
    """
    path = Path(path)
    _check_readable(path)
    wish = OpenImageIO.ImageSpec()
    wish.attribute("oiio:UnassociatedAlpha", 1)
    source = OpenImageIO.ImageInput.open(str(path), wish)
    fault = OpenImageIO.geterror()
    if source is None:
        raise InputError(f"{path}: {_open_fault(fault)}")
    try:
        spec = source.spec()
        pixels = source.read_image(0, 0, 0, spec.nchannels, _reading_depth(spec))
        fault = source.geterror()
    finally:
        source.close()
    if pixels is None or "remature end" in fault:
        raise InputError(f"{path}: the image is damaged or cut short")
    if source.format_name() == "webp":
        spec = _with_exif(spec, path)
    return _image_from_file(np.asarray(pixels), spec)


def save(image: Image, path: Path | str, *, quality: int = 95) -> None:
    """Write `image` to `path` in the format that its ending names; it appears whole or not at all.

    `quality`, 1 to 100, is that of JPEG and WebP (100: WebP is lossless).

    Raises
    ------
    InputError
        If the ending is unknown, the format cannot hold the picture, or the file cannot be written.
    """
    path = Path(path)
    with atomic_file(path) as place:
        write(image, place, named=path, quality=quality)


def write(image: Image, place: Path, *, named: Path, quality: int = 95) -> None:
    """Write `image` to `place` at once, as `save` does to `named`; faults name that."""
    check_writable_format(named)
    if not 1 <= quality <= 100:
        raise InputError(f"quality {quality}: not from 1 to 100")
    _write(_fit_to_format(image, named.suffix.lower()), place, named, quality=quality)


def check_writable_format(path: Path) -> None:
    """Raise `InputError` if `save` cannot write a file with the ending of `path`."""
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: unknown picture format {path.suffix!r}; use one of {', '.join(SUFFIXES)}")


def load_mask(path: Path | str, size: tuple[int, int]) -> Bytes:
    """Read a mask for a picture of `size`, (H, W): (H, W) uint8, over 127 is a feature.

    Colours count by their luma (Rec. 601), alpha not at all. Raises `InputError` as `load` does, and for another size.
    """
    image = load(path)
    if image.pixels.shape[:2] != tuple(size):
        raise InputError(
            f"{path}: the mask has {image.width_px}x{image.height_px} pixels, the image {size[1]}x{size[0]}"
        )
    colors = image.pixels[..., : color.color_channels(image.channels)]
    levels = colors if colors.dtype == np.uint8 else color.quantise(color.unit(colors), np.uint8)
    grey = (
        levels[..., 0] if levels.shape[2] == 1 else np.rint(levels @ np.array([0.299, 0.587, 0.114])).astype(np.uint8)
    )
    return readonly(grey)


def _check_readable(path: Path) -> None:
    """Name what keeps `path` from being opened at all."""
    try:
        if path.is_dir():
            raise InputError(f"{path}: is a folder, not an image")
        with path.open("rb") as file:
            if not file.read(1):
                raise InputError(f"{path}: the file is empty")
    except OSError as fault:
        raise InputError(f"{path}: {(fault.strerror or str(fault)).lower()}") from fault


def _open_fault(fault: str) -> str:
    """Say in one line why OpenImageIO cannot open a file."""
    return "not an image of a known format" if "format reader" in fault else "not an image, damaged or cut short"


def _with_exif(spec: OpenImageIO.ImageSpec, path: Path) -> OpenImageIO.ImageSpec:
    """Return the description of the WebP file `path` with its EXIF entries."""
    entries = webp_exif.read_exif(path)
    for entry in entries.extra_attribs if entries is not None else ():
        if not entry.name.startswith(_STRUCTURE):
            spec.attribute(entry.name, entry.type, entry.value)
    return spec


def _reading_depth(spec: OpenImageIO.ImageSpec) -> Any:
    """Return the depth to read at: 8 and 16 bits as stored, all else as float."""
    kept = {"uint8": OpenImageIO.UINT8, "uint16": OpenImageIO.UINT16}
    return kept.get(str(spec.format), OpenImageIO.FLOAT)


def _image_from_file(pixels: Pixels, spec: OpenImageIO.ImageSpec) -> Image:
    """Bring what a file held into the one form that `Image` has."""
    linear = pixels.dtype == np.float32
    pixels = _take_channels(pixels, spec)
    if linear:
        pixels = np.nan_to_num(pixels, copy=False, nan=0.0)
    if pixels.shape[2] in (2, 4) and not spec.get_int_attribute("oiio:UnassociatedAlpha"):
        pixels = color.quantise(color.unpremultiply(color.unit(pixels)), pixels.dtype)
    pixels = upright(pixels, spec.get_int_attribute("Orientation", 1))
    return Image(
        readonly(np.ascontiguousarray(pixels)), linear, _profile(spec, pixels.shape[2]), _kept_attributes(spec)
    )


def _take_channels(pixels: Pixels, spec: OpenImageIO.ImageSpec) -> Pixels:
    """Return the channels R, G, B and A if they are named so, else the first ones."""
    names = list(spec.channelnames)
    rgb = [names.index(name) for name in "RGB" if name in names]
    alpha = [names.index("A")] if "A" in names else [spec.alpha_channel] if spec.alpha_channel >= 0 else []
    if len(rgb) < 3:
        plain = [i for i in range(len(names)) if i not in alpha]
        rgb = plain[:3] if len(plain) >= 3 else plain[:1] or alpha
        alpha = [i for i in alpha if i not in rgb]
    chosen = rgb + alpha
    return pixels if chosen == list(range(pixels.shape[2])) else pixels[..., chosen]


_UPRIGHT: dict[int, Callable[[Pixels], Pixels]] = {
    2: lambda p: p[:, ::-1],
    3: lambda p: p[::-1, ::-1],
    4: lambda p: p[::-1],
    5: lambda p: p.swapaxes(0, 1),
    6: lambda p: p[::-1].swapaxes(0, 1),
    7: lambda p: p[::-1, ::-1].swapaxes(0, 1),
    8: lambda p: p[:, ::-1].swapaxes(0, 1),
}


def upright(pixels: Pixels, orientation: int) -> Pixels:
    """Return `pixels` turned and mirrored as the EXIF orientation 1 to 8 says; other numbers change nothing."""
    turn = _UPRIGHT.get(orientation)
    return pixels if turn is None else turn(pixels)


_STRUCTURE = ("ICCProfile", "oiio:", "png:", "tiff:", "jpeg:", "openexr:", "webp:", "gif:", "thumbnail", "screenWindow")
_SHORT = {"uint8", "uint16", "int16", "uint"}
_STRUCTURE_NAMES = {"Orientation", "compression", "planarconfig", "Exif:PixelXDimension", "Exif:PixelYDimension"}


def _kept_attributes(spec: OpenImageIO.ImageSpec) -> tuple[Attribute, ...]:
    """Return the entries that describe the picture rather than the layout of its file."""
    return tuple(
        Attribute(entry.name, str(entry.type), entry.value)
        for entry in spec.extra_attribs
        if not entry.name.startswith(_STRUCTURE) and entry.name not in _STRUCTURE_NAMES
    )


def _profile(spec: OpenImageIO.ImageSpec, channels: int) -> bytes | None:
    """Return the ICC profile if it is whole and fits grey or RGB pixels."""
    value = spec.getattribute("ICCProfile")
    return usable_profile(None if value is None else np.asarray(value, np.uint8).tobytes(), channels)


def usable_profile(icc: bytes | None, channels: int) -> bytes | None:
    """Return `icc` if it is an ICC profile for `channels` channels, else None (a damaged one stops PNG writers)."""
    if icc is None or len(icc) < 132 or icc[36:40] != b"acsp" or int.from_bytes(icc[:4], "big") != len(icc):
        return None
    space = b"GRAY" if channels <= 2 else b"RGB "
    return icc if icc[16:20] == space else None


def _fit_to_format(image: Image, suffix: str) -> Image:
    """Return `image` with the depth and channels that the format of `suffix` can hold."""
    pixels, linear = image.pixels, image.linear
    if suffix in (".jpg", ".jpeg"):
        if image.has_alpha:
            pixels = _on_white(image)
        elif linear or pixels.dtype != np.uint8:
            pixels = _restored(image, np.uint8, linear=False)
        linear = False
    elif suffix == ".webp":
        pixels = pixels if pixels.dtype == np.uint8 else _restored(image, np.uint8, linear=False)
        if image.channels <= 2:
            pixels = np.concatenate([np.repeat(pixels[..., :1], 3, axis=2), pixels[..., 1:]], axis=2)
        linear = False
    elif suffix == ".png" and pixels.dtype == np.float32:
        pixels, linear = _restored(image, np.uint16, linear=False), False
    elif suffix == ".exr" and not (linear and pixels.dtype == np.float32):
        pixels, linear = _restored(image, np.float32, linear=True), True
    return image if pixels is image.pixels else replace(image, pixels=pixels, linear=linear)


def _restored(image: Image, depth: Any, *, linear: bool) -> Pixels:
    """Return the pixels at another depth; the transfer function is applied only where `linear` differs."""
    if linear == image.linear:
        return color.quantise(color.unit(image.pixels), depth)
    return color.stored(color.linear_light(image.pixels, linear=image.linear), depth=depth, linear=linear)


def _on_white(image: Image) -> Pixels:
    """Return the 8-bit picture on white, by bands of rows, since float copies of large pictures are larger still."""
    bands = []
    for top in range(0, image.height_px, 256):
        light = color.linear_light(image.pixels[top : top + 256], linear=image.linear)
        bands.append(color.stored(color.over(light, 1.0), depth=np.uint8, linear=False))
    return np.concatenate(bands)


def _write(image: Image, place: Path, path: Path, *, quality: int) -> None:
    """Write `image`, which fits the format, to `place`; faults name `path`."""
    pixels = image.pixels
    if image.has_alpha and path.suffix.lower() == ".exr":
        pixels = color.premultiply(pixels)
    suffix = path.suffix.lower()
    sink = OpenImageIO.ImageOutput.create(_FORMATS[suffix])
    if sink is None:
        raise InputError(f"{path}: {_first_line(OpenImageIO.geterror())}")
    spec = _spec(image, suffix, quality)
    with _staged(place, pixels.nbytes + len(image.icc or b"")) as name:
        try:
            done = sink.open(name, spec) and sink.write_image(pixels)
            fault = sink.geterror()
        finally:
            closed = sink.close()
        if not (done and closed):
            raise InputError(f"{path}: cannot be written: {_first_line(fault or sink.geterror())}")
    if suffix == ".webp" and image.metadata:
        webp_exif.add_exif(place, spec)


@contextmanager
def _staged(place: Path, size_bytes: int) -> Iterator[str]:
    """Yield the name of a file in memory whose contents then go to `place`.

    The libraries behind OpenImageIO write to a full disk in silence, or end the process; Python says what is wrong.
    `size_bytes`, about what the file may need, is refused beforehand if no file may be as large. Where the system has
    no such files, `place` itself is yielded.
    """
    if not hasattr(os, "memfd_create"):
        yield str(place)
        return
    with os.fdopen(os.memfd_create("picture"), "rb+") as memory:
        memory.truncate(size_bytes + size_bytes // 20 + 65_536)
        memory.truncate(0)
        yield f"/proc/self/fd/{memory.fileno()}"
        memory.seek(0)
        with place.open("wb") as file:
            shutil.copyfileobj(memory, file, 1 << 20)


def _spec(image: Image, suffix: str, quality: int) -> OpenImageIO.ImageSpec:
    """Return OpenImageIO's description of the file to write."""
    spec = OpenImageIO.ImageSpec(
        image.width_px, image.height_px, image.channels, str(image.pixels.dtype).replace("32", "")
    )
    for name, kind, value in image.metadata:
        # Short integers are left out of EXIF by OpenImageIO, plain ones are not.
        spec.attribute(name, OpenImageIO.TypeDesc("int" if kind in _SHORT else kind), value)
    profile = usable_profile(image.icc, image.channels)
    if profile is not None:
        spec.attribute("ICCProfile", OpenImageIO.TypeDesc(f"uint8[{len(profile)}]"), np.frombuffer(profile, np.uint8))
    if image.has_alpha:
        spec.channelnames = ("Y", "A") if image.channels == 2 else tuple("RGBA")
        spec.alpha_channel = image.channels - 1
        spec.attribute("oiio:UnassociatedAlpha", int(suffix != ".exr"))
    if suffix in (".jpg", ".jpeg", ".webp"):
        kind = (
            "lossless"
            if suffix == ".webp" and quality == 100
            else f"{'webp' if suffix == '.webp' else 'jpeg'}:{quality}"
        )
        spec.attribute("compression", kind)
    if suffix in (".jpg", ".jpeg"):
        spec.attribute("jpeg:subsampling", "4:4:4" if quality >= 90 else "4:2:0")
    return spec


def _first_line(fault: str) -> str:
    return (fault.strip().splitlines() or ["unknown fault"])[0]
