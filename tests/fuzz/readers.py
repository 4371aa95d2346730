"""What the program reads: for each kind of file, good ones, how they are damaged, and the reader that answers."""

import io
import json
import os
import random
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from app.files.document_io import recent_files
from app.state.preferences import load_preferences
from app.state.rescues import find
from core.arrays import WeftError
from core.curves import feature_curves
from core.document import handles_file
from core.document.document import CurvePair, Document, Outline, Pin
from core.document.map_solver import MapSolver
from core.document.project import load_project, save_project
from core.imaging.images import Attribute, Image, load, load_mask, save
from core.notices import hear_notices
from core.overlay.storage import folder as parts_folder
from tests.fuzz.mutations import damaged_bytes, damaged_npy, damaged_tree, npy, written, zipped

SIZE = (24, 18)


@dataclass(frozen=True)
class Reader:
    """A kind of file: how a malformed one is made at a path, and who reads it."""

    make: Callable[[Path, random.Random], None]
    read: Callable[[Path], object]
    name: str
    """Of the file."""


def answers(reader: Reader, seed: int, folder: Path) -> bool:
    """Make the file of a seed and read it; return whether it was taken.

    A refusal in one line is an answer; every other exception is a fault of the program and is let through.
    """
    path = folder / reader.name
    reader.make(path, random.Random(seed))
    try:
        with hear_notices():
            reader.read(path)
    except WeftError as fault:
        line = str(fault)
        assert line, "refused without a word"
        assert "\n" not in line, f"refused in several lines: {line}"
        return False
    return True


def _picture() -> Image:
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    colours = np.stack([x * 9, y * 11, (x + y) * 5], axis=-1).astype(np.uint8)
    return Image(colours, metadata=(Attribute("Artist", "string", "A"), Attribute("Exif:FNumber", "float", 2.8)))


@cache
def _good_picture(suffix: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{suffix}"
        save(_picture(), path)
        return path.read_bytes()


def _picture_reader(suffix: str) -> Reader:
    def make(path: Path, draw: random.Random) -> None:
        path.write_bytes(damaged_bytes(_good_picture(suffix), draw))

    return Reader(make, load, f"a{suffix}")


LINE = [[2.0, 9.0], [8.0, 9.0], [14.0, 9.0], [20.0, 9.0]]
CURVES: Any = {
    "curves": [
        {"source": LINE, "target": [[x, y + 3] for x, y in LINE], "closed": False, "passive": False},
        {"source": [[4.0, 3.0], [8.0, 1.0], [12.0, 1.0], [16.0, 3.0]], "passive": True},
    ]
}
HANDLES: Any = {
    "pins": [{"at": [5.0, 5.0], "to": [7.0, 6.0]}, {"at": [15.0, 12.0], "to": [15.0, 12.0]}],
    "curves": [{"source": LINE, "target": [[x, y + 2] for x, y in LINE]}],
    "outline": {
        "top": [[0, 0], [8, 0], [16, 0], [23, 0]],
        "right": [[23, 0], [23, 6], [23, 12], [23, 17]],
        "bottom": [[23, 17], [16, 17], [8, 17], [0, 17]],
        "left": [[0, 17], [0, 12], [0, 6], [0, 0]],
    },
}
LATTICE: Any = {"vertices": [{"lattice": [i, j], "at": [4.0 + 6 * i, 3.0 + 5 * j]} for i in range(3) for j in range(3)]}


def _json_reader(good: Any, read: Callable[[Path], object], name: str) -> Reader:
    def make(path: Path, draw: random.Random) -> None:
        path.write_bytes(written(damaged_tree(good, draw), draw))

    return Reader(make, read, name)


@cache
def _good_project() -> tuple[dict[str, bytes], Any]:
    """Return the members of a project with something of everything, and its tree."""
    curve = CurvePair(np.array(LINE) / SIZE, np.array(LINE) / SIZE + 0.05)
    start = Document.of(_picture())
    document = start.with_warp(preset="perspective", values={"top-left-x": 10.0}, cell_px=6.0).changed(
        pins=(Pin((0.2, 0.2), (0.3, 0.3)),),
        curves=(curve,),
        outline=Outline.straight(),
        feature_curves=(curve,),
        matte=start.mask.inverted,
    )
    document = document.with_cloth(texture=_picture(), texture_name="a.png")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.weft"
        save_project(document, path)
        with zipfile.ZipFile(path) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
    tree = json.loads(members["weft.json"])
    members["outline.ring.npy"] = npy(np.array(tree["document"]["outline"]["ring"]))
    tree["document"]["outline"]["ring"] = {"file": "outline.ring.npy"}
    return members, tree


def _make_project(path: Path, draw: random.Random) -> None:
    members, tree = dict(_good_project()[0]), _good_project()[1]
    members["weft.json"] = json.dumps(tree).encode()
    if draw.randrange(3):
        members["weft.json"] = written(damaged_tree(tree, draw), draw)
    if draw.randrange(3) == 0:
        name = draw.choice(sorted(members))
        match draw.randrange(4):
            case 0:
                del members[name]
            case 1:
                members[name] = members[draw.choice(sorted(members))]
            case _:
                damage = damaged_npy if name.endswith(".npy") else damaged_bytes
                members[name] = damage(members[name], draw)
    path.write_bytes(zipped(members, draw))


def _read_project(path: Path) -> None:
    """Read a project and answer its map."""
    warped = MapSolver().frame(load_project(path)).warped
    assert np.isfinite(warped).all(), "a map with NaN or infinity"


def _make_folder(path: Path, draw: random.Random) -> None:
    path.mkdir(exist_ok=True)
    height, width = SIZE[1], SIZE[0]
    y, x = np.mgrid[:height, :width].astype(np.float32)
    arrays = {
        "texture_coords": ("uv", np.stack([x / 5, y / 5], axis=-1)),
        "shading": ("shading", np.ones((height, width), np.float32)),
        "detail": ("detail", np.zeros((height, width, 3), np.float32)),
        "coverage": ("coverage", np.ones((height, width), np.float32)),
    }
    bad = draw.choice([*arrays, "source.png", "texel.png", "report.json"])
    for name, (key, values) in arrays.items():
        data = npy(values)
        data = damaged_npy(data, draw) if bad == name else data
        key = draw.choice((key, key, key, "other", "../a", "")) if bad == name else key
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w") as archive:
            archive.writestr(f"{key}.npy", data)
        whole = buffer.getvalue()
        (path / f"{name}.npz").write_bytes(
            damaged_bytes(whole, draw) if bad == name and draw.randrange(4) == 0 else whole
        )
    for name in ("source.png", "texel.png"):
        good = _good_picture(".png")
        (path / name).write_bytes(damaged_bytes(good, draw) if bad == name else good)
    report = {"image": [height, width], "texel_size": [5, 5], "basis": [[5.0, 0.0], [0.0, 5.0]], "coverage": 1.0}
    text = written(damaged_tree(report, draw), draw) if bad == "report.json" else json.dumps(report).encode()
    (path / "report.json").write_bytes(text)


def _make_rescue(path: Path, draw: random.Random) -> None:
    path.mkdir(exist_ok=True)
    (path / "a.weft").write_bytes(b"x")
    (path / "a.json").write_bytes(
        written(damaged_tree({"name": "a.png", "project": None, "source": "/a/a.png"}, draw), draw)
    )


PREFERENCES = {"undo_mb": 512.0, "scale": 1.0, "keep_every_s": 5.0, "drafts": True}
READERS: dict[str, Reader] = {
    **{suffix[1:]: _picture_reader(suffix) for suffix in (".png", ".tif", ".exr", ".jpg", ".webp")},
    "mask": Reader(_picture_reader(".png").make, lambda path: load_mask(path, SIZE), "mask.png"),
    "curves": _json_reader(CURVES, feature_curves.read, "curves.json"),
    "handles": _json_reader(HANDLES, lambda path: handles_file.read(path, SIZE), "handles.json"),
    "lattice": _json_reader(LATTICE, parts_folder.read_lattice, "lattice.json"),
    "project": Reader(_make_project, _read_project, "a.weft"),
    "folder": Reader(_make_folder, parts_folder.read, "parts"),
    "preferences": _json_reader(PREFERENCES, load_preferences, "preferences.json"),
    "recent": _json_reader(["/a/b.png", "/c.weft"], recent_files, "recent.json"),
    "rescue": Reader(_make_rescue, find, "recovery"),
}
"""Every reader by a short name."""


def scratch() -> tempfile.TemporaryDirectory[str]:
    """Return a folder for the files, in memory where there is such a place."""
    memory = Path("/dev/shm")
    return tempfile.TemporaryDirectory(prefix="weft-fuzz-", dir=memory if os.access(memory, os.W_OK) else None)
