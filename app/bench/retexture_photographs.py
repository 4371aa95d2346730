"""Retexture beside the plain deformation on a folder of pictures: the `retexture-photographs` lists of `weft bench`.

A folder holds pictures and, for each, curves drawn on it: NAME.curves.json; NAME_anything.curves.json are other curves
of the same picture. The names are split into two fixed halves, so that what was tuned on one is judged by the other.
Figures do not see what an eye does: the sheets show both side by side, enlarged.
"""

import hashlib
import sys
import time
from pathlib import Path
from typing import Any, TypeAlias

import cv2
import numpy as np

from core.arrays import Bytes, InputError
from core.curves import feature_curves
from core.curves.edge_snapping import snap_to_edge
from core.curves.feature_curves import FeatureCurve
from core.files.faults import faults_named
from core.imaging import color
from core.imaging.image import Image
from core.imaging.images import load, save
from core.progress import run
from core.retexture.job import retexture
from core.retexture.magnification import bands
from core.retexture.result import Retexture

Record: TypeAlias = dict[str, Any]

MOST_EXCESS = 0.02
"""Of no band may a larger share be magnified than in the plain deformation and this besides."""
KINDS = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".webp")
AROUND_PX, GAP_PX, SIDE_PX = 60, 8, 1200
"""Sheets show so much around what moves, both pictures so far apart, each at most so large."""
LEAST_ZOOM, MOST_ZOOM = 2.0, 4.0
SAMPLES = 200
"""Of each curve, to find what moves."""
STILL = 0.15
"""Parts of curves that move less than this share of the farthest are not looked at."""


def measure(folder: Path, sheets: Path | None = None) -> list[Record]:
    """Return one record per file of curves: its half, 0 or 1, what is regrown, and what that magnifies.

    `regrown` is the share of the picture; `excess` the most by which the magnified share of a band along the curves is
    larger than in the plain deformation. Sheets are written into the folder `sheets`, if any.
    """
    files = sorted(folder.glob("*.curves.json"))
    if not files:
        raise InputError(f"{folder}: holds no curves, NAME.curves.json")
    return [_record(file, sheets) for file in files]


def summarise(records: list[Record]) -> list[Record]:
    """Return the share of the pictures that hold, of each half and of both, and means of their figures."""
    rows: list[Record] = []
    for half in (0, 1, None):
        own = [record for record in records if half is None or record["half"] == half]
        means = {key: float(np.mean([record[key] for record in own])) for key in ("holds", "regrown", "cpu_s") if own}
        rows.append({"half": "both" if half is None else half, "of": len(own), **means})
    return rows


def half_of(name: str) -> int:
    """Return the half, 0 or 1, that a picture of that name belongs to, whatever other pictures there are."""
    return hashlib.sha256(name.encode()).digest()[0] % 2


def _record(file: Path, sheets: Path | None) -> Record:
    name, picture = file.name.removesuffix(".curves.json"), picture_of(file)
    image = load(picture)
    curves = [curve if curve.passive else snap_to_edge(image, curve) for curve in feature_curves.read(file)]
    began = time.process_time()
    with faults_named(file):
        found = run(retexture(image.pixels, curves, linear=image.linear, previews=False))
    result = found.apply(image.pixels, linear=image.linear)
    seconds = time.process_time() - began
    if sheets is not None:
        sheets.mkdir(parents=True, exist_ok=True)
        plain = found.deformed(image.pixels, linear=image.linear)
        save(Image(sheet(eight_bits(plain), eight_bits(result), curves)), sheets / f"{name}.png")
    if sys.stderr.isatty():
        sys.stderr.write(f"{name}\n")
    return {"name": name, "half": half_of(picture.stem), **figures(found, curves), "cpu_s": seconds}


def figures(found: Retexture, curves: list[FeatureCurve]) -> Record:
    """Return what is regrown, what it magnifies beyond the plain deformation, and whether that is little enough."""
    along = bands(found, [curve.target for curve in curves if curve.target is not None])
    excess = max((band.regrown - band.plain for band in along), default=0.0)
    return {"regrown": float((found.label > 0).mean()), "excess": excess, "holds": excess <= MOST_EXCESS}


def picture_of(file: Path) -> Path:
    """Return the picture that a file of curves belongs to; raise `InputError` where there is none."""
    stem = file.name.removesuffix(".curves.json")
    while stem:
        for kind in KINDS:
            if (path := file.with_name(stem + kind)).exists():
                return path
        stem = stem.rpartition("_")[0]
    raise InputError(f"{file}: no picture beside it has its name")


def sheet(plain: Bytes, regrown: Bytes, curves: list[FeatureCurve]) -> Bytes:
    """Return the plain deformation and the result side by side, around what moves, enlarged 2 to 4 times."""
    low, high = _box(curves, plain.shape[1::-1])
    zoom = float(np.clip(SIDE_PX / max(*(high - low)), LEAST_ZOOM, MOST_ZOOM))
    views = [
        np.asarray(cv2.resize(part[low[1] : high[1], low[0] : high[0]], None, fx=zoom, fy=zoom), np.uint8)
        for part in (plain, regrown)
    ]
    gap = np.full((views[0].shape[0], GAP_PX, 3), 255, np.uint8)
    return np.concatenate([views[0], gap, views[1]], axis=1)


def _box(curves: list[FeatureCurve], size: tuple[int, ...]) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return the corners of what moves in a picture of `size`, (W, H), and some more."""
    shares = np.linspace(0, 1, SAMPLES)
    pairs = [(curve.source, curve.target) for curve in curves if curve.target is not None]
    there = np.concatenate([target.at(shares * target.segments) for _, target in pairs])
    way = np.linalg.norm(there - np.concatenate([source.at(shares * source.segments) for source, _ in pairs]), axis=1)
    moved = there[way >= STILL * way.max()]
    low = np.clip(moved.min(axis=0) - AROUND_PX, 0, np.array(size) - 1)
    return low.astype(int), np.clip(moved.max(axis=0) + AROUND_PX, low + 1, size).astype(int)


def eight_bits(pixels: np.ndarray[Any, Any]) -> Bytes:
    """Return the colours (H, W, 3) of pixels (H, W, C) of any depth."""
    levels = color.quantise(color.unit(pixels)[..., : color.color_channels(pixels.shape[2])], np.uint8)
    return np.ascontiguousarray(np.broadcast_to(levels, (*levels.shape[:2], 3)))
