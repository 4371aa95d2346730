"""Render a warped picture to pixels, tile by tile, with the shaders of the editor's preview."""

from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from itertools import zip_longest
from pathlib import Path

import moderngl
import numpy as np

from app.render import gpu
from app.render.passes.mesh import MeshBuffers
from app.render.passes.picture_pass import LEAST_STRETCH, PicturePass, draw_at_once
from app.render.programs import programs_of
from app.render.source_footprint import Read
from app.render.sources.source import DEFAULT_LIMITS, Box, Source, TextureLimits
from core import tracing
from core.arrays import InputError, Pixels, Points
from core.canvas import has_gaps
from core.imaging import color
from core.imaging.images import Image, writing_rows
from core.progress import Job, Progress, part, run

TILE_PX = 512
COMMAND_TILE_PX = 1024
"""For commands, in which nothing waits for the next stop: threads wait less often for one another."""
LEAST_TILE_PX = 64
MOST_SIDE_PX = 65_536


def render_mesh(
    image: Image,
    rest: Points,
    warped: Points,
    *,
    size: tuple[int, int],
    origin: tuple[float, float] = (0.0, 0.0),
    scale: float = 1.0,
) -> Image:
    """Return `image` drawn as the deformed grid, at its own depth; see `rendering`."""
    return run(rendering(image, rest, warped, size=size, origin=origin, scale=scale, tile_px=COMMAND_TILE_PX))


def rendering(
    image: Image,
    rest: Points,
    warped: Points,
    *,
    size: tuple[int, int],
    origin: tuple[float, float] = (0.0, 0.0),
    scale: float = 1.0,
    tile_px: int = TILE_PX,
    limits: TextureLimits = DEFAULT_LIMITS,
) -> Job[Image]:
    """Draw `image` as the deformed grid, tile by tile.

    Parameters
    ----------
    rest, warped
        Node positions (R, C, 2) in source pixels and in output pixels at scale 1.
    size
        Width and height of the result.
    origin
        The place, at scale 1, of the result's first pixel's outer corner plus half a pixel: (0, 0) keeps the frame.
    scale
        Output pixels per pixel of `warped`.
    tile_px, limits
        Side of a tile, a power of two, and what the source's texture may take; neither changes the result.

    Returns
    -------
    Image
        Same depth, profile and metadata; alpha is added where the result does not cover its frame.
    """
    moved = scaled(warped - np.asarray(origin), scale)
    _check(rest, moved, size)
    pixels = np.zeros((size[1], size[0], 4), image.pixels.dtype)
    with _target(image, rest, moved, size, tile_px, limits) as target:
        for top in range(0, size[1], target.side):
            rows = pixels[top : top + target.side]
            yield from part(target.drawing_rows(top, rows), top / size[1], (top + len(rows)) / size[1])
    yield Progress(1.0, "rendering")
    return image.with_pixels(_in_channels_of(image, pixels))


class _UncoveredError(Exception):
    """Something in the frame is not covered by the picture."""

    def __init__(self, done: float) -> None:
        super().__init__()
        self.done = done


def rendering_file(
    image: Image,
    rest: Points,
    moved: Points,
    place: Path,
    *,
    named: Path,
    size: tuple[int, int],
    quality: int = 95,
    tile_px: int = TILE_PX,
) -> Job[None]:
    """Write to `place` the file that `rendering` and `core.imaging.images.write` make, with one row of tiles in memory.

    `moved` is in output pixels (`scaled`). While one row of tiles is drawn, the one above it is compressed and written
    on a thread of its own. Whether the file needs alpha is known when all is drawn. Where no gap is plain it is begun
    without, and anew at the first row of tiles that is not opaque.
    """
    _check(rest, moved, size)

    def attempt(*, with_alpha: bool) -> Job[None]:
        kept = _kept(image, with_alpha=with_alpha)
        sample = image.with_pixels(np.zeros((1, 1, len(kept)), image.pixels.dtype))
        with (
            writing_rows(sample, size, place, named=named, quality=quality) as append,
            _target(image, rest, moved, size, tile_px) as target,
            ThreadPoolExecutor(1, "writing") as writer,
        ):
            band, spare = np.empty((2, min(target.side, size[1]), size[0], 4), image.pixels.dtype)
            written: Future[None] | None = None
            for top in range(0, size[1], target.side):
                rows = band[: size[1] - top]
                yield from part(target.drawing_rows(top, rows), top / size[1], (top + len(rows)) / size[1])
                if not (with_alpha or _is_opaque(rows)):
                    raise _UncoveredError(top / size[1])
                if written is not None:
                    written.result()
                written = writer.submit(
                    lambda rows: append(rows if len(kept) == 4 else color.take_channels(rows, kept)), rows
                )
                band, spare = spare, band
            if written is not None:
                written.result()

    done = 0.0
    if not (image.has_alpha or has_gaps(moved, size)):
        try:
            return (yield from attempt(with_alpha=False))
        except _UncoveredError as found:
            done = found.done
    return (yield from part(attempt(with_alpha=True), done, 1.0))


@contextmanager
def _target(
    image: Image,
    rest: Points,
    moved: Points,
    size: tuple[int, int],
    tile_px: int = TILE_PX,
    limits: TextureLimits = DEFAULT_LIMITS,
) -> Iterator["TileTarget"]:
    """Yield what draws the tiles of a result of `size`."""
    target = TileTarget(gpu.standalone(), image, min(tile_px, gpu.power_of_two(max(size))), limits)
    try:
        target.mesh_of(rest, moved)
        yield target
    finally:
        target.release()


def scaled(nodes: Points, scale: float) -> Points:
    """Return positions in output pixels at `scale` for those at scale 1."""
    if not (np.isfinite(scale) and scale > 0):
        raise InputError(f"a scale of {scale:g}: must be a number greater than 0")
    return (nodes + 0.5) * scale - 0.5


def _check(rest: Points, moved: Points, size: tuple[int, int]) -> None:
    if rest.shape != moved.shape or rest.ndim != 3 or min(rest.shape) < 2:
        raise InputError(f"grid of {rest.shape} and {moved.shape}: not two grids of one shape, 2 x 2 nodes at least")
    if not (min(size) >= 1 and max(size) <= MOST_SIDE_PX):
        raise InputError(f"size {size[0]}x{size[1]}: sides must be from 1 to {MOST_SIDE_PX} pixels")
    if not np.isfinite(moved).all():
        raise InputError("grid positions that are not finite numbers")


def _in_channels_of(image: Image, pixels: Pixels) -> Pixels:
    """Return RGBA `pixels` in the channels of `image`, with alpha if that has it or something is not covered.

    Works in place, row after row, since a copy of a large picture would be the most memory that rendering takes.
    """
    kept = _kept(image, with_alpha=image.has_alpha or not _is_opaque(pixels))
    if len(kept) == 4:
        return pixels
    height, width = pixels.shape[:2]
    packed = pixels.reshape(-1)[: height * width * len(kept)].reshape(height, width, len(kept))
    for y in range(height):
        packed[y] = color.take_channels(pixels[y][None], kept)[0]
    del packed
    pixels.resize((height, width, len(kept)), refcheck=False)
    return pixels


def _kept(image: Image, *, with_alpha: bool) -> list[int]:
    """Return which channels of RGBA a result of `image` has."""
    return ([0] if image.channels <= 2 else [0, 1, 2]) + ([3] if with_alpha else [])


def _is_opaque(pixels: Pixels) -> bool:
    opaque = 1.0 if pixels.dtype.kind == "f" else np.iinfo(pixels.dtype).max
    return bool(pixels[..., 3].min() >= opaque)


class TileTarget:
    """What draws one tile after another: float accumulation, then encoding to the depth of the file."""

    def __init__(self, context: moderngl.Context, image: Image, side: int, limits: TextureLimits) -> None:
        self.side = side
        self._context = context
        self._programs = programs_of(context)
        self._sources = [Source(context, image, exact=True, limits=limits) for _ in range(2)]
        self._linear = image.linear
        depth = {"u1": "f1", "u2": "nu2", "f4": "f4"}[image.pixels.dtype.str[1:]]
        self._picture = PicturePass(context, (side, side), exact=True)
        self._pixels = gpu.Offscreen(context, (side, side), depth)
        self._mesh: MeshBuffers | None = None

    def mesh_of(self, rest: Points, moved: Points) -> None:
        """Take the grid to draw, in source pixels and in output pixels."""
        rows, columns = rest.shape[:2]
        self._mesh = MeshBuffers(self._context, (rows, columns))
        self._mesh.place(rest, moved)

    def drawing_rows(self, top: int, out: Pixels) -> Job[None]:
        """Draw the output's rows from `top` into `out`, (h, w, 4): all columns, of rows what a tile has at most.

        While the GPU filters one tile, what the next one reads of the picture is loaded.
        """
        height, width = out.shape[:2]
        tiles = [(left, top, min(left + self.side, width), top + height) for left in range(0, width, self.side)]
        coming = self._reads_of(tiles[0])
        for tile, following in zip_longest(tiles, tiles[1:]):
            yield Progress(tile[0] / width, "rendering")
            with tracing.span("draw", tile=tile):
                reads, coming = coming, []
                if reads:
                    self._filter(tile, reads)
                if following is not None:
                    coming = self._reads_of(following)
                    self._load(coming)
                self._encode(out[:, tile[0] : tile[2]], is_empty=not reads)

    def _filter(self, tile: Box, reads: list[tuple[Box, Read]]) -> None:
        """Send off what draws the parts of `tile` in linear light."""
        assert self._mesh is not None
        self._picture.clear()
        for box, read in reads:
            draw_at_once(self._picture.drawing(self._mesh, self._source_of(read), box, origin=tile[:2], read=read))
        self._pixels.clear()  # drivers begin with what is queued when the target changes

    def _load(self, reads: list[tuple[Box, Read]]) -> None:
        """Load what the first of `reads` needs."""
        for _, read in reads[:1]:
            self._source_of(read).window(*read[:3])

    def _encode(self, out: Pixels, *, is_empty: bool) -> None:
        """Put the tile into `out`, (h, w, 4)."""
        if is_empty:
            out[:] = 0
            return
        with self._pixels.drawing():
            self._picture.light.texture.use(0)
            self._programs.fullscreen("encode.frag", tile=0, linear=self._linear)
        read = self._pixels.read((out.shape[1], out.shape[0]))
        out[:] = np.frombuffer(read, out.dtype).reshape(out.shape)

    def _reads_of(self, box: Box) -> list[tuple[Box, Read]]:
        """Return what drawing `box` reads, by quarters where that is too large for a window; nothing if it is empty."""
        assert self._mesh is not None
        read = self._mesh.source_of(box, least_stretch=LEAST_STRETCH)
        if read is None:
            return []
        side = max(box[2] - box[0], box[3] - box[1])
        source = self._sources[0]
        if side > LEAST_TILE_PX and not (source.is_small or source.fits(*read[:3])):
            return [found for quarter in _quarters(box) for found in self._reads_of(quarter)]
        return [(box, read)]

    def _source_of(self, read: Read) -> Source:
        """Return the source that was drawn from last if its window holds what is read, else the other."""
        if not self._sources[0].holds(*read[:3]):
            self._sources.reverse()
        return self._sources[0]

    def release(self) -> None:
        """Free the GPU objects."""
        gpu.release(*self._sources, self._mesh, self._picture, self._pixels)


def _quarters(box: Box) -> list[Box]:
    left, top, right, bottom = box
    x, y = (left + right) // 2, (top + bottom) // 2
    boxes = [(left, top, x, y), (x, top, right, y), (left, y, x, bottom), (x, y, right, bottom)]
    return [quarter for quarter in boxes if quarter[0] < quarter[2] and quarter[1] < quarter[3]]
