"""A warp as a file of its own, for programs that do it to pictures of theirs."""

from pathlib import Path

from core.arrays import InputError
from core.canvas import Canvas
from core.document.document import Document
from core.document.map import settled
from core.files.atomic import atomic_file
from core.interchange.obj import obj_mesh
from core.interchange.stmap import write_st_map
from core.progress import Job, Progress, part

SUFFIXES = ("exr", "obj")


def writing_warp(document: Document, path: Path) -> Job[None]:
    """Write the warp on a canvas that holds all of it: an ST map to .exr, a mesh to .obj.

    Raises `InputError` for another ending, and for what cannot be written.
    """
    suffix = path.suffix.lower().lstrip(".")
    if suffix not in SUFFIXES:
        raise InputError(f"{path}: a warp is an .exr file, as an ST map, or an .obj file, as a mesh")
    found = yield from part(settled(document), 0.0, 0.6)
    yield Progress(0.6, "writing")
    canvas = Canvas.around(found.warped)
    grid = found.rest, canvas.placed(found.warped), document.size_px, canvas
    with atomic_file(path) as place:
        if suffix == "obj":
            place.write_text(obj_mesh(*grid), encoding="utf-8")
        else:
            write_st_map(*grid, place, named=path)
