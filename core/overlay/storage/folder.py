"""The parts of a decomposition as a folder of files."""

import contextlib
import json
import warnings
import zlib
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, cast

import numpy as np

from core.arrays import Bools, Floats, InputError, Singles
from core.files.atomic import atomic_folder
from core.files.json_file import read_json
from core.files.npy_file import read_npz, write_npz
from core.imaging import color
from core.imaging.images import Image, load
from core.imaging.images import write as write_picture
from core.overlay.composition import finite
from core.overlay.decomposition import Decomposition
from core.overlay.detection.lattice import Lattice
from core.overlay.filters.bands import bands
from core.overlay.laying.compositing import Parts, texture_colours
from core.overlay.registration.region import feather

PARTS = (
    *("source.png", "texel.png", "reconstruction.png", "report.json", "lattice.json"),
    *("texture_coords.npz", "shading.npz", "detail.npz", "coverage.npz"),
)
"""The files of a folder."""
MOST_STEPS, FARTHEST_PX = 10_000, 100_000
"""Coordinates of a vertex and of its place may be so large."""


def write(found: Decomposition, source: Image, folder: Path) -> None:
    """Write the parts into `folder`, which appears whole or stays as it was."""
    pictures = {"source": source, "texel": picture(found.texel.pixels), "reconstruction": picture(found.reconstruction)}
    arrays = {
        "texture_coords": {"uv": found.uv},
        "shading": {"shading": found.shading},
        "detail": {"detail": found.detail},
        "coverage": {"coverage": found.coverage},
    }
    run = np.uint32(zlib.crc32(found.detail.data, zlib.crc32(found.uv.data)))
    # What takes long is packing, and that is done without Python's lock.
    with atomic_folder(folder) as place, ThreadPoolExecutor(2) as writers:
        packed = [
            writers.submit(write_npz, place / f"{name}.npz", run=run, **values)
            for name, values in sorted(arrays.items(), key=lambda pair: -sum(a.nbytes for a in pair[1].values()))
        ]
        for name, image in pictures.items():
            file = f"{name}.png"
            packed.append(writers.submit(write_picture, image, place / file, named=folder / file))
        for done in packed:
            done.result()
        (place / "lattice.json").write_text(json.dumps(lattice_json(found.lattice)), encoding="utf-8")
        (place / "report.json").write_text(json.dumps(report(found), indent=1) + "\n", encoding="utf-8")


def picture(values: Floats | Singles) -> Image:
    """Return values (H, W, 3) on the 0 to 1 scale as an 8-bit picture."""
    pixels = np.empty(values.shape, np.uint8)
    for _, top, bottom, _ in bands(values.shape, margin=0):
        pixels[top:bottom] = color.quantise(values[top:bottom].astype(np.float32), np.uint8)
    return Image(pixels)


def report(found: Decomposition) -> dict[str, object]:
    """Return what `report.json` holds."""
    return {
        "image": list(found.photo.shape[:2]),
        "texel_size": texel_size(found),
        "basis": found.basis.tolist(),
        "lattice_vertices": len(found.lattice),
        "coverage": float(found.covered.mean()),
        "seconds": found.seconds,
    }


def texel_size(found: Decomposition) -> list[float]:
    """Return the usual height and width of a texel in the photo, pixels."""
    bases = found.lattice.frames.bases if len(found.lattice) else found.basis[None]
    width, height = np.median(np.linalg.norm(bases, axis=1), axis=0)
    return [float(height), float(width)]


def lattice_json(lattice: Lattice) -> dict[str, object]:
    """Return what `lattice.json` holds."""
    rows = zip(lattice.keys.tolist(), lattice.frames.points.tolist(), lattice.frames.scores.tolist(), strict=True)
    return {"vertices": [{"lattice": key, "at": point, "likeness": score} for key, point, score in rows]}


def read_lattice(path: Path) -> tuple[list[tuple[int, int]], list[tuple[float, float]]]:
    """Read integer coordinates and positions from a `lattice.json`.

    Raises `InputError` that names the file and the fault: not JSON, a vertex without numbers, a doubled vertex.
    """
    try:
        rows = [(vertex["lattice"], vertex["at"]) for vertex in read_json(path)["vertices"]]
        keys = [(float(i), float(j)) for (i, j), _ in rows]
        points = [(float(x), float(y)) for _, (x, y) in rows]
    except (ValueError, KeyError, TypeError, OverflowError):
        raise InputError(f"{path}: not a lattice: vertices with whole 'lattice' and 'at' pairs are expected") from None
    for key, point in zip(keys, points, strict=True):
        if not all(number.is_integer() for number in key) or not np.isfinite(point).all():
            raise InputError(f"{path}: a vertex has coordinates that are not whole, or a position that is not finite")
        if max(map(abs, key)) > MOST_STEPS or max(map(abs, point)) > FARTHEST_PX:
            raise InputError(f"{path}: vertex {[int(number) for number in key]} lies out of all bounds")
    doubled = next((key for key, times in Counter(keys).items() if times > 1), None)
    if doubled is not None:
        raise InputError(f"{path}: vertex {[int(number) for number in doubled]} comes twice")
    return [(int(i), int(j)) for i, j in keys], points


def read(folder: Path) -> Parts:
    """Read the parts that `write` left in `folder`.

    Raises `InputError` that names the file if one is missing, damaged, or of another picture.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: not a folder of a decomposition")
    source = load(folder / "source.png")
    shape = (source.height_px, source.width_px)
    check_one_run(folder)
    uv = array(folder / "texture_coords.npz", "uv", [(*shape, 2)])
    covered = finite(uv)
    if not covered.any():
        raise InputError(f"{folder / 'texture_coords.npz'}: covers no pixel")
    basis = read_report(folder / "report.json", shape)
    shading = array(folder / "shading.npz", "shading", [shape, (*shape, 3)], covered)
    detail = array(folder / "detail.npz", "detail", [(*shape, 3)], covered)
    # Another program's folder need not have these two.
    soft, edge = folder / "coverage.npz", feather(covered)
    return Parts(
        source,
        uv=uv,
        shading=shading,
        detail=detail,
        coverage=array(soft, "coverage", [shape], covered) if soft.exists() else edge,
        basis=basis_of(uv, folder / "texture_coords.npz") if basis is None else basis,
        texel=texture_colours(load(folder / "texel.png"))[..., :3],
    )


def check_one_run(folder: Path) -> None:
    """Raise `InputError` if arrays in `folder` say that they come from different runs; those of others say nothing."""
    runs: dict[int, str] = {}
    for name in sorted(name for name in PARTS if name.endswith(".npz")):
        with contextlib.suppress(InputError):
            runs.setdefault(int(read_npz(folder / name, "run", [()])), name)
    if len(runs) > 1:
        raise InputError(f"{folder}: mixed: {' and '.join(runs.values())} come from different decompositions")


def basis_of(uv: Singles, path: Path) -> Floats:
    """Return the usual vectors (2, 2) of texels, pixels, from coordinates (H, W, 2)."""
    slopes = [np.diff(uv, axis=axis)[: len(uv) - 1, : uv.shape[1] - 1] for axis in (1, 0)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        usual = np.stack([np.nanmedian(slope.reshape(-1, 2), axis=0) for slope in slopes], -1).astype(np.float64)
    if not abs(np.linalg.det(usual)) > 1e-9:
        raise InputError(f"{path}: 'uv' does not span the plane")
    return np.asarray(np.linalg.inv(usual), np.float64)


def read_report(path: Path, shape: tuple[int, int]) -> Floats | None:
    """Return the basis (2, 2) that a report holds, if any, after checking that it is of a picture of that size."""
    try:
        found = cast("dict[str, Any]", read_json(path))
        image, basis = found["image"], np.asarray(found.get("basis", np.eye(2)), np.float64)
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError):
        raise InputError(f"{path}: not the report of a decomposition") from None
    if not np.isfinite(basis).all():
        raise InputError(f"{path}: 'basis' holds NaN or infinity")
    if image != list(shape):
        raise InputError(f"{path}: is of a picture of {image}, not of {list(shape)} as source.png")
    if basis.shape != (2, 2) or not abs(np.linalg.det(basis)) > 1e-6:
        raise InputError(f"{path}: 'basis' does not span the plane")
    return basis if "basis" in found else None


def array(path: Path, key: str, shapes: list[tuple[int, ...]], covered: Bools | None = None) -> Singles:
    """Return the array `key` of an .npz file, of one of the given shapes and finite where there is cloth (H, W)."""
    with np.errstate(over="ignore"):  # what is too large for a single becomes infinite, and is refused so
        values = read_npz(path, key, shapes).astype(np.float32, copy=False)
    if covered is not None and not (np.isfinite(values).reshape(*covered.shape, -1).all(-1) | ~covered).all():
        raise InputError(f"{path}: '{key}' is not finite on all of the cloth that texture_coords.npz covers")
    return values
