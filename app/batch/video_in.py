"""Frames of a video, read through PyAV at their own depth, with what a copy needs to be shown alike."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
from av.container import InputContainer
from av.video.format import VideoFormat
from av.video.frame import VideoFrame
from av.video.stream import VideoStream

from core.arrays import InputError, Pixels
from core.imaging.images import Image

UNSPECIFIED = 2
"""The code, in primaries, transfer function and matrix, of a file that does not say."""
_HD_ROWS = 720
_BT709, _SMPTE170M = 1, 5
LENIENT: dict[str, Any] = {} if int(av.__version__.split(".")[0]) >= 19 else {"metadata_errors": "replace"}
"""Text that is not UTF-8 is no fault; from PyAV 19 on it never is."""
_SWSCALE = {1: 1, 4: 4, 5: 5, 6: 5, 7: 7, 9: 9, 10: 9}
"""By the matrix's code in a file (ITU-T H.273), its code in libswscale."""


@dataclass(frozen=True)
class Tags:
    """What the numbers of a video mean as colours: codes of ITU-T H.273, and 1 for video range, 2 for full range."""

    primaries: int = UNSPECIFIED
    transfer: int = UNSPECIFIED
    matrix: int = UNSPECIFIED
    range: int = 0

    def swscale_matrix(self, height: int) -> int:
        """Return libswscale's code of the matrix; where the file does not say, BT.709 from 720 rows on."""
        return _SWSCALE.get(self.matrix, _BT709 if height >= _HD_ROWS else _SMPTE170M)

    @property
    def swscale_range(self) -> int:
        """Libswscale's code of the range; where the file does not say, video range."""
        return self.range or 1


UNTAGGED = Tags()


@dataclass(frozen=True)
class Clip:
    """What a video holds."""

    size_px: tuple[int, int]
    pts: tuple[int, ...]
    """When each frame is shown, in `time_base`, in order."""
    time_base: Fraction
    rate: Fraction
    tags: Tags
    bits: int
    """Of a sample: 8 or 16."""


def index(path: Path) -> Clip:
    """Return what the video `path` holds, from its packets, without decoding all of it.

    Raises `InputError` if the file is missing, no video, or has no frame.
    """
    with _open_up(path) as (container, stream):
        pts = sorted(packet.pts for packet in container.demux(stream) if packet.pts is not None and packet.size)
        if not pts or not stream.width:
            raise InputError(f"{path}: the video has no frames")
        context = stream.codec_context
        rate = stream.average_rate or stream.guessed_rate or Fraction(24)
        assert stream.time_base is not None
        tags = Tags(context.color_primaries, context.color_trc, context.colorspace, context.color_range)
        bits = 16 if context.format is not None and _is_deep(context.format) else 8
        return Clip((stream.width, stream.height), tuple(pts), stream.time_base, Fraction(rate), tags, bits)


def read_frames(path: Path, numbers: Sequence[int]) -> Iterator[tuple[int, Image | None]]:
    """Yield the frames of those ascending numbers, from 1 on; None for one that cannot be decoded."""
    clip = index(path)
    wanted = {clip.pts[number - 1]: number for number in numbers}
    waiting = list(numbers)
    with _open_up(path) as (container, stream):
        container.seek(clip.pts[waiting[0] - 1], stream=stream, backward=True)
        for frame in _decode(container, stream):
            number = wanted.get(frame.pts) if frame.pts is not None else None
            if number is None or number not in waiting:
                continue
            while waiting[0] < number:
                yield waiting.pop(0), None
            yield waiting.pop(0), None if frame.is_corrupt else _picture(frame)
            if not waiting:
                return
    for number in waiting:
        yield number, None


@contextmanager
def _open_up(path: Path) -> Iterator[tuple[InputContainer, VideoStream]]:
    try:
        container = av.open(str(path), **LENIENT)
    except av.FFmpegError as fault:
        known = path.exists() and not isinstance(fault, OSError)
        raise InputError(f"{path}: {'not a video' if known else (fault.strerror or str(fault)).lower()}") from None
    with container:
        if not container.streams.video:
            raise InputError(f"{path}: the video has no frames")
        yield container, container.streams.video[0]


def _decode(container: InputContainer, stream: VideoStream) -> Iterator[VideoFrame]:
    """Yield the frames that can be decoded, in the order in which they are shown."""
    packets = container.demux(stream)
    while True:
        try:
            packet = next(packets, None)
            if packet is None:
                return
            yield from (frame for frame in packet.decode() if isinstance(frame, VideoFrame))
        except av.InvalidDataError:
            continue


def _picture(frame: VideoFrame) -> Image:
    """Return a frame as RGB of 8 or, where it has more than 8 bits, of 16, with alpha where it has that."""
    deep, alpha = _is_deep(frame.format), any(component.is_alpha for component in frame.format.components)
    kind = ("rgba64le" if alpha else "rgb48le") if deep else ("rgba" if alpha else "rgb24")
    tags = Tags(frame.color_primaries, frame.color_trc, frame.colorspace, frame.color_range)
    plain = frame.reformat(
        format=kind,
        src_colorspace=tags.swscale_matrix(frame.height),
        src_color_range=2 if frame.format.is_rgb else tags.swscale_range,
        dst_color_range=2,
        interpolation=_EXACT,
        threads=1,
    )
    pixels: Pixels = np.ascontiguousarray(plain.to_ndarray())
    return Image(pixels)


def _is_deep(layout: VideoFormat) -> bool:
    """Return whether samples have more than 8 bits."""
    return max(component.bits for component in layout.components) > 8


_EXACT = int(
    av.video.reformatter.Interpolation.BICUBIC
    | av.video.reformatter.Interpolation.FULL_CHR_H_INT
    | av.video.reformatter.Interpolation.ACCURATE_RND
    | av.video.reformatter.Interpolation.BITEXACT
)
