"""Rendering to pixels: what must come out exactly."""

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from app.render import gpu
from app.render.export import render_mesh, rendering
from app.render.source import Limits, Source
from core.images import Image, load
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
    small = Limits(side_px=384)
    assert not Source(gpu.standalone(), image, limits=small).fits((0, 0, 700, 500), 0)
    windows = run(rendering(image, rest, warped, size=size, scale=scale, limits=small)).pixels
    assert np.abs(windows.astype(int) - whole).max() <= (0 if scale == 1.0 else 1)


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
