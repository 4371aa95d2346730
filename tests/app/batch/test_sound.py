"""The sound of a video goes along: the same packets at the same times, or a notice."""

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from av.audio.fifo import AudioFifo
from av.audio.frame import AudioFrame
from av.audio.stream import AudioStream

from app.batch.joining import join_segments
from app.batch.plan import plan
from app.batch.recipe import read_recipe
from app.batch.sound import sound_of
from app.batch.video_in import index
from app.batch.video_out import Form, Segment, join
from app.batch.work import do_chunk
from core.imaging.images import Image
from core.notices import hear_notices
from tests.app.batch.scene import HEIGHT, WIDTH, plate, write_recipe
from tests.app.batch.test_video import HD

pytestmark = pytest.mark.gpu
FRAMES = 24
HZ = 48_000
RATE = Fraction(24)
Heard = list[tuple[float, bytes]]


def write_sound(path: Path, codec: str) -> None:
    """Write a second of two rising tones, in a stream each, and no picture."""
    with av.open(str(path), "w") as container:
        streams = [container.add_stream(codec, rate=HZ, layout="mono") for _ in range(2)]
        for stream, language in zip(streams, ("eng", "spa"), strict=True):
            stream.metadata["language"] = language
        for stream, tone in zip(streams, (440, 1000), strict=True):
            assert isinstance(stream, AudioStream)
            samples = np.sin(np.arange(HZ) ** 2 * (np.pi * tone / HZ**2))[None]
            kind = stream.format.name
            wave = (samples * 8000).astype(np.int16) if kind.startswith("s16") else samples.astype(np.float32) / 4
            frame = AudioFrame.from_ndarray(wave, format=kind, layout="mono")
            frame.sample_rate, frame.pts = HZ, 0
            fifo = AudioFifo()
            fifo.write(frame)
            while (part := fifo.read(stream.codec_context.frame_size or 1024, partial=True)) is not None:
                container.mux(stream.encode(part))
            container.mux(stream.encode(None))


def write_film(path: Path, codec: str) -> None:
    """Write a second of plates in H.264, and sound as a program that films writes it."""
    form = Form((WIDTH, HEIGHT), "h264", 1 / RATE, RATE, HD)
    segment, tones = path.with_suffix(".segment"), path.with_name("tones.mkv")
    with Segment(segment, form) as encoder:
        for frame in range(1, FRAMES + 1):
            encoder.append(Image(plate(frame)), frame - 1)
    silent = path.with_name(f"silent{path.suffix}")
    join({segment: range(FRAMES)}, form, silent, named=silent)
    write_sound(tones, codec)
    with av.open(str(path), "w") as output, av.open(str(silent)) as frames, av.open(str(tones)) as sound:
        streams = [*frames.streams.video, *sound.streams.audio]
        targets = [output.add_stream_from_template(stream) for stream in streams]
        for target, stream in zip(targets, streams, strict=True):
            target.metadata.update(stream.metadata)
        for container, own in ((frames, targets[:1]), (sound, targets[1:])):
            for packet in container.demux():
                if packet.size:
                    packet.stream = own[packet.stream_index]
                    output.mux(packet)


def heard(path: Path) -> list[Heard]:
    """Return the times, in seconds, and the bytes of the packets of each sound stream."""
    with av.open(str(path)) as container:
        found: dict[int, Heard] = {stream.index: [] for stream in container.streams.audio}
        for packet in container.demux():
            if packet.size and packet.stream_index in found:
                assert packet.pts is not None
                found[packet.stream_index].append((float(packet.pts * packet.time_base), bytes(packet)))
        return list(found.values())


def make(recipe: Path, output: Path, frames: str | None = None) -> list[str]:
    """Make a video and return the notices."""
    chunks = plan(read_recipe(recipe), output, frames=frames)
    assert all(row.state == "done" for chunk in chunks for row in do_chunk(chunk))
    with hear_notices() as said:
        assert join_segments(chunks)
    return said


@pytest.mark.parametrize(
    ("source", "codec", "output"),
    [
        ("a.mp4", "aac", "b.mov"),
        ("a.mov", "pcm_s16le", "b.mkv"),
        ("a.mov", "pcm_s16le", "b.mov"),
        ("a.mkv", "libopus", "b.mp4"),
    ],
)
def test_sound_is_copied_as_it_is(tmp_path: Path, source: str, codec: str, output: str) -> None:
    write_film(tmp_path / source, codec)
    recipe = write_recipe(tmp_path, f'picture = "{source}"\nchunk = 10')
    assert make(recipe, tmp_path / output) == []
    before, after = heard(tmp_path / source), heard(tmp_path / output)
    assert [len(track) > 40 for track in before] == [True, True]
    assert [[data for _, data in track] for track in after] == [[data for _, data in track] for track in before]
    for old, new in zip(before, after, strict=True):
        np.testing.assert_allclose([time for time, _ in new], [time for time, _ in old], atol=1e-3)
    with av.open(str(tmp_path / output)) as container:
        assert [stream.language for stream in container.streams.audio] == ["eng", "spa"]
    clip = index(tmp_path / output)
    assert (len(clip.pts), clip.rate) == (FRAMES, RATE)


@pytest.mark.parametrize("output", ["b.mov", "b.mkv"])
def test_some_frames_in_a_row_keep_the_sound_that_is_heard_with_them(tmp_path: Path, output: str) -> None:
    write_film(tmp_path / "a.mov", "pcm_s16le")
    recipe = write_recipe(tmp_path, 'picture = "a.mov"')
    assert make(recipe, tmp_path / output, "7-12") == []
    for before, after in zip(heard(tmp_path / "a.mov"), heard(tmp_path / output), strict=True):
        begins = {data: time for time, data in before}
        np.testing.assert_allclose([time for time, _ in after], [begins[data] - 6 / 24 for _, data in after], atol=1e-3)
        assert -0.03 < after[0][0] < 0.03
        assert 0.2 < after[-1][0] < 6 / 24
    clip = index(tmp_path / output)
    assert [float(pts * clip.time_base) for pts in clip.pts] == pytest.approx([k / 24 for k in range(6)], abs=1e-3)


def test_sound_that_cannot_be_kept_is_one_notice(tmp_path: Path) -> None:
    write_film(tmp_path / "a.mkv", "libopus")
    recipe = write_recipe(tmp_path, 'picture = "a.mkv"')
    said = make(recipe, tmp_path / "b.mov")
    assert said == [f"{tmp_path / 'b.mov'}: sound is left out, for it cannot be copied: invalid argument"]
    assert (heard(tmp_path / "b.mov"), len(index(tmp_path / "b.mov").pts)) == ([], FRAMES)
    said = make(recipe, tmp_path / "c.mkv", "1-9x2")
    assert said == [f"{tmp_path / 'c.mkv'}: sound is left out, as are frames between those that are made"]
    assert heard(tmp_path / "c.mkv") == []


def test_pictures_and_silent_videos_have_no_sound(tmp_path: Path) -> None:
    write_film(tmp_path / "a.mov", "pcm_s16le")
    for name in ("silent.mov", "a.mov"):
        chunks = plan(read_recipe(write_recipe(tmp_path, f'picture = "{name}"')), tmp_path / "b.mov")
        assert (sound_of(chunks) is None) == (name == "silent.mov")
