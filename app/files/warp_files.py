"""A warp as a file of its own: written for other programs, and opened from them."""

from pathlib import Path

from app.editor.editor import Editor
from app.model.requests import OpenFile
from core.arrays import InputError
from core.document.document import Document
from core.document.map import frame_result, with_warp_map
from core.document.map_solver import settle_map
from core.files.atomic import atomic_file
from core.files.text import legible
from core.interchange.obj import obj_mesh
from core.interchange.stmap import write_st_map
from core.mapping.result import Warped
from core.progress import Job, Progress, in_one_step, part
from core.warps.map_file import Kind, read_warp_map

SUFFIXES = ("exr", "obj")
_TITLES: dict[Kind, str] = {"st": "Open an ST map as the warp", "displacement": "Open a displacement as the warp"}


def ask_open_warp(editor: Editor, kind: Kind) -> None:
    """Ask for an ST map or a displacement, and bend the picture by it."""
    editor.requests.append(OpenFile(_TITLES[kind], ("exr",), lambda path: open_warp(editor, path, kind)))


def open_warp(editor: Editor, path: Path, kind: Kind = "st") -> None:
    """Bend the picture by the warp in a file; the result has its size, and preset and handles bend it further."""
    steps = lambda: in_one_step("reading", read_warp_map, path, kind)  # noqa: E731
    editor.start(f"Warp {legible(path.name)}", steps, with_warp_map)


def write_warp(document: Document, path: Path, settled: Warped | None = None) -> Job[None]:
    """Write the warp on a canvas that holds all of it: an ST map to .exr, a mesh to .obj.

    `settled` is the document's map at rest, if that is known.
    Raises `InputError` for another ending, and for what cannot be written.
    """
    suffix = path.suffix.lower().lstrip(".")
    if suffix not in SUFFIXES:
        raise InputError(f"{path}: a warp is an .exr file, as an ST map, or an .obj file, as a mesh")
    found = settled or (yield from part(settle_map(document), 0.0, 0.6))
    yield Progress(0.6, "writing")
    canvas, moved = frame_result(document, found, "warp")
    grid = found.rest, moved, document.size_px, canvas
    with atomic_file(path) as place:
        if suffix == "obj":
            place.write_text(obj_mesh(*grid), encoding="utf-8")
        else:
            write_st_map(*grid, place, named=path)
