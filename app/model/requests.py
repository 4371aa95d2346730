"""What the editor asks of the window, as plain data: a file to choose, a question to answer.

The window shows the newest request as a dialog and calls `then` with the answer; closing the dialog drops the
request. Tests answer in its place.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias

from app.model.orbit import Orbit
from core.canvas import Framing
from core.document.document import Document
from core.mapping.result import Warped

Changed: TypeAlias = Literal["overwrite", "reload", "save_as", "cancel"]
Panel: TypeAlias = Literal[
    "keys",
    "palette",
    "history",
    "about",
    "preferences",
    "layout",
    "full-screen",
    "tour-warp",
    "tour-retexture",
    "tour-overlay",
]
Unsaved: TypeAlias = Literal["save", "discard", "cancel"]
Writing: TypeAlias = Literal["wait", "stop", "cancel"]

PICTURES = ("png", "jpg", "jpeg", "tif", "tiff", "webp", "exr", "jxl")
PROJECTS = ("weft",)


def complete(path: Path, extensions: tuple[str, ...]) -> Path:
    """Return `path` with the first of `extensions`, without the dot, behind a name that ends in none of them.

    What has no name, such as `/`, stays.
    """
    is_whole = path.suffix.lower().lstrip(".") in extensions
    return path if is_whole or not path.name else path.with_name(f"{path.name}.{extensions[0]}")


@dataclass(frozen=True, eq=False)
class OpenFile:
    """Choose a file that exists."""

    title: str
    extensions: tuple[str, ...]
    """Without the dot."""
    then: Callable[[Path], None]


@dataclass(frozen=True, eq=False)
class SaveFile:
    """Choose where to write."""

    title: str
    extensions: tuple[str, ...]
    suggested: Path
    then: Callable[[Path], None]


@dataclass(frozen=True)
class ExportOptions:
    """How a picture is exported."""

    path: Path
    size_px: tuple[int, int]
    """Width and height of the file's picture."""
    frame: Framing = "picture"
    bits: Literal[8, 16, 32] | None = None
    """Depth of a sample, 32 meaning float; None for the depth of the source as far as the format goes."""
    quality: int = 92
    """Of JPEG and WebP, 1 to 100."""
    view: Orbit | None = None
    """Where the camera is, for a picture of the surface in space; None for the result itself."""
    settled: Warped | None = field(default=None, compare=False, repr=False)
    """The document's map at rest, where that is known."""


@dataclass(frozen=True, eq=False)
class ExportPicture:
    """Choose how and where to export; the dialog opens on `options`."""

    document: Document
    options: ExportOptions
    then: Callable[[ExportOptions], None]


@dataclass(frozen=True, eq=False)
class AskUnsaved:
    """Ask whether unsaved changes are to be saved."""

    name: str
    """What would be lost, as the artist knows it."""
    then: Callable[[Unsaved], None]


@dataclass(frozen=True, eq=False)
class AskChanged:
    """Ask what is to become of a project that somebody else has written since it was opened."""

    name: str
    then: Callable[[Changed], None]


@dataclass(frozen=True, eq=False)
class AskWriting:
    """Ask what is to become of files that are still being written while the artist wants to leave."""

    names: tuple[str, ...]
    """The jobs, as the artist knows them."""
    then: Callable[[Writing], None]


@dataclass(frozen=True)
class Offer:
    """A state of unsaved work, as the artist knows it."""

    name: str
    folder: str
    """Where it was saved before, or where its picture lies; empty for neither."""
    kept_at: float
    """In seconds of the system's clock."""
    earlier: bool = False
    """Whether it is an earlier state of a document that is on offer, too."""
    picture: Path | None = None
    """A small picture's file."""


@dataclass(frozen=True, eq=False)
class AskRecover:
    """Offer work that an earlier run left unsaved."""

    offers: tuple[Offer, ...]
    """The newest first."""
    then: Callable[[int | None], None]
    """Takes the number of the offer to open, the others stay; None discards them all."""


@dataclass(frozen=True, eq=False)
class ShowPanel:
    """Show one of the window's own panels."""

    panel: Panel


Request: TypeAlias = OpenFile | SaveFile | ExportPicture | AskUnsaved | AskChanged | AskWriting | AskRecover | ShowPanel
