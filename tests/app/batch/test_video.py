"""Videos in and out: colours, tags, rate and times are kept; segments join to the same bytes; damage is one line."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from av.audio.frame import AudioFrame
from av.audio.stream import AudioStream
from av.video.stream import VideoStream

from app.batch.joining import join_segments, reopen
from app.batch.video_in import Tags, index, read_frames
from app.batch.video_out import Form, Segment, check_size, join
from app.batch.work import do_chunk
from app.cli import main
from core.arrays import InputError
from core.imaging.images import Image, load
from tests.app.batch.scene import FRAMES, HEIGHT, RECIPE, WIDTH, chunks_of, plate, weft, write_recipe, write_scene

RATE = Fraction(30000, 1001)
HD = Tags(1, 1, 1, 1)


def write_video(path: Path, codec: Any, tags: Tags, frames: int = FRAMES, **options: Any) -> None:
    """Write a video of the scene's plates."""
    form = Form((WIDTH, HEIGHT), codec, Fraction(1001, 30000), RATE, tags, **options)
    segment = path.with_suffix(".segment")
    with Segment(segment, form) as encoder:
        for frame in range(1, frames + 1):
            encoder.append(Image(plate(frame)), frame - 1)
    join({segment: range(frames)}, form, path, named=path)
    segment.unlink()


def tags_of(path: Path) -> Tags:
    return index(path).tags


@pytest.mark.parametrize(
    ("name", "codec", "levels"), [("a.mov", "prores", 6), ("a.mp4", "h264", 8), ("a.mkv", "ffv1", 0)]
)
def test_what_is_written_is_read_back(tmp_path: Path, name: str, codec: str, levels: int) -> None:
    write_video(tmp_path / name, codec, HD)
    clip = index(tmp_path / name)
    assert (clip.size_px, len(clip.pts), clip.rate) == ((WIDTH, HEIGHT), FRAMES, RATE)
    frames = dict(read_frames(tmp_path / name, range(1, FRAMES + 1)))
    for number, image in frames.items():
        assert image is not None
        shown = image.pixels / (257.0 if image.pixels.dtype == np.uint16 else 1.0)
        assert np.abs(shown - plate(number)).max() <= levels + 0.5
    assert (tags_of(tmp_path / name).primaries, tags_of(tmp_path / name).transfer) == (1, 1)


def test_lossless_video_keeps_16_bits_and_alpha(tmp_path: Path) -> None:
    pixels = np.random.default_rng(0).integers(0, 65536, (HEIGHT, WIDTH, 4), dtype=np.uint16)
    form = Form((WIDTH, HEIGHT), "ffv1", Fraction(1, 24), Fraction(24), HD, deep=True, alpha=True)
    with Segment(tmp_path / "a.mkv", form) as segment:
        segment.append(Image(pixels), 0)
    ((_, image),) = read_frames(tmp_path / "a.mkv", [1])
    assert image is not None
    np.testing.assert_array_equal(image.pixels, pixels)


def test_a_frame_is_found_from_anywhere(tmp_path: Path) -> None:
    write_video(tmp_path / "a.mp4", "h264", HD, frames=12)
    for numbers in ([5], [12], [2, 3, 11]):
        found = dict(read_frames(tmp_path / "a.mp4", numbers))
        assert list(found) == numbers
        for number, image in found.items():
            assert image is not None
            assert abs(float(image.pixels[..., 2].mean()) - plate(number)[0, 0, 2]) < 3


@pytest.mark.gpu
@pytest.mark.parametrize("tags", [HD, Tags(9, 16, 9, 1), Tags(1, 13, 1, 2)], ids=["HD", "HDR", "full range"])
@pytest.mark.parametrize(("name", "codec"), [("b.mov", "prores"), ("b.mp4", "h264"), ("b.mkv", "ffv1")])
def test_a_video_becomes_a_video_of_the_same_rate_times_and_tags(
    tmp_path: Path, name: str, codec: str, tags: Tags
) -> None:
    write_scene(tmp_path)
    source, output = tmp_path / "a.mp4", tmp_path / name
    write_video(source, "h264", tags)
    assert tags_of(source) == tags
    recipe = write_recipe(
        tmp_path, f'picture = "a.mp4"\nchunk = 4\n[warp]\npreset = "arc"\nbend = 0\n[output]\ncodec = "{codec}"'
    )
    chunks = chunks_of(recipe, output)
    assert [row.state for chunk in chunks for row in do_chunk(chunk)] == ["done"] * FRAMES
    assert join_segments(chunks)
    assert not list(chunks[0].batch.records.glob("*.segment"))
    before, after = index(source), index(output)
    assert after.rate == before.rate
    unit = [Fraction(pts) * clip.time_base for clip in (before, after) for pts in clip.pts]
    assert all(abs(a - b) < Fraction(1, 1000) for a, b in zip(unit[:FRAMES], unit[FRAMES:], strict=True))
    assert (after.tags.primaries, after.tags.transfer) == (tags.primaries, tags.transfer)
    assert after.tags.matrix == (0 if codec == "ffv1" else tags.matrix)
    assert after.tags.range == {"ffv1": 2, "prores": 1, "h264": tags.range}[codec]
    for (_, a), (_, b) in zip(*(read_frames(path, [1, 5]) for path in (source, output)), strict=True):
        assert a is not None
        assert b is not None
        before_255, after_255 = (255 / np.iinfo(image.pixels.dtype).max * image.pixels for image in (a, b))
        assert np.abs(after_255 - before_255).max() <= 10


@pytest.mark.gpu
def test_one_run_and_shards_and_resume_give_the_same_video(tmp_path: Path) -> None:
    recipe = write_scene(tmp_path)
    assert weft(recipe, "-o", tmp_path / "one.mov", "--jobs", "2", folder=tmp_path).returncode == 0
    two = chunks_of(recipe, tmp_path / "two.mov")
    do_chunk(two[2])
    assert not join_segments(two)
    resumed = chunks_of(recipe, tmp_path / "two.mov", resume=True)
    reopen(resumed)
    states = [row.state for chunk in resumed for row in do_chunk(chunk)]
    assert states == ["done"] * 4 + ["kept"] * 2
    assert join_segments(resumed)
    assert (tmp_path / "one.mov").read_bytes() == (tmp_path / "two.mov").read_bytes()
    assert all(row.state == "kept" for chunk in resumed for row in do_chunk(chunk))


@pytest.mark.gpu
def test_a_frame_that_fails_is_black_and_is_made_good_by_resume(tmp_path: Path) -> None:
    recipe = write_scene(tmp_path, RECIPE.partition("[keys]")[0])
    broken = tmp_path / "plates" / "shot.0004.png"
    whole = broken.read_bytes()
    broken.write_bytes(whole[:-200])
    done = weft(recipe, "-o", tmp_path / "a.mkv", folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.splitlines()[0] == f"weft: error: frame 4: {broken}: the image is damaged or cut short"
    shown = dict(read_frames(tmp_path / "a.mkv", [3, 4]))
    assert shown[3] is not None
    assert shown[4] is not None
    assert (shown[3].pixels.max(), shown[4].pixels.max()) == (251, 0)
    broken.write_bytes(whole)
    done = weft(recipe, "-o", tmp_path / "a.mkv", "--resume", folder=tmp_path)
    assert done.stdout.startswith("6 frames: 2 done, 4 were done before")
    ((_, mended),) = read_frames(tmp_path / "a.mkv", [4])
    assert mended is not None
    assert mended.pixels[..., 2].min() == 80


@pytest.mark.gpu
def test_a_damaged_frame_of_a_video_fails_alone(tmp_path: Path) -> None:
    write_video(tmp_path / "a.mkv", "ffv1", HD)
    with av.open(str(tmp_path / "a.mkv")) as container:
        packets = [bytes(packet) for packet in container.demux(video=0) if packet.size]
    data = (tmp_path / "a.mkv").read_bytes()
    (tmp_path / "a.mkv").write_bytes(data.replace(packets[2], packets[2][:-40] + bytes(40)))
    rows = [
        row
        for chunk in chunks_of(write_recipe(tmp_path, 'picture = "a.mkv"'), tmp_path / "f.#.png")
        for row in do_chunk(chunk)
    ]
    assert [row.state for row in rows] == ["done", "done", "failed", "done", "done", "done"]
    assert rows[2].fault == f"{tmp_path / 'a.mkv'}: frame 3 is damaged"
    assert abs(int(load(rows[3].output).pixels[0, 0, 2]) - 80) <= 1


def test_a_video_without_frames_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with av.open(str(tmp_path / "a.mov"), "w") as container:
        stream = container.add_stream("prores_ks", rate=24)
        assert isinstance(stream, VideoStream)
        stream.width, stream.height, stream.pix_fmt = 32, 32, "yuv422p10le"
        container.start_encoding()
    with av.open(str(tmp_path / "b.mov"), "w") as container:
        sound = container.add_stream("pcm_s16le", rate=48_000, layout="mono")
        assert isinstance(sound, AudioStream)
        frame = AudioFrame.from_ndarray(np.zeros((1, 1024), np.int16), format="s16", layout="mono")
        frame.sample_rate, frame.pts = 48_000, 0
        container.mux(sound.encode(frame))
    write_video(tmp_path / "c.mov", "prores", HD)
    (tmp_path / "c.mov").write_bytes((tmp_path / "c.mov").read_bytes()[:2000])
    for name, fault in (("a", "the video has no frames"), ("b", "the video has no frames"), ("c", "not a video")):
        recipe = write_recipe(tmp_path, f'picture = "{name}.mov"')
        assert main(["batch", str(recipe), "-o", str(tmp_path / "f.#.png")]) == 2
        assert capsys.readouterr().err == f"weft: error: {tmp_path / name}.mov: {fault}\n"


def test_odd_sides_are_refused_where_colours_are_halved(tmp_path: Path) -> None:
    check_size((65, 33), "ffv1", tmp_path / "a.mkv")
    check_size((64, 33), "prores", tmp_path / "a.mov")
    with pytest.raises(InputError, match="65x33 pixels, and h264 takes even sides only"):
        check_size((65, 33), "h264", tmp_path / "a.mp4")
