"""Reading pictures and masks through OpenImageIO; `core.imaging.images` says what becomes of the special cases."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO

from core.arrays import Bytes, InputError, Pixels, readonly
from core.files.faults import system_faults_named
from core.files.litter import scratch_folder
from core.files.text import legible
from core.imaging import color, set_aside, webp_exif
from core.imaging.hushed import hush
from core.imaging.image import Attribute, Image, usable_profile
from core.imaging.metadata import as_text, put
from core.imaging.oiio_faults import take_fault
from core.imaging.picture_bounds import TooLargeError, check_size
from core.imaging.png_chunks import is_broken_png
from core.imaging.set_aside import SetAside

BAND_ROWS = 256
LARGEST = 1e15
"""Floating pixels are held within this: what is computed of them, squares and their sums too, is finite in float32."""
_STRUCTURE = ("ICCProfile", "oiio:", "png:", "tiff:", "jpeg:", "openexr:", "webp:", "gif:", "thumbnail", "screenWindow")
_STRUCTURE_NAMES = {"Orientation", "compression", "planarconfig", "Exif:PixelXDimension", "Exif:PixelYDimension"}


def load(path: Path | str) -> Image:
    """Read the picture `path`.

    Raises
    ------
    InputError
        If the file is missing, not an image, cut short, or larger than `core.imaging.picture_bounds` allows; that is
        known before its pixels are read.
    """
    path = Path(path)
    _check_readable(path)
    if is_broken_png(path):
        raise InputError(f"{path}: the image is damaged or cut short")
    try:
        with _named_in_text(path) as name, hush():
            return _read(path, name)
    except UnicodeDecodeError:  # the file names its channels or entries with bytes that are no text
        raise InputError(f"{path}: the image is damaged or cut short") from None


@contextmanager
def _named_in_text(path: Path) -> Iterator[str]:
    """Yield a name of the file `path` that OpenImageIO takes: that of a link where its own is not UTF-8."""
    if legible(str(path)) == str(path):
        yield str(path)
        return
    with scratch_folder() as folder:
        link = folder / f"picture{legible(path.suffix)}"
        link.symlink_to(path.absolute())
        yield str(link)


def header_of(path: Path) -> tuple[tuple[int, int], int]:
    """Return the (width, height) and the bits of a sample of the picture `path` as `load` gives it, from its header.

    Raises `InputError` if the file is missing or not an image.
    """
    _check_readable(path)
    with _named_in_text(path) as name, hush():
        source = OpenImageIO.ImageInput.open(name)
        fault = take_fault(OpenImageIO)
        if source is None:
            raise _open_fault(path, fault)
        spec = source.spec()
        source.close()
    turned = spec.get_int_attribute("Orientation", 1) in range(5, 9)
    size = (spec.height, spec.width) if turned else (spec.width, spec.height)
    return size, {"uint8": 8, "uint16": 16}.get(str(spec.format), 32)


def _read(path: Path, name: str) -> Image:
    """Return the picture in a file that can be read; OpenImageIO is given its `name`."""
    wish = OpenImageIO.ImageSpec()
    wish.attribute("oiio:UnassociatedAlpha", 1)
    source = OpenImageIO.ImageInput.open(name, wish)
    fault = take_fault(OpenImageIO)
    if source is None:
        raise _open_fault(path, fault)
    if source.format_name() == "null":  # OpenImageIO's own, of black pictures, whatever the file
        raise InputError(f"{path}: not an image of a known format")
    try:
        spec, depth = source.spec(), _reading_depth(source.spec())
        check_size(
            (spec.width, spec.height), max(spec.depth, 1) * spec.nchannels * OpenImageIO.TypeDesc(depth).size(), path
        )
        pixels = _read_pixels(source, spec, depth)
        fault = take_fault(source)
    finally:
        source.close()
        _forget_faults(source)
    if pixels is None or "remature end" in fault:
        raise InputError(f"{path}: the image is damaged or cut short")
    if source.format_name() == "webp":
        spec = _with_exif(spec, path)
    if source.format_name() == "jpegxl":  # whose reader does not say that alpha is straight, and says colours twice
        spec.attribute("oiio:UnassociatedAlpha", 1)
        spec.erase_attribute("CICP")
    return _image_from_file(pixels, spec)


def _read_pixels(source: OpenImageIO.ImageInput, spec: OpenImageIO.ImageSpec, depth: Any) -> Pixels | None:
    """Return all pixels (h, w, C) of an open file, None if they cannot be read.

    Rows come in bands, since what the library reads it copies once more.
    """
    if spec.tile_width or spec.depth > 1:
        pixels = source.read_image(0, 0, 0, spec.nchannels, depth)
        return None if pixels is None else np.asarray(pixels)
    shape = spec.height, spec.width, spec.nchannels
    dtype = np.dtype({OpenImageIO.UINT8: np.uint8, OpenImageIO.UINT16: np.uint16}.get(depth, np.float32))
    aside = _set_aside(spec, shape, dtype)
    pixels = np.empty(shape if aside is None else (0, *shape[1:]), dtype)
    for top in range(0, spec.height, BAND_ROWS):
        bottom = min(top + BAND_ROWS, spec.height)
        band = source.read_scanlines(0, 0, spec.y + top, spec.y + bottom, spec.z, 0, spec.nchannels, depth)
        if band is None:
            if aside is not None:
                aside.close()
            return None
        rows = np.asarray(band).reshape(bottom - top, *shape[1:])
        if aside is None:
            pixels[top:bottom] = rows
        else:
            aside.append(rows)
    return pixels if aside is None else aside.pixels()


def _set_aside(spec: OpenImageIO.ImageSpec, shape: tuple[int, int, int], dtype: np.dtype[Any]) -> SetAside | None:
    """Return where the pixels of a very large picture go; None for others, and for those that are changed once read."""
    as_they_are = dtype.kind == "u" and shape[2] in (1, 3) and spec.get_int_attribute("Orientation", 1) == 1
    if not as_they_are or dtype.itemsize * shape[0] * shape[1] * shape[2] < set_aside.LARGE_BYTES:
        return None
    with suppress(OSError):  # no room, or no temporary folder: memory it is
        return SetAside(shape, dtype)
    return None


def load_mask(path: Path | str, size_px: tuple[int, int]) -> Bytes:
    """Read a mask for a picture with a width and height of `size_px`: (H, W) uint8, over 127 is a feature.

    Colours count by their luma (Rec. 601), alpha not at all. Raises `InputError` as `load` does, and for another size.
    """
    return mask_of(load(path), path, size_px)


def mask_of(image: Image, path: Path | str, size_px: tuple[int, int]) -> Bytes:
    """Return what `load_mask` makes of the picture `image`, which was read from `path`."""
    if image.size_px != size_px:
        raise InputError(
            f"{path}: the mask has {image.width_px}x{image.height_px} pixels, the image {size_px[0]}x{size_px[1]}"
        )
    colors = image.pixels[..., : color.color_channels(image.channels)]
    levels = colors if colors.dtype == np.uint8 else color.quantise(color.unit(colors), np.uint8)
    grey = (
        levels[..., 0] if levels.shape[2] == 1 else np.rint(levels @ np.array([0.299, 0.587, 0.114])).astype(np.uint8)
    )
    return readonly(grey)


def _forget_faults(source: OpenImageIO.ImageInput) -> None:
    """Take what OpenImageIO still has to say, which it would print at exit."""
    take_fault(source)
    take_fault(OpenImageIO)


def _check_readable(path: Path) -> None:
    """Name what keeps `path` from being opened at all."""
    with system_faults_named(path):
        if path.is_dir():
            raise InputError(f"{path}: is a folder, not an image")
        if path.exists() and not path.is_file():
            raise InputError(f"{path}: is a device or a pipe, not a file")
        with path.open("rb") as file:
            if not file.read(1):
                raise InputError(f"{path}: the file is empty")


def _open_fault(path: Path, fault: str) -> InputError:
    """Return in one line why OpenImageIO cannot open a file."""
    if "may not exceed" in fault or "limits:imagesize_MB" in fault:
        return TooLargeError(f"{path}: has more pixels than a picture may have, or the machine can hold")
    known = "not an image of a known format" if "format reader" in fault else "not an image, damaged or cut short"
    return InputError(f"{path}: {known}")


def _with_exif(spec: OpenImageIO.ImageSpec, path: Path) -> OpenImageIO.ImageSpec:
    """Return the description of the WebP file `path` with its EXIF entries."""
    entries = webp_exif.read_exif(path)
    for entry in entries.extra_attribs if entries is not None else ():
        if not entry.name.startswith(_STRUCTURE):
            put(spec, Attribute(entry.name, str(entry.type), entry.value))
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
        _bound(pixels)
    if pixels.shape[2] in (2, 4) and not spec.get_int_attribute("oiio:UnassociatedAlpha"):
        pixels = _straight(pixels)
    pixels = upright(pixels, spec.get_int_attribute("Orientation", 1))
    if pixels.flags.writeable:
        pixels = readonly(np.ascontiguousarray(pixels))
    return Image(pixels, linear, _profile(spec, pixels.shape[2]), _kept_attributes(spec))


def _bound(pixels: Pixels) -> None:
    """Hold floating `pixels` within `LARGEST`, in their place; what is no number becomes 0."""
    np.nan_to_num(pixels, copy=False, nan=0.0)
    np.clip(pixels, -LARGEST, LARGEST, out=pixels)


def _straight(pixels: Pixels) -> Pixels:
    """Return premultiplied `pixels` with straight alpha, in their place; floating ones within `LARGEST`."""
    for top in range(0, pixels.shape[0], BAND_ROWS):
        band = pixels[top : top + BAND_ROWS]
        with np.errstate(over="ignore"):
            straight = color.unpremultiply(color.unit(band))
        _bound(straight)
        band[:] = color.quantise(straight, pixels.dtype)
    return pixels


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


def _kept_attributes(spec: OpenImageIO.ImageSpec) -> tuple[Attribute, ...]:
    """Return the entries that describe the picture rather than the layout of its file."""
    return tuple(
        Attribute(as_text(entry.name), str(entry.type), as_text(entry.value))
        for entry in spec.extra_attribs
        if not entry.name.startswith(_STRUCTURE) and entry.name not in _STRUCTURE_NAMES
    )


def _profile(spec: OpenImageIO.ImageSpec, channels: int) -> bytes | None:
    """Return the ICC profile if it is whole and fits grey or RGB pixels."""
    value = spec.getattribute("ICCProfile")
    return usable_profile(None if value is None else np.asarray(value, np.uint8).tobytes(), channels)
