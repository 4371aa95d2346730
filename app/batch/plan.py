"""Which frames a batch has, from which pictures they come, to which files they go, and how they are cut into chunks."""

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Literal, TypeAlias

from app.batch import video_in
from app.batch.frames import frames_on_disk, is_numbered, numbered, parse_frames, unnumbered
from app.batch.recipe import Recipe, RecipeTable
from app.batch.video_in import UNTAGGED, Tags
from core.arrays import InputError
from core.document.animated import is_animated
from core.document.document import Document
from core.document.keys import Span
from core.document.project import load_project
from core.files.atomic import check_outputs
from core.files.faults import make_folder
from core.imaging.images import SUFFIXES, check_writable_format
from core.imaging.reading import header_of

Kind: TypeAlias = Literal["still", "pictures", "sequence", "video"]
VIDEOS = (".mov", ".mp4", ".mkv", ".avi", ".webm", ".mxf", ".nut", ".m4v")
VIDEOS_WRITTEN = (".mov", ".mp4", ".mkv")
_GLOB = frozenset("*?[")
_ROUNDED = 0.005
"""Rates are typed with two decimals or more."""


@dataclass(frozen=True)
class Item:
    """One frame to make."""

    frame: int
    """Its number, which key frames and numbered names go by; of a list of pictures, the place in it, from 1 on."""
    source: str
    """The picture that it comes from; "" for the project's own, for a frame of a video the video."""
    output: str
    """The picture to write, or the video that it becomes a frame of."""
    pts: int = 0
    """When it is shown in a video, in `Batch.time_base`."""


@dataclass(frozen=True)
class Batch:
    """What all chunks of a batch share; plain data, so that it can be sent to another machine."""

    recipe: Recipe
    kind: Kind
    first: Item
    """The first frame whose picture can be read: sequences keep to its size, and to the texture found in it."""
    size_px: tuple[int, int]
    """Width and height of that picture."""
    bits: int
    """Its bits a sample."""
    output: Path
    records: Path
    """The folder that says what is done."""
    digest: str
    """Of all that is the same for every frame; what another recipe made is not taken for done."""
    writes_video: bool = False
    time_base: Fraction = Fraction(1, 24)
    rate: Fraction = Fraction(24)
    tags: Tags = UNTAGGED
    frames: Sequence[int] = ()
    """Numbers of all frames, in order."""
    resume: bool = False


@dataclass(frozen=True)
class Chunk:
    """Frames that one process makes, one after another."""

    batch: Batch
    number: int
    items: tuple[Item, ...]

    @property
    def name(self) -> str:
        """What its files among the records begin with."""
        return f"chunk-{self.number:05d}"


def plan(
    recipe: Recipe, output: Path, *, pictures: Sequence[str] = (), frames: str | None = None, resume: bool = False
) -> list[Chunk]:
    """Return the chunks of a batch.

    `pictures` and `frames` take the place of what the recipe says. Raises `InputError` for what cannot be begun: no
    pictures, no place to write to, a mask of another size.
    """
    table = recipe.table
    output = output.absolute()
    places = [Path(name).absolute() for name in pictures] or [recipe.place(name) for name in table.picture]
    chosen = frames or table.frames
    wanted = parse_frames(chosen) if chosen else None
    kind, sources, clip = _sources(recipe, places, wanted)
    items = [Item(number, source, _target(output, number, source)) for number, source in sources]
    writes_video = output.suffix.lower() in VIDEOS_WRITTEN
    _check_targets(items, output, table, writes_video=writes_video)
    first, (size_px, bits) = _first_of(kind, items, recipe, clip)
    batch = Batch(recipe, kind, first, size_px, bits, output, records_of(output), _digest(recipe, kind), writes_video)
    rate = table.output.frames_per_second or (_rate_of(recipe) if writes_video else batch.rate)
    numbers = tuple(item.frame for item in items)
    whole = range(numbers[0], numbers[-1] + 1)
    batch = replace(batch, rate=rate, time_base=1 / rate, resume=resume)
    batch = replace(batch, frames=whole if len(whole) == len(numbers) else numbers)
    if clip is None:
        items = [replace(item, pts=place) for place, item in enumerate(items)]
    else:
        begin = clip.pts[items[0].frame - 1]
        items = [replace(item, pts=clip.pts[item.frame - 1] - begin) for item in items]
        batch = replace(batch, rate=clip.rate, time_base=clip.time_base, tags=clip.tags)
    return list(_cut(batch, items, table.chunk))


def _rate_of(recipe: Recipe) -> Fraction:
    """Return the rate of a project's timeline, 29.97 as 30000/1001; 24 frames a second where there is no project."""
    rate = Span().rate if recipe.project is None else load_project(recipe.project).span.rate
    broadcast = Fraction(1000 * round(rate * 1.001), 1001)
    return broadcast if abs(rate - broadcast) < _ROUNDED else Fraction(rate).limit_denominator(1000)


def shard(chunks: Sequence[Chunk], number: int, count: int) -> list[Chunk]:
    """Return the chunks of share `number`, from 1 on, of `count`."""
    return [chunk for chunk in chunks if chunk.number % count == number - 1]


def _cut(batch: Batch, items: Sequence[Item], length: int) -> Iterator[Chunk]:
    for number, begin in enumerate(range(0, len(items), length)):
        yield Chunk(batch, number, tuple(items[begin : begin + length]))


def _sources(
    recipe: Recipe, places: Sequence[Path], frames: tuple[int, ...] | None
) -> tuple[Kind, list[tuple[int, str]], video_in.Clip | None]:
    """Return what the sources are, the frames' numbers and sources, and the video, if it is one."""
    one = places[0] if len(places) == 1 else None
    if not places:
        if recipe.project is None:
            raise InputError(f"{recipe.path}: names no picture")
        return "still", [(number, "") for number in frames or _frames_of(load_project(recipe.project))], None
    if one is not None and is_numbered(one.name):
        numbers = frames if frames is not None else frames_on_disk(one)
        if not numbers:
            raise InputError(f"{one}: there is no such frame")
        return "sequence", [(number, str(one.with_name(numbered(one.name, number)))) for number in numbers], None
    if one is not None and one.suffix.lower() in VIDEOS:
        clip = video_in.index(one)
        numbers = frames if frames is not None else tuple(range(1, len(clip.pts) + 1))
        if numbers[0] < 1 or numbers[-1] > len(clip.pts):
            raise InputError(f"{one}: has frames 1 to {len(clip.pts)}, not {numbers[0]} to {numbers[-1]}")
        return "video", [(number, str(one)) for number in numbers], clip
    if one is not None and frames is not None and one.is_file():
        return "still", [(number, str(one)) for number in frames], None
    files = list(dict.fromkeys(file for place in places for file in _files(place)))
    chosen = [(number, str(file)) for number, file in enumerate(files, 1) if frames is None or number in set(frames)]
    if not chosen:
        raise InputError(f"{places[0]}: no picture is among the frames")
    return "pictures", chosen, None


def _frames_of(document: Document) -> Sequence[int]:
    """Return the frames of a project's timeline; of one without keys, one frame."""
    span = document.span
    return range(span.first, span.last + 1) if is_animated(document) else (1,)


def _files(place: Path) -> list[Path]:
    """Return the pictures that a name, a pattern with wildcards or a folder stands for, in the order of their names."""
    if place.is_dir():
        found = sorted(file for file in place.iterdir() if file.suffix.lower() in SUFFIXES and file.is_file())
    elif _GLOB & set(place.name) and not place.exists():
        found = sorted(file for file in place.parent.glob(place.name) if file.is_file())
    else:
        return [place]
    if not found:
        raise InputError(f"{place}: there is no such picture")
    return found


def _target(output: Path, frame: int, source: str) -> str:
    """Return the file that a frame goes to."""
    if output.suffix.lower() in VIDEOS_WRITTEN:
        return str(output)
    own = Path(source or "frame.png")
    if output.is_dir() or not output.suffix:
        stem = f"{own.stem}.{frame:04d}" if own.suffix.lower() in VIDEOS or not source else own.stem
        return str(output / f"{stem}{own.suffix if own.suffix.lower() in SUFFIXES else '.png'}")
    return str(output.with_name(numbered(output.name, frame).replace("{name}", own.stem)))


def _check_targets(items: Sequence[Item], output: Path, table: RecipeTable, *, writes_video: bool) -> None:
    """Raise `InputError` unless the frames go to files of their own, or all to one video."""
    sources = {item.source for item in items}
    if writes_video:
        if table.output.frame == "warp" or "size" in table.keys:
            raise InputError(f"{output}: frames of a video have one size; write pictures, or keep the picture's frame")
        if str(output) in sources:
            raise InputError(f"{output}: would be written over, but it is read")
        output.parent.mkdir(parents=True, exist_ok=True)
        check_outputs([output])
        return
    taken: dict[str, Item] = {}
    for item in items:
        before = taken.setdefault(item.output, item)
        if before is not item:
            raise InputError(f"{output}: frames {before.frame} and {item.frame} go to one file; put #### in its name")
        if item.output in sources:
            raise InputError(f"{item.output}: would be written over, but it is read")
    target = Path(items[0].output)
    check_writable_format(target)
    make_folder(target.parent)
    check_outputs([target])


def _first_of(
    kind: Kind, items: Sequence[Item], recipe: Recipe, clip: video_in.Clip | None
) -> tuple[Item, tuple[tuple[int, int], int]]:
    """Return the first frame whose picture can be read, its width and height, and its bits a sample."""
    if clip is not None:
        return items[0], (clip.size_px, clip.bits)
    if not items[0].source:
        assert recipe.project is not None
        own = load_project(recipe.project).image
        return items[0], (own.size_px, own.pixels.dtype.itemsize * 8)
    fault: InputError | None = None
    for item in items:
        try:
            return item, header_of(Path(item.source))
        except InputError as found:
            fault = fault or found
    assert fault is not None
    raise fault


def records_of(output: Path) -> Path:
    """Return the folder for the records of what goes to `output`."""
    if output.is_dir() or (not output.suffix and not is_numbered(output.name)):
        return output / "weft.batch"
    plain = unnumbered(output.name).replace("{name}", "").replace("..", ".").strip("._-")
    return output.with_name(f"{plain}.batch")


def _digest(recipe: Recipe, kind: Kind) -> str:
    """Return a digest of the recipe and of the files that hold for every frame."""
    table = recipe.table
    found = hashlib.sha256(json.dumps([recipe.data, kind], sort_keys=True, default=str).encode())
    for name in (table.project, table.handles, table.mask, table.stmap, table.displacement):
        place = None if name is None else recipe.place(name)
        if place is not None and place.is_file():
            found.update(hashlib.sha256(place.read_bytes()).digest())
    return found.hexdigest()[:32]
