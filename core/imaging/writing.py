"""Writing pictures through OpenImageIO; `core.imaging.images` says what each format can hold."""

import os
import shutil
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import OpenImageIO

from core.arrays import InputError, Pixels
from core.files.atomic import atomic_file
from core.files.litter import scratch_folder
from core.imaging import color, webp_exif
from core.imaging.image import Image, usable_profile
from core.imaging.metadata import put, sift
from core.imaging.oiio_faults import take_fault
from core.notices import notice

_FORMATS = {
    ".png": "png",
    ".tif": "tiff",
    ".tiff": "tiff",
    ".exr": "openexr",
    ".jpg": "jpeg",
    ".jpeg": "jpeg",
    ".webp": "webp",
    ".jxl": "jpegxl",
}
SUFFIXES = tuple(_FORMATS)
"""Endings of the formats that `save` writes."""
BAND_ROWS = 64
PNG_LEVEL, PNG_FILTER = 2, 16
"""Of zlib, and that of differences to the left in every row. Of photographs the files are as large as with the best
filter of each row and level 3, to a twentieth, in two fifths of the time."""


def save(image: Image, path: Path | str, *, quality: int = 95) -> None:
    """Write `image` to `path` in the format that its ending names; it appears whole or not at all.

    `quality`, 1 to 100, is that of JPEG, WebP and JPEG XL (100: the latter two are lossless).

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
    with writing_rows(image, image.size_px, place, named=named, quality=quality) as append:
        append(image.pixels)


@contextmanager
def writing_rows(
    sample: Image, size_px: tuple[int, int], place: Path, *, named: Path, quality: int = 95
) -> Iterator[Callable[[Pixels], None]]:
    """Yield what takes the rows of a picture of `size_px` from the top down: `place` gets the file that `write` makes.

    `sample` is a picture of any size with the depth, channels, profile and metadata of that one. Pieces (h, W, C) of
    any height do; all but the last of a multiple of `BAND_ROWS` are compressed alike. An exception that leaves the
    block leaves `place` unfinished. WebP is held in memory, as 8 bits, until all rows are there.
    """
    check_writable_format(named)
    if not 1 <= quality <= 100:
        raise InputError(f"quality {quality}: not from 1 to 100")
    suffix = named.suffix.lower()
    sink = OpenImageIO.ImageOutput.create(_FORMATS[suffix])
    if sink is None:
        raise InputError(f"{named}: {_first_line(take_fault(OpenImageIO))}")
    fitted = _fit_to_format(_with_what_fits(sample, named, quality).with_pixels(sample.pixels[:1, :1]), suffix)
    spec = _spec(fitted, size_px, suffix, quality)
    with _stage(place, spec.image_bytes() + len(sample.icc or b"")) as name:
        rows = _Rows(sink, name, spec, sample, suffix, named)
        try:
            yield rows.append
            rows.finish()
        finally:
            sink.close()
    if suffix == ".webp" and fitted.metadata:
        webp_exif.add_exif(place, spec)


def check_writable_format(path: Path) -> None:
    """Raise `InputError` if `save` cannot write a file with the ending of `path`."""
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: unknown picture format {path.suffix!r}; use one of {', '.join(SUFFIXES)}")


@dataclass
class _Rows:
    """The rows of a picture like `sample` on their way to `sink`, which is opened for the first ones."""

    sink: OpenImageIO.ImageOutput
    place: str
    spec: OpenImageIO.ImageSpec
    sample: Image
    suffix: str
    named: Path
    count: int = 0
    written: int = 0
    waiting: list[Pixels] = field(default_factory=list)

    def append(self, pixels: Pixels) -> None:
        """Write rows below those that are written, in bands, since copies of many rows would be large."""
        self.count += len(pixels)
        if self.count > self.spec.height:
            raise InputError(f"{self.named}: cannot be written: more than {self.spec.height} rows")
        for top in range(0, len(pixels), BAND_ROWS):
            band = _fit_to_format(self.sample.with_pixels(pixels[top : top + BAND_ROWS]), self.suffix)
            self.waiting.append(band.pixels)
            if self.suffix != ".webp":  # which is compressed as a whole, however much of it there is when it is closed
                self._write()

    def finish(self) -> None:
        """Complete the file; raise `InputError` if rows are missing."""
        if self.count < self.spec.height:
            raise InputError(f"{self.named}: cannot be written: {self.count} of {self.spec.height} rows")
        self._write()
        self._expect(self.sink.close())

    def _write(self) -> None:
        if self.written == 0:
            self._expect(self.sink.open(self.place, self.spec))
        while self.waiting:
            pixels = self.waiting.pop(0)
            begin, self.written = self.written, self.written + len(pixels)
            self._expect(self.sink.write_scanlines(begin, self.written, 0, pixels))

    def _expect(self, done: bool) -> None:
        """Raise `InputError` with the fault of the sink unless a step is `done`."""
        if not done:
            raise InputError(f"{self.named}: cannot be written: {_first_line(take_fault(self.sink))}")


def _fit_to_format(image: Image, suffix: str) -> Image:
    """Return `image` with the depth and channels that the format of `suffix` can hold."""
    pixels, linear = image.pixels, image.linear
    if suffix in (".jpg", ".jpeg"):
        if image.has_alpha:
            pixels = _over_white(pixels, linear=linear)
        elif linear or pixels.dtype != np.uint8:
            pixels = _restore(image, np.uint8, linear=False)
        linear = False
    elif suffix == ".webp":
        pixels = pixels if pixels.dtype == np.uint8 else _restore(image, np.uint8, linear=False)
        if image.channels <= 2:
            pixels = np.concatenate([np.repeat(pixels[..., :1], 3, axis=2), pixels[..., 1:]], axis=2)
        linear = False
    elif suffix == ".jxl" and image.channels == 2:  # its writer knows no grey with alpha
        pixels = np.concatenate([np.repeat(pixels[..., :1], 3, axis=2), pixels[..., 1:]], axis=2)
    elif suffix == ".png" and pixels.dtype == np.float32:
        pixels, linear = _restore(image, np.uint16, linear=False), False
    elif suffix == ".exr":
        if not (linear and pixels.dtype == np.float32):
            pixels, linear = _restore(image, np.float32, linear=True), True
        pixels = color.premultiply(pixels)
    return image if pixels is image.pixels else replace(image, pixels=pixels, linear=linear)


def _over_white(pixels: Pixels, *, linear: bool) -> Pixels:
    """Return pixels with alpha (h, w, 2 or 4) over white, 8 bits a channel."""
    if pixels.dtype != np.uint8 or linear:
        return color.store(color.over(color.linear_light(pixels, linear=linear), 1.0), depth=np.uint8, linear=False)
    channels = pixels.shape[-1]
    alpha = color.take_channels(pixels, [channels - 1])
    colors = color.take_channels(pixels, range(channels - 1))
    clear = cv2.merge([np.where(alpha == 0, np.uint8(255), np.uint8(0))] * (channels - 1))
    shown = np.asarray(cv2.bitwise_or(colors, clear.reshape(colors.shape)))
    soft = np.flatnonzero((alpha > 0) & (alpha < 255))
    light = color.linear_light(pixels.reshape(-1, channels)[soft], linear=False)
    shown.reshape(-1, channels - 1)[soft] = color.store(color.over(light, 1.0), depth=np.uint8, linear=False)
    return shown.reshape(colors.shape)


def _restore(image: Image, depth: Any, *, linear: bool) -> Pixels:
    """Return the pixels at another depth; the transfer function is applied only where `linear` differs."""
    if linear == image.linear:
        return color.quantise(color.unit(image.pixels), depth)
    return color.store(color.linear_light(image.pixels, linear=image.linear), depth=depth, linear=linear)


@contextmanager
def _stage(place: Path, size_bytes: int) -> Iterator[str]:
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


def _with_what_fits(sample: Image, named: Path, quality: int) -> Image:
    """Return `sample` with the metadata that the format of `named` can hold; what is left out is a notice."""
    suffix = named.suffix.lower()
    pixel = _fit_to_format(sample.with_pixels(sample.pixels[:1, :1]), suffix)
    fits = lambda entries: _is_writable(replace(pixel, metadata=entries), suffix, quality)  # noqa: E731
    kept, dropped = sift(sample.metadata, fits)
    if not dropped:
        return sample
    notice(f"{named}: written without metadata that it cannot hold: {', '.join(entry.name for entry in dropped)}")
    return replace(sample, metadata=kept)


def _is_writable(pixel: Image, suffix: str, quality: int) -> bool:
    """Return whether a picture of one pixel, with the metadata of `pixel`, can be written and opened again."""
    if suffix == ".jxl" and pixel.metadata:  # OpenImageIO writes none
        return False
    spec = _spec(replace(pixel, metadata=()), (1, 1), suffix, quality)
    if not all(put(spec, entry) for entry in pixel.metadata):
        return False
    with scratch_folder() as folder:
        place = folder / f"pixel{suffix}"
        sink = OpenImageIO.ImageOutput.create(_FORMATS[suffix])
        if sink is None:
            return False
        try:
            written = sink.open(str(place), spec) and sink.write_image(pixel.pixels)
            if not (sink.close() and written):
                return False
            if suffix == ".webp":
                webp_exif.add_exif(place, spec)
            source = OpenImageIO.ImageInput.open(str(place))
            return source is not None and source.close()
        except (OSError, ValueError, RuntimeError, struct.error):
            return False
        finally:
            take_fault(sink)
            take_fault(OpenImageIO)


def _spec(image: Image, size_px: tuple[int, int], suffix: str, quality: int) -> OpenImageIO.ImageSpec:
    """Return OpenImageIO's description of a file of `size_px`, with samples and channels as in `image`."""
    spec = OpenImageIO.ImageSpec(*size_px, image.channels, str(image.pixels.dtype).replace("32", ""))
    for entry in image.metadata:
        put(spec, entry)
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
    if suffix == ".jxl":
        spec.attribute("compression", f"jpegxl:{quality}")
    if suffix == ".png":
        spec.attribute("png:compressionLevel", PNG_LEVEL)
        spec.attribute("png:filter", PNG_FILTER)
        # Colours are tagged by a profile alone: beside a gamma, libpng reads colour as grey by other weights.
        spec.attribute("oiio:ColorSpace", "unknown")
    if suffix in (".jpg", ".jpeg"):
        spec.attribute("jpeg:subsampling", "4:4:4" if quality >= 90 else "4:2:0")
    return spec


def _first_line(fault: str) -> str:
    return (fault.strip().splitlines() or ["unknown fault"])[0]
