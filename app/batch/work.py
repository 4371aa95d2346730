"""One chunk of a batch, from the first factorisation to the last file: what a process, here or elsewhere, is given."""

import errno
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from app.batch import records, video_out
from app.batch.look import Look
from app.batch.plan import Batch, Chunk, Item
from app.batch.records import Row
from app.batch.steady import SteadySolver
from app.batch.video_in import read_frames
from app.render.export import render_mesh
from app.render.picture_file import Drawing, at_depth, draw_warped, drawing_file
from core.arrays import InputError, WeftError
from core.document import overlay_texture
from core.document import retexture as document_retexture
from core.document.document import Document
from core.document.map_solver import MapSolver
from core.files.atomic import AtomicFiles
from core.imaging.images import Image, load
from core.linalg.blas import one_thread
from core.notices import hear_notices
from core.progress import run
from core.retexture.result import Retexture


class DiskFullError(WeftError):
    """Nothing more can be written."""


def do_chunk(chunk: Chunk) -> list[Row]:
    """Make the frames of a chunk that are not done, and return what became of each.

    A frame that fails is a row, and the next one is begun. Raises `DiskFullError` where nothing more can be written.
    """
    batch = chunk.batch
    with records.hold_back(batch, chunk.name), one_thread():
        records.settle(batch, chunk)
        maker = _VideoMaker(chunk) if batch.writes_video else _PictureMaker(chunk)
        return maker.rows()


class _Maker:
    """What the frames of a chunk are made with."""

    def __init__(self, chunk: Chunk) -> None:
        self.chunk, self.batch = chunk, chunk.batch
        self.output = chunk.batch.recipe.table.output
        self._look: Look | None = None
        self._solver, self._steady = MapSolver(), SteadySolver(self.batch.frames)
        self._regrown: Retexture | None = None

    @property
    def look(self) -> Look:
        """The look; read when the first frame needs it, what there is to say of it was said before."""
        if self._look is None:
            with hear_notices():
                self._look = Look(self.batch)
        return self._look

    def pictures(self, items: list[Item]) -> Iterator[tuple[Item, Image | InputError | None]]:
        """Yield the frames with their pictures: a fault for one that cannot be read, None for the document's own."""
        if self.batch.kind == "video":
            by_number = {item.frame: item for item in items}
            for number, picture in read_frames(Path(items[0].source), list(by_number)) if items else ():
                broken = InputError(f"{items[0].source}: frame {number} is damaged")
                yield by_number[number], picture or broken
            return
        kept: tuple[str, Image] | None = None
        for item in items:
            try:
                if item.source and (kept is None or kept[0] != item.source):
                    kept = item.source, self._checked(item, load(item.source))
                yield item, None if kept is None else kept[1]
            except InputError as fault:
                yield item, fault

    def _checked(self, item: Item, picture: Image) -> Image:
        """Return the picture of a frame; raise `InputError` if it has another size than the first of its sequence."""
        if self.batch.kind == "sequence" and picture.size_px != self.batch.size_px:
            width, height = self.batch.size_px
            found = f"{picture.width_px}x{picture.height_px}"
            raise InputError(f"{item.source}: has {found} pixels, the first frame {width}x{height}")
        return picture

    def drawing(self, item: Item, picture: Image | None) -> Drawing:
        """Return a frame, ready to be drawn."""
        options, document = self.output, self.look.at(item.frame, picture)
        if document.mode == "warp":
            if self.batch.kind != "pictures":
                document = document.changed(image=with_alpha(document.image))
            if self.batch.kind != "pictures" and self.look.moves:
                found = self._steady.settle(item.frame, lambda frame: self.look.at(frame, picture))
            else:
                found = run(self._solver.settle(document))
            name = Path(item.output).name
            return draw_warped(document, found, name, frame=options.frame, scale=options.scale, bits=options.bits)
        if document.mode == "overlay":
            image = run(overlay_texture.picture(document, at_depth(document.image, options.bits)))
        else:
            image = self._retextured(document, at_depth(document.image, options.bits))
        return Drawing.unmoved(image, scale=options.scale)

    def _retextured(self, document: Document, image: Image) -> Image:
        """Return a picture whose texture is regrown: in sequences from the same places in every frame."""
        if self.batch.kind == "pictures":
            return run(document_retexture.picture(document, image))
        if not document_retexture.moves(document):
            return image
        if self._regrown is None:
            self._regrown = run(document_retexture.found(self.look.at(self.batch.first.frame, self._first_picture())))
        return image.with_pixels(self._regrown.apply(image.pixels, linear=image.linear))

    def _first_picture(self) -> Image | None:
        first = self.batch.first
        if self.batch.kind == "video":
            return next(read_frames(Path(first.source), [first.frame]))[1]
        return load(first.source) if first.source else None


class _PictureMaker(_Maker):
    """Frames that are files of their own."""

    def rows(self) -> list[Row]:
        """Make what is not done."""
        rows: dict[int, Row] = {}
        left = []
        for item in self.chunk.items:
            kept = (
                records.done(self.batch, records.frame_name(item), [Path(item.output)]) if self.batch.resume else None
            )
            if kept:
                rows[item.frame] = kept[0]
            else:
                left.append(item)
        for item, picture in self.pictures(left):
            rows[item.frame] = self._row(item, picture)
        return [rows[item.frame] for item in self.chunk.items]

    def _row(self, item: Item, picture: Image | InputError | None) -> Row:
        """Make one frame and note it."""
        started = time.perf_counter()
        row = Row(item.frame, item.source, item.output, "done")
        try:
            with hear_notices() as notes, AtomicFiles() as files:
                path = Path(item.output)
                if isinstance(picture, InputError):
                    raise picture
                drawing = self.drawing(item, picture)
                with files.place(path) as place:
                    run(drawing_file(drawing, place, named=path, quality=self.output.quality))
                row = replace(row, seconds=round(time.perf_counter() - started, 4), notes=notes)
                records.note(
                    files, self.batch, records.frame_name(item), [row], self.look.inputs(item.frame, item.source)
                )
        except Exception as fault:  # noqa: BLE001  whatever it is, it costs this frame alone
            return failed(row, fault)
        return row


class _VideoMaker(_Maker):
    """Frames of a video: all of a chunk appear as one segment."""

    def rows(self) -> list[Row]:
        """Make the segment unless it is done."""
        segment = segment_of(self.chunk)
        if self.batch.resume:
            joined = records.done(self.batch, records.JOINED, [self.batch.output])
            kept = records.done(self.batch, self.chunk.name, [] if joined is not None else [segment])
            if kept:
                return kept
        try:
            with AtomicFiles() as files:
                with files.place(segment) as place:
                    rows = self._encoded(place)
                records.note(files, self.batch, self.chunk.name, rows, self._inputs())
        except (WeftError, MemoryError) as fault:
            return [failed(Row(item.frame, item.source, item.output, "done"), fault) for item in self.chunk.items]
        return rows

    def _inputs(self) -> list[str]:
        return sorted({path for item in self.chunk.items for path in self.look.inputs(item.frame, item.source)})

    def _encoded(self, place: Path) -> list[Row]:
        """Write the segment to `place`; a frame that fails is black."""
        rows = []
        batch, begin = self.batch, self.chunk.items[0].pts
        form = form_of(batch, self.look.base)
        black = Image(np.zeros((*reversed(form.size_px), 3), np.uint8))
        with video_out.Segment(place, form) as segment:
            for item, picture in self.pictures(list(self.chunk.items)):
                started = time.perf_counter()
                row = Row(item.frame, item.source, item.output, "done")
                try:
                    with hear_notices() as notes:
                        if isinstance(picture, InputError):
                            raise picture
                        segment.append(self._drawn(item, picture), item.pts - begin)
                    row = replace(row, seconds=round(time.perf_counter() - started, 4), notes=notes)
                except Exception as fault:  # noqa: BLE001  as above
                    row = failed(row, fault)
                    segment.append(black, item.pts - begin)
                rows.append(row)
        return rows

    def _drawn(self, item: Item, picture: Image | None) -> Image:
        """Return a frame as a picture."""
        drawing = self.drawing(item, picture)
        if drawing.is_finished:
            return drawing.image
        return render_mesh(drawing.image, drawing.rest, drawing.moved, size=drawing.size, scale=drawing.scale)


def with_alpha(image: Image) -> Image:
    """Return a picture with alpha, so that all frames of a sequence have the same channels, covered or not."""
    if image.has_alpha:
        return image
    most = 1.0 if image.pixels.dtype.kind == "f" else np.iinfo(image.pixels.dtype).max
    opaque = np.full((*image.pixels.shape[:2], 1), most, image.pixels.dtype)
    return image.with_pixels(np.concatenate([image.pixels, opaque], axis=2))


def form_of(batch: Batch, base: Document) -> video_out.Form:
    """Return what all segments of a video have in common; raise `InputError` for what its codec cannot hold."""
    options = batch.recipe.table.output
    size = base.size_px if base.mode == "overlay" else batch.size_px
    aspect = base.warp.aspect if base.mode == "warp" else (1.0, 1.0)
    canvas = [max(1, round(side * factor)) for side, factor in zip(size, aspect, strict=True)]
    width, height = (max(1, round(side * options.scale)) for side in canvas)
    codec = video_out.codec_for(batch.output, options.codec)
    video_out.check_size((width, height), codec, batch.output)
    return video_out.Form(
        (width, height),
        codec,
        batch.time_base,
        batch.rate,
        batch.tags,
        options.quality,
        deep=(options.bits or batch.bits) > 8,
        alpha=options.alpha,
    )


def segment_of(chunk: Chunk) -> Path:
    """Return the file of a chunk of a video."""
    return chunk.batch.records / f"{chunk.name}.segment"


def failed(row: Row, fault: Exception) -> Row:
    """Return the row of a frame that failed; raise `DiskFullError` if all others would fail alike."""
    cause = fault.__cause__ or fault
    if isinstance(cause, OSError) and cause.errno in (errno.ENOSPC, errno.EDQUOT):
        raise DiskFullError(str(fault)) from fault
    text = str(fault) if isinstance(fault, WeftError) else f"{type(fault).__name__}: {fault}"
    text = "not enough memory" if isinstance(fault, MemoryError) else text
    return replace(row, state="failed", fault=" ".join(text.split()))
