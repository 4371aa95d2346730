"""Weft beside other operators on a folder of pictures to retarget: the `retargeting` lists of `weft bench`.

The folder is laid out as the RetargetMe benchmark's (M. Rubinstein, D. Gutierrez, O. Sorkine and A. Shamir, "A
comparative study of image retargeting", 2010): beside NAME.png, or in a folder of it, NAME_0.75_sc.png is what the
operator "sc" made of it at 0.75 of its width or height. Without such files the widths are `SHARES`. NAME_mask.png is
what to keep; without one it is what *Resize* proposes. The sheets show the picture, what plain scaling makes of it,
Weft and the others, side by side.
"""

import re
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, TypeAlias

import cv2
import numpy as np

from app.bench.retexture_photographs import KINDS, eight_bits
from app.model.session import Resizing
from app.render.picture_file import writing
from core.arrays import Bytes, InputError
from core.document.document import Document
from core.document.map_solver import settle_map
from core.imaging.image import Image
from core.imaging.images import load, load_mask, save
from core.mapping.jacobians import as_complex, as_positions
from core.mapping.result import Warped
from core.progress import run
from core.rasters.raster import Raster
from core.selection.importance import importance, propose_objects
from core.selection.long_lines import are_long, find_lines

Record: TypeAlias = dict[str, Any]

SHARES = (0.75, 0.5)
"""Of a picture's longer side, where no operator's result says how large."""
MADE = re.compile(r"(?P<name>.+)_(?P<share>[0-9.]+)_(?P<operator>[A-Za-z]+)")
HEIGHT_PX, GAP_PX, TITLE_PX = 360, 8, 24
"""Of the pictures on a sheet, of the room between them, and of what stands over them."""


def measure(folder: Path, sheets: Path | None = None) -> list[Record]:
    """Return one record per picture and size, and write a sheet for each into the folder `sheets`, if any.

    `kept` is the share of the picture that is to keep its shape, `scale` the least that a feature got, and `bend_px`
    how far the worst of the picture's long straight lines comes out from straight.
    """
    files = sorted(path for path in [*folder.glob("*"), *folder.glob("*/*")] if path.suffix.lower() in KINDS)
    pictures = [path for path in files if not MADE.fullmatch(path.stem) and not path.stem.endswith("_mask")]
    if not pictures:
        raise InputError(f"{folder}: holds no pictures")
    return [record for path in pictures for record in _records(path, files, sheets)]


def _records(path: Path, files: list[Path], sheets: Path | None) -> list[Record]:
    """Return the records of a picture, given all files."""
    image = load(path)
    document = Document.of(image).changed(mask=Raster.from_array(_mask(path, image)))
    made: dict[tuple[str, tuple[int, int]], dict[str, Path]] = {}
    for file in files:
        match = MADE.fullmatch(file.stem)
        if match and match["name"] == path.stem:
            made.setdefault((match["share"], load(file).size_px), {})[match["operator"]] = file
    sizes = made or {(f"{share:g}", _shrunk(image.size_px, share)): {} for share in SHARES}
    return [_record(path, document, share, size, others, sheets) for (share, size), others in sizes.items()]


def _mask(path: Path, image: Image) -> Bytes:
    """Return what to keep (H, W)."""
    painted = path.with_name(f"{path.stem}_mask.png")
    return (
        load_mask(painted, image.size_px)
        if painted.exists()
        else run(propose_objects(image, run(importance(image)), Resizing().share))
    )


def _shrunk(size_px: tuple[int, int], share: float) -> tuple[int, int]:
    """Return a size with the longer side made shorter."""
    width, height = size_px
    return (round(width * share), height) if width >= height else (width, round(height * share))


def _record(
    path: Path, document: Document, share: str, size: tuple[int, int], others: dict[str, Path], sheets: Path | None
) -> Record:
    image, began = document.image, time.process_time()
    aspect = size[0] / image.width_px, size[1] / image.height_px
    resized = document.with_warp(aspect=aspect, straight=True)
    found = run(settle_map(resized))
    seconds = time.process_time() - began
    if sheets is not None:
        sheets.mkdir(parents=True, exist_ok=True)
        picture = eight_bits(image.pixels)
        with tempfile.TemporaryDirectory() as room:
            run(writing(resized, own := Path(room) / "weft.png", frame="picture"))
            weft = eight_bits(load(own).pixels)
        scaled = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
        shown = {"picture": picture, "scaled": scaled, "weft": weft}
        shown |= {name: eight_bits(load(file).pixels) for name, file in sorted(others.items())}
        save(Image(sheet(shown)), sheets / f"{path.stem}_{share}.png")
    if sys.stderr.isatty():
        sys.stderr.write(f"{path.stem} {share}\n")
    return {"name": path.stem, "size": list(size), **_figures(resized, found), "others": len(others), "cpu_s": seconds}


def _figures(document: Document, found: Warped) -> Record:
    """Return what a map keeps."""
    image = document.image
    lines = find_lines(image)
    bends = [_bend(found, start, end) for start, end in lines[are_long(lines, image.size_px)]]
    return {
        "kept": float((document.mask.array > 127).mean()),
        "features": len(found.features),
        "scale": min((feature.scale for feature in found.features), default=1.0),
        "residual": max((feature.residual for feature in found.features), default=0.0),
        "folds": int(found.folded.sum()),
        "bend_px": max(bends, default=0.0),
    }


def _bend(found: Warped, start: np.ndarray[Any, Any], end: np.ndarray[Any, Any]) -> float:
    """Return how far a line's farthest point is from the straight line that fits it best, in pixels."""
    at = start + (end - start) * np.linspace(0, 1, 60)[:, None]
    there = as_positions(found.grid.read(at, as_complex(found.warped).ravel()))
    there = there - there.mean(axis=0)
    return float(np.abs(there @ np.linalg.svd(there, full_matrices=False)[2][1]).max())


def sheet(shown: dict[str, Bytes]) -> Bytes:
    """Return pictures (H, W, 3) side by side and of one height, each under its name."""
    columns: list[Bytes] = []
    for name, pixels in shown.items():
        width = max(round(pixels.shape[1] * HEIGHT_PX / pixels.shape[0]), 1)
        picture = cv2.resize(pixels, (width, HEIGHT_PX), interpolation=cv2.INTER_AREA)
        title = np.full((TITLE_PX, width, 3), 255, np.uint8)
        cv2.putText(title, name, (2, TITLE_PX - 8), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (0, 0, 0), 1, cv2.LINE_AA)
        gap = np.full((TITLE_PX + HEIGHT_PX, GAP_PX, 3), 255, np.uint8)
        columns += [np.concatenate([title, np.asarray(picture, np.uint8)]), gap]
    return np.concatenate(columns[:-1], axis=1)
