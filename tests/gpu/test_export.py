"""Rendering to pixels: what must come out exactly."""

import struct
import threading
import tracemalloc
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.render import export, gpu
from app.render.export import render_mesh, rendering, rendering_file, scaled
from app.render.programs import source as shader
from app.render.sources.source import Source, TextureLimits
from core.arrays import InputError, Pixels, Points
from core.canvas import has_gaps
from core.imaging import color
from core.imaging.images import Attribute, Image, load, write
from core.progress import run
from tests.gpu import scenes

pytestmark = pytest.mark.gpu


@pytest.mark.parametrize("depth", ["u1", "u2", "f4"])
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_undeformed_grid_gives_the_picture_back(depth: str, channels: int) -> None:
    image = scenes.picture(83, 61, channels, depth)
    if image.has_alpha:
        opaque = image.pixels.copy()
        opaque[..., -1] = np.maximum(opaque[..., -1], opaque.max() // 2)
        image = image.with_pixels(opaque)
    rest = scenes.grid(83, 61)
    result = render_mesh(image, rest, rest, size=(83, 61))
    assert result.pixels.dtype == image.pixels.dtype
    difference = np.abs(result.pixels.astype(float) - image.pixels)
    assert difference.max() <= {"u1": 0, "u2": 1, "f4": 2e-6}[depth]


def test_whole_pixel_motion_copies_pixels() -> None:
    image = scenes.picture(64, 48)
    rest = scenes.grid(64, 48)
    result = render_mesh(image, rest, rest + [5, 3], size=(80, 60)).pixels
    assert np.array_equal(result[3:51, 5:69, :3], image.pixels)
    assert result[..., 3].sum() == 255 * 64 * 48


def test_origin_and_scale_place_the_frame() -> None:
    image = scenes.picture(40, 30)
    rest = scenes.grid(40, 30)
    moved = render_mesh(image, rest, rest, size=(20, 10), origin=(7, 4)).pixels
    assert np.array_equal(moved, image.pixels[4:14, 7:27])
    doubled = render_mesh(image, rest, rest, size=(80, 60), scale=2).pixels.astype(int)
    means = doubled.reshape(30, 2, 40, 2, 3).mean(axis=(1, 3))
    assert doubled.shape == (60, 80, 3)
    assert np.abs(means - image.pixels).mean() < 6


@pytest.mark.parametrize("scale", [1.0, 0.37, 2.6])
@pytest.mark.parametrize("depth", ["u1", "f4"])
def test_tiles_leave_no_trace(scale: float, depth: str) -> None:
    image = scenes.picture(200, 160, 4, depth)
    rest = scenes.grid(200, 160, cells=40)
    warped = scenes.wavy(rest)
    size = (round(200 * scale), round(160 * scale))
    one = run(rendering(image, rest, warped, size=size, scale=scale, tile_px=1024))
    many = run(rendering(image, rest, warped, size=size, scale=scale, tile_px=32))
    assert np.array_equal(one.pixels, many.pixels)


@pytest.mark.parametrize("cells", [2, 37, 140])
@pytest.mark.parametrize("scale", [1.0, 0.3])
def test_windows_of_a_large_picture_leave_no_trace(scale: float, cells: int) -> None:
    image = scenes.picture(700, 500, 4)
    rest = scenes.grid(700, 500, cells=cells)
    warped = scenes.wavy(rest)
    size = (round(700 * scale), round(500 * scale))
    whole = render_mesh(image, rest, warped, size=size, scale=scale).pixels
    small = TextureLimits(side_px=384)
    assert not Source(gpu.standalone(), image, limits=small).fits((0, 0, 700, 500), 0)
    windows = run(rendering(image, rest, warped, size=size, scale=scale, limits=small)).pixels
    assert np.abs(windows.astype(int) - whole).max() <= (0 if scale == 1.0 else 1)


@pytest.mark.parametrize("channels", [3, 4])
def test_a_tile_of_several_levels_leaves_no_trace(channels: int) -> None:
    image, rest = scenes.picture(600, 600, channels), scenes.grid(600, 600, cells=60)
    corner = np.where(rest < 200, rest, 200 + (rest - 200) / 6)  # its lower right part is shrunk to a sixth
    one = run(rendering(image, rest, corner, size=(266, 266), tile_px=512)).pixels
    many = run(rendering(image, rest, corner, size=(266, 266), tile_px=32)).pixels
    assert np.array_equal(one, many)
    assert np.array_equal(one[:190, :190], image.pixels[:190, :190])
    light = cv2.GaussianBlur(color.decode(color.unit(image.pixels[..., :3])), (0, 0), 3.0)
    seen = color.decode(color.unit(one[210:260, 210:260, :3]))
    assert channels == 4 or np.corrcoef(light[260:560:6, 260:560:6].ravel(), seen.ravel())[0, 1] > 0.97


def test_an_8_bit_picture_that_is_not_shrunk_is_drawn_from_its_bytes() -> None:
    image = scenes.picture(300, 200, 4)
    source = Source(gpu.standalone(), image, exact=True, limits=TextureLimits(budget_bytes=300 * 200 * 4))
    window = source.window((20, 20, 40, 40), 0, 0)
    assert window.box == source.whole
    assert window.encoded is not None
    assert window.encoded.read() == image.pixels.tobytes()
    assert window.texture.size == (1, 1)
    assert not source.is_small
    source.release()


def test_the_light_of_bytes_is_nearer_than_a_fiftieth_of_their_steps() -> None:
    context, light = gpu.standalone(), color.decode_table(256)
    main = "void main() { light = vec4(decoded_bytes(vec3(level / 255.0)), 1.0); }"
    program = context.program(
        vertex_shader=shader("fullscreen.vert"),
        fragment_shader=f"#version 330\nuniform float level;\nout vec4 light;\n{shader('decode_bytes.glsl')}{main}",
    )
    array, target, found = context.vertex_array(program, []), gpu.Offscreen(context, (1, 1), "f4"), []
    for level in range(256):
        program["level"] = level
        with target.drawing():
            array.render(vertices=3)
        found.append(np.frombuffer(target.read((1, 1)), np.float32)[0])
    assert (np.abs(np.array(found) - light) < np.gradient(light) / 50).all()
    target.release()


def test_what_the_next_tile_reads_is_loaded_before_one_is_read_back(monkeypatch: pytest.MonkeyPatch) -> None:
    events: list[str] = []
    load, read = Source._begun, gpu.Offscreen.read
    monkeypatch.setattr(Source, "_begun", lambda *args: events.append("load") or load(*args))  # type: ignore[func-returns-value]
    monkeypatch.setattr(gpu.Offscreen, "read", lambda *args: events.append("read") or read(*args))  # type: ignore[func-returns-value]
    image, rest = scenes.picture(700, 500), scenes.grid(700, 500)
    run(rendering(image, rest, rest, size=(700, 60), tile_px=128, limits=TextureLimits(side_px=384)))
    assert events[:3] == ["load", "load", "read"]
    assert events.count("read") == 6


def checkers(path: Path, side_px: int) -> Path:
    """Write a square PNG of one bit a pixel, squares of 8 x 8 pixels, the first one white."""
    bright = b"\0" + b"\xff\0" * (side_px // 16)
    dark = b"\0" + b"\0\xff" * (side_px // 16)
    squares = zlib.compress((bright * 8 + dark * 8) * (side_px // 16), 1)
    head = struct.pack(">IIBBBBB", side_px, side_px, 1, 0, 0, 0, 0)
    chunks = [(b"IHDR", head), (b"IDAT", squares), (b"IEND", b"")]
    packed = [
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    ]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(packed))
    return path


def test_a_file_of_16384_pixels_a_side_is_drawn_to_its_last_corner(tmp_path: Path) -> None:
    side = 16_384
    image = load(checkers(tmp_path / "vast.png", side))
    assert image.size_px == (side, side)
    assert not Source(gpu.standalone(), image).is_small
    rest = scenes.grid(side, side, cells=16)
    frame = (side - 45, side - 32)
    corner = render_mesh(image, rest, rest + [3, 0], size=(60, 32), origin=frame).pixels
    y, x = np.mgrid[frame[1] : side, frame[0] - 3 : side]
    assert np.array_equal(corner[:, :48, 0], np.where((x // 8 + y // 8) % 2, 0, 255))
    assert (corner[:, :48, 1] == 255).all()
    assert not corner[:, 48:].any()


def test_one_pixel_and_one_row_have_a_place() -> None:
    for width, height in ((1, 1), (1, 500), (500, 1)):
        image = scenes.picture(width, height)
        rest = np.stack(np.meshgrid([-0.5, width - 0.5], [-0.5, height - 0.5]), axis=-1)
        assert np.array_equal(render_mesh(image, rest, rest, size=(width, height)).pixels, image.pixels)


def test_profile_and_depth_are_kept() -> None:
    image = Image(scenes.picture(20, 20, 3, "u2").pixels, icc=b"profile")
    rest = scenes.grid(20, 20)
    result = render_mesh(image, rest, scenes.wavy(rest), size=(20, 20))
    assert result.icc == b"profile"
    assert result.pixels.dtype == np.uint16
    assert result.has_alpha


def test_the_window_keeps_the_nearest_half_of_every_texel() -> None:
    random = np.random.default_rng(3)
    pixels = random.normal(0, 3, (40, 50, 3)).astype(np.float32)
    pixels[0, :4, 0] = [1e-7, -6e-8, 65519.0, 0.1]
    source = Source(gpu.standalone(), Image(pixels, linear=True))
    window = source.window(source.whole, 0)
    width, height = window.texture.size
    texels = np.frombuffer(window.texture.read(), np.float16).reshape(height, width, 4)
    assert np.array_equal(texels[:40, :50, :3], pixels.astype(np.float16))
    source.release()


TALL = (40, 1100)
"""Of three rows of tiles."""


def shrunk(rest: Points, *, top: float = 0.0, bottom: float = 0.0) -> Points:
    """Move the picture's upper and lower edge inwards by so many pixels, and what is between them along."""
    height = rest[-1, 0, 1] + 0.5
    moved: Points = (rest + 0.5) * [1, 1 - (top + bottom) / height] + [-0.5, top - 0.5]
    return moved


@pytest.mark.parametrize(
    ("suffix", "channels", "depth"),
    [
        (".png", 1, "u1"),
        (".png", 3, "f4"),
        (".tif", 4, "u2"),
        (".exr", 3, "f4"),
        (".exr", 4, "f4"),
        (".jpg", 3, "u1"),
        (".webp", 3, "u1"),
    ],
)
@pytest.mark.parametrize(("top", "bottom", "plain"), [(0, 0, False), (0, 0.4, False), (40, 0, True)])
def test_a_file_written_row_by_row_is_that_of_the_whole(
    tmp_path: Path, suffix: str, channels: int, depth: str, top: float, bottom: float, plain: bool
) -> None:
    picture = scenes.picture(*TALL, channels, depth)
    image = Image(picture.pixels, picture.linear, metadata=(Attribute("Make", "string", "Weft"),))
    rest = scenes.grid(*TALL)
    warped = shrunk(rest, top=top, bottom=bottom)
    assert has_gaps(warped, TALL) is plain
    whole, rows = tmp_path / f"whole{suffix}", tmp_path / f"rows{suffix}"
    write(render_mesh(image, rest, warped, size=TALL), whole, named=whole)
    steps = [step.fraction for step in rendering_file(image, rest, warped, rows, named=rows, size=TALL)]
    assert rows.read_bytes() == whole.read_bytes()
    assert steps == sorted(steps)
    if suffix != ".jpg":
        assert load(rows).has_alpha == (image.has_alpha or top > 0 or bottom > 0)


@pytest.mark.parametrize("suffix", [".png", ".tif", ".exr", ".jpg"])
def test_a_file_is_written_in_a_fraction_of_the_memory_of_its_pixels(tmp_path: Path, suffix: str) -> None:
    image, size = scenes.picture(32, 512, 4, "f4"), (384, 6144)
    rest, path = scenes.grid(32, 512), tmp_path / f"a{suffix}"
    tracemalloc.start()
    run(rendering_file(image, rest, scaled(rest, 12), path, named=path, size=size))
    peak_bytes = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak_bytes < 384 * 6144 * 16 / 2


@pytest.mark.parametrize("scale", [0.4, 1.0, 2.6])
def test_a_file_at_another_scale_is_that_of_the_whole(tmp_path: Path, scale: float) -> None:
    image = scenes.picture(300, 260)
    rest = scenes.grid(300, 260)
    warped, size = scenes.wavy(rest), (round(300 * scale), round(260 * scale))
    whole, rows = tmp_path / "whole.png", tmp_path / "rows.png"
    write(render_mesh(image, rest, warped, size=size, scale=scale), whole, named=whole)
    run(rendering_file(image, rest, scaled(warped, scale), rows, named=rows, size=size))
    assert rows.read_bytes() == whole.read_bytes()


@pytest.mark.parametrize("seed", range(8))
def test_where_a_gap_is_plain_pixels_are_empty(seed: int) -> None:
    rng = np.random.default_rng(seed)
    image = scenes.picture(90, 70)
    rest = scenes.grid(90, 70)
    warped = (scenes.wavy(rest, amount=rng.uniform(0, 12)) - 45) * rng.uniform(0.85, 1.5) + 45 + rng.normal(0, 3, 2)
    result = render_mesh(image, rest, warped, size=(90, 70))
    assert not has_gaps(warped, (90, 70)) or (result.has_alpha and result.pixels[..., 3].min() == 0)


def test_rows_are_written_beside_the_drawing_and_a_fault_there_ends_the_export(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    image, rest, path = scenes.picture(*TALL), scenes.grid(*TALL), tmp_path / "a.png"
    tops: list[int] = []
    threads: set[int] = set()

    def append(rows: Pixels) -> None:
        threads.add(threading.get_ident())
        tops.append(len(rows))
        if len(tops) == 2:
            raise InputError("the disk is gone")

    @contextmanager
    def failing(*_: object, **__: object) -> Iterator[Callable[[Pixels], None]]:
        yield append

    monkeypatch.setattr(export, "writing_rows", failing)
    with pytest.raises(InputError, match="the disk is gone"):
        run(rendering_file(image, rest, rest, path, named=path, size=TALL))
    assert tops == [512, 512]
    assert threading.get_ident() not in threads
