"""Writing pictures through OpenImageIO; `core.images` says what each format can hold."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO

from core import color, webp_exif
from core.arrays import InputError, Pixels
from core.files import atomic_file
from core.image import Image, usable_profile

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
BAND_ROWS = 64
PNG_LEVEL = 3
"""Of zlib: takes half the time that its usual level takes, for a twentieth more bytes."""
_SHORT = {"uint8", "uint16", "int16", "uint"}


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
    _write(image, place, named, quality=quality)


def check_writable_format(path: Path) -> None:
    """Raise `InputError` if `save` cannot write a file with the ending of `path`."""
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: unknown picture format {path.suffix!r}; use one of {', '.join(SUFFIXES)}")


def _bands(image: Image, suffix: str) -> Iterator[Image]:
    """Yield `image` in bands of rows, as the format of `suffix` can hold it; copies of the whole would be large."""
    for top in range(0, image.height_px, BAND_ROWS):
        yield _fit_to_format(image.with_pixels(image.pixels[top : top + BAND_ROWS]), suffix)


def _fit_to_format(image: Image, suffix: str) -> Image:
    """Return `image` with the depth and channels that the format of `suffix` can hold."""
    pixels, linear = image.pixels, image.linear
    if suffix in (".jpg", ".jpeg"):
        if image.has_alpha:
            light = color.linear_light(pixels, linear=linear)
            pixels = color.stored(color.over(light, 1.0), depth=np.uint8, linear=False)
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
    elif suffix == ".exr":
        if not (linear and pixels.dtype == np.float32):
            pixels, linear = _restored(image, np.float32, linear=True), True
        pixels = color.premultiply(pixels)
    return image if pixels is image.pixels else replace(image, pixels=pixels, linear=linear)


def _restored(image: Image, depth: Any, *, linear: bool) -> Pixels:
    """Return the pixels at another depth; the transfer function is applied only where `linear` differs."""
    if linear == image.linear:
        return color.quantise(color.unit(image.pixels), depth)
    return color.stored(color.linear_light(image.pixels, linear=image.linear), depth=depth, linear=linear)


def _write(image: Image, place: Path, path: Path, *, quality: int) -> None:
    """Write `image` to `place`; faults name `path`."""
    suffix = path.suffix.lower()
    sink = OpenImageIO.ImageOutput.create(_FORMATS[suffix])
    if sink is None:
        raise InputError(f"{path}: {_first_line(OpenImageIO.geterror())}")
    sample = _fit_to_format(image.with_pixels(image.pixels[:1, :1]), suffix)
    spec = _spec(sample, image.size_px, suffix, quality)
    with _staged(place, spec.image_bytes() + len(image.icc or b"")) as name:
        try:
            done = sink.open(name, spec) and _write_bands(image, suffix, sink)
            fault = sink.geterror()
        finally:
            closed = sink.close()
        if not (done and closed):
            raise InputError(f"{path}: cannot be written: {_first_line(fault or sink.geterror())}")
    if suffix == ".webp" and image.metadata:
        webp_exif.add_exif(place, spec)


def _write_bands(image: Image, suffix: str, sink: OpenImageIO.ImageOutput) -> bool:
    """Write the rows of `image` to the open `sink`; return whether all went well."""
    row = 0
    for band in _bands(image, suffix):
        if not sink.write_scanlines(row, row + band.height_px, 0, band.pixels):
            return False
        row += band.height_px
    return True


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


def _spec(image: Image, size_px: tuple[int, int], suffix: str, quality: int) -> OpenImageIO.ImageSpec:
    """Return OpenImageIO's description of a file of `size_px`, with samples and channels as in `image`."""
    spec = OpenImageIO.ImageSpec(*size_px, image.channels, str(image.pixels.dtype).replace("32", ""))
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
    if suffix in (".exr", ".tif", ".tiff") and spec.getattribute("DateTime") is None:
        # An empty date is left out; without one, OpenImageIO writes the present time, and no two files are alike.
        spec.attribute("DateTime", "")
    if suffix in (".jpg", ".jpeg", ".webp"):
        kind = (
            "lossless"
            if suffix == ".webp" and quality == 100
            else f"{'webp' if suffix == '.webp' else 'jpeg'}:{quality}"
        )
        spec.attribute("compression", kind)
    if suffix == ".png":
        spec.attribute("png:compressionLevel", PNG_LEVEL)
    if suffix in (".jpg", ".jpeg"):
        spec.attribute("jpeg:subsampling", "4:4:4" if quality >= 90 else "4:2:0")
    return spec


def _first_line(fault: str) -> str:
    return (fault.strip().splitlines() or ["unknown fault"])[0]
