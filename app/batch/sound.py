"""The sound of a video that is read, for the one that is written: its packets as they are, never encoded anew."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
from av.audio.stream import AudioStream
from av.container import InputContainer, OutputContainer
from av.packet import Packet

from app.batch.plan import Chunk
from app.batch.video_in import LENIENT, index
from core.notices import notice


@dataclass(frozen=True)
class Sound:
    """What is heard in a video between two moments of it, in seconds."""

    video: Path
    begin: Fraction
    """What is heard here comes with the first frame that is written."""
    first: Fraction | None
    """Packets that end by then are left out; None where the first frame is the video's own."""
    end: Fraction | None
    """Packets that begin here or later are left out; None where the last frame is the video's own."""

    def packets(self, output: OutputContainer) -> Iterator["Packet[Any]"]:
        """Add streams like the video's to `output`, and yield the packets for them in the order of the file.

        Raises `ValueError` or `av.FFmpegError` for sound that `output` cannot hold, or that is damaged.
        """
        with av.open(str(self.video), **LENIENT) as container:
            targets = {stream.index: _added(output, stream) for stream in container.streams.audio}
            for packet in _timed(container):
                begins = packet.pts * packet.time_base  # type: ignore[operator]  # seen to by _timed
                ends = begins + (packet.duration or 0) * packet.time_base
                if (self.first is not None and ends <= self.first) or (self.end is not None and begins >= self.end):
                    continue
                shift = round(self.begin / packet.time_base)
                packet.pts, packet.dts = packet.pts - shift, packet.dts - shift  # type: ignore[operator]
                packet.stream = targets[packet.stream_index]
                if packet.pts >= 0 or output.format.name != "matroska":  # which knows no times before the first frame
                    yield packet


def _added(output: OutputContainer, stream: AudioStream) -> AudioStream:
    """Add a stream like `stream` to `output`, of the same language and title."""
    target = output.add_stream_from_template(stream)
    target.metadata.update({name: text for name, text in stream.metadata.items() if name in {"language", "title"}})
    return target


def _timed(container: InputContainer) -> Iterator["Packet[Any]"]:
    """Yield the packets of all sound streams; what has no time cannot be kept beside the frames."""
    for packet in container.demux(audio=list(range(len(container.streams.audio)))):
        if packet.size and packet.pts is not None and packet.dts is not None:
            yield packet


def sound_of(chunks: Sequence[Chunk]) -> Sound | None:
    """Return the sound that belongs to the frames of a batch, None where their video has none, or they are no video.

    Frames that leave some out have no sound either, which a notice says.
    """
    batch = chunks[0].batch
    if batch.kind != "video":
        return None
    video = Path(batch.first.source)
    with av.open(str(video), **LENIENT) as container:
        if not container.streams.audio:
            return None
    frames = [item.frame for chunk in chunks for item in chunk.items]
    if frames[-1] - frames[0] != len(frames) - 1:
        notice(f"{batch.output}: sound is left out, as are frames between those that are made")
        return None
    clip = index(video)
    begin = clip.pts[frames[0] - 1] * clip.time_base
    end = None if frames[-1] == len(clip.pts) else clip.pts[frames[-1]] * clip.time_base
    return Sound(video, begin, None if frames[0] == 1 else begin, end)
