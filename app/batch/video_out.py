"""Videos in pieces: a chunk's frames are encoded to a segment, and the segments are joined without encoding anew."""

import heapq
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import av
import numpy as np
from av.container import OutputContainer
from av.packet import Packet
from av.video.frame import VideoFrame
from av.video.stream import VideoStream

from app.batch.recipe import Codec
from app.batch.sound import Sound
from app.batch.video_in import Tags
from core.arrays import InputError
from core.imaging import color
from core.imaging.image import Image
from core.notices import notice

_ENCODERS: dict[Codec, str] = {"prores": "prores_ks", "h264": "libx264", "ffv1": "ffv1"}
_BY_ENDING: dict[str, tuple[Codec, ...]] = {".mov": ("prores", "h264"), ".mp4": ("h264",), ".mkv": ("ffv1",)}
_JOINED = {".mov": "mov", ".mp4": "mp4", ".mkv": "matroska"}
_OPTIONS: dict[Codec, dict[str, str]] = {
    "prores": {"profile": "3"},
    "h264": {"preset": "medium"},
    "ffv1": {"level": "3", "slices": "4", "slicecrc": "1", "g": "1"},
}
_PROFILE_4444 = "4"
_FULL = 2
"""Code of full range."""


@dataclass(frozen=True)
class Form:
    """What all segments of a video have in common, so that they can be joined."""

    size_px: tuple[int, int]
    codec: Codec
    time_base: Fraction
    rate: Fraction
    tags: Tags
    quality: int = 95
    deep: bool = False
    """Whether samples have more than 8 bits where the codec leaves the choice."""
    alpha: bool = False

    @property
    def has_alpha(self) -> bool:
        """Whether the video holds alpha, which H.264 cannot."""
        return self.alpha and self.codec != "h264"

    @property
    def options(self) -> dict[str, str]:
        """The encoder's options."""
        options = dict(_OPTIONS[self.codec])
        if self.codec == "h264":
            options["crf"] = str(crf_of(self.quality))
        if self.codec == "prores" and self.has_alpha:
            options["profile"] = _PROFILE_4444
        return options

    @property
    def layout(self) -> str:
        """The layout of the video's pixels."""
        return _layout(self.codec, deep=self.deep, alpha=self.has_alpha)

    @property
    def encoded_tags(self) -> Tags:
        """The tags of the file: of a video that holds RGB, matrix and range say so; ProRes knows no full range."""
        if self.layout in _RGB:
            return replace(self.tags, matrix=0, range=2)
        return replace(self.tags, range=1) if self.codec == "prores" and self.tags.range == _FULL else self.tags


def codec_for(output: Path, chosen: Codec | None) -> Codec:
    """Return the codec that was chosen, or the usual one of the file; raise `InputError` if the file cannot hold it."""
    codecs = _BY_ENDING[output.suffix.lower()]
    if chosen is not None and chosen not in codecs:
        raise InputError(f"{output}: a {output.suffix.lower()} file holds {' or '.join(codecs)}, not {chosen}")
    return chosen or codecs[0]


class Segment:
    """The segment of a chunk, written frame by frame to `place`.

    One thread encodes and no frame refers to a later one: the bytes depend on the frames alone.
    """

    def __init__(self, place: Path, form: Form) -> None:
        self.form = form
        kind = "matroska" if form.codec == "ffv1" else "mov"
        self._container = av.open(str(place), "w", format=kind, container_options={"fflags": "+bitexact"})
        self._stream = _encoder(self._container, form)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, at: TracebackType | None) -> None:
        try:
            if kind is None:
                self._container.mux(self._stream.encode(None))
        finally:
            self._container.close()

    def append(self, image: Image, pts: int) -> None:
        """Encode `image` as the frame that is shown at `pts`."""
        form = self.form
        if image.size_px != form.size_px:
            width, height = form.size_px
            raise InputError(f"has {image.width_px}x{image.height_px} pixels, the video's frames {width}x{height}")
        samples = _samples(image, deep=form.deep, alpha=form.has_alpha)
        plain = VideoFrame.from_ndarray(samples, format=_NAMES[form.deep, form.has_alpha])
        frame = plain.reformat(
            format=form.layout,
            dst_colorspace=form.tags.swscale_matrix(image.height_px),
            src_color_range=2,
            dst_color_range=form.encoded_tags.swscale_range,
            interpolation=_EXACT,
            threads=1,
        )
        frame.pts, frame.time_base = pts, form.time_base
        frame.color_primaries, frame.color_trc = form.tags.primaries, form.tags.transfer
        frame.colorspace, frame.color_range = form.encoded_tags.matrix, form.encoded_tags.range
        self._container.mux(self._stream.encode(frame))


def _encoder(container: OutputContainer, form: Form) -> VideoStream:
    """Return a new stream of `container` that encodes frames."""
    stream = container.add_stream(_ENCODERS[form.codec], rate=form.rate, options=form.options)
    assert isinstance(stream, VideoStream)
    context, tags = stream.codec_context, form.encoded_tags
    stream.width, stream.height = form.size_px
    stream.pix_fmt = form.layout
    stream.time_base = context.time_base = form.time_base
    context.thread_count, context.max_b_frames = 1, 0
    context.flags |= int(av.codec.context.Flags.bitexact)
    context.color_primaries, context.color_trc = tags.primaries, tags.transfer
    context.colorspace, context.color_range = tags.matrix, tags.range
    return stream


def crf_of(quality: int) -> int:
    """Return x264's constant rate factor, 51 to 0, of a quality from 1 to 100; 95 gives 3."""
    return round((100 - quality) * 51 / 99)


def check_size(size_px: tuple[int, int], codec: Codec, output: Path) -> None:
    """Raise `InputError` for a size that the codec does not take: H.264 and ProRes halve colours in pairs of pixels."""
    if size_px[0] % 2 or (codec == "h264" and size_px[1] % 2):
        if codec == "ffv1":
            return
        raise InputError(f"{output}: {size_px[0]}x{size_px[1]} pixels, and {codec} takes even sides only")


def join(
    segments: Mapping[Path, Sequence[int]], form: Form, place: Path, *, named: Path, sound: Sound | None = None
) -> None:
    """Write the video that the segments make; with each stands when its frames are shown, in the unit of `form`.

    Sound that the file cannot hold, or that is damaged, is left out, which a notice says. Faults name the file `named`,
    which it is to become.
    """
    try:
        try:
            _mux(segments, form, place, named, sound)
        except (av.FFmpegError, ValueError) as fault:
            if sound is None or isinstance(fault, OSError):
                raise
            notice(f"{named}: sound is left out, for it cannot be copied: {_reason(fault)}")
            _mux(segments, form, place, named, None)
    except av.FFmpegError as fault:
        raise InputError(f"{named}: cannot be written: {_reason(fault)}") from fault


def _reason(fault: av.FFmpegError | ValueError) -> str:
    """Return what a fault says, without the name of a file that is on its way."""
    return ((fault.strerror if isinstance(fault, av.FFmpegError) else None) or str(fault)).lower()


def _mux(segments: Mapping[Path, Sequence[int]], form: Form, place: Path, named: Path, sound: Sound | None) -> None:
    """Write frames and sound to `place`, as they follow on one another in time."""
    ending = _JOINED[named.suffix.lower()]
    with av.open(str(place), "w", format=ending, container_options={"fflags": "+bitexact"}) as output:
        tracks = [_frames(segments, form, output)] + ([] if sound is None else [sound.packets(output)])
        # Streams are added when the first packet of each track is asked for, all of them before one is written.
        for packet in heapq.merge(*tracks, key=lambda packet: (packet.dts or 0) * packet.time_base):
            output.mux(packet)


def _frames(segments: Mapping[Path, Sequence[int]], form: Form, output: OutputContainer) -> Iterator["Packet[Any]"]:
    """Add a stream to `output` and yield the packets of all segments for it."""
    target: VideoStream | None = None
    for segment, times in segments.items():
        with av.open(str(segment)) as container:
            source = container.streams.video[0]
            target = target or _target(output, source, form)
            packets = (packet for packet in container.demux(source) if packet.size)
            for packet, pts in zip(packets, times, strict=True):
                packet.stream, packet.time_base = target, form.time_base
                packet.pts = packet.dts = pts  # no frame refers to a later one
                packet.duration = round(1 / (form.rate * form.time_base))
                yield packet


def _target(output: OutputContainer, source: VideoStream, form: Form) -> VideoStream:
    """Return the stream that takes the packets of segments.

    Matroska counts in milliseconds: it needs the rate beside them, which only a stream of an encoder's has. The encoder
    of FFV1 is set up alike in every segment, so that it does for the packets of all.
    """
    if form.codec == "ffv1":
        return _encoder(output, form)
    target = output.add_stream_from_template(source)
    target.time_base = form.time_base
    return target


def _layout(codec: Codec, *, deep: bool, alpha: bool) -> str:
    """Return the layout of pixels in a video."""
    if codec == "prores":
        return "yuva444p10le" if alpha else "yuv422p10le"
    if codec == "h264":
        return "yuv420p"
    if deep:
        return "gbrap16le" if alpha else "gbrp16le"
    return "bgra" if alpha else "bgr0"


def _samples(image: Image, *, deep: bool, alpha: bool) -> Any:
    """Return the picture's sRGB as (H, W, 3 or 4) of 8 or 16 bits; without alpha, what is not covered is black."""
    depth = np.uint16 if deep else np.uint8
    pixels = image.pixels
    if image.linear:
        light = color.linear_light(pixels, linear=True)
        pixels = color.store(light, depth=depth, linear=False)
    elif pixels.dtype != depth:
        pixels = color.quantise(color.unit(pixels), depth)
    colours = pixels[..., : color.color_channels(image.channels)]
    colours = np.repeat(colours, 3, axis=2) if colours.shape[2] == 1 else colours
    most = np.iinfo(depth).max
    cover = pixels[..., -1:] if image.has_alpha else np.full((*pixels.shape[:2], 1), most, depth)
    if alpha:
        return np.ascontiguousarray(np.concatenate([colours, cover], axis=2))
    return np.ascontiguousarray(np.rint(colours * (cover / most)).astype(depth)) if image.has_alpha else colours


_RGB = ("bgr0", "bgra", "gbrp16le", "gbrap16le")
_NAMES = {(False, False): "rgb24", (False, True): "rgba", (True, False): "rgb48le", (True, True): "rgba64le"}
"""By whether samples are deep and whether there is alpha, the layout that frames are handed over in."""
_EXACT = int(
    av.video.reformatter.Interpolation.BICUBIC
    | av.video.reformatter.Interpolation.FULL_CHR_H_INP
    | av.video.reformatter.Interpolation.ACCURATE_RND
    | av.video.reformatter.Interpolation.BITEXACT
)
