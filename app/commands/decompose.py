"""Split a photo of patterned cloth into its mean texel, texture coordinates, shading and detail."""

import argparse
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np

from app.console import run_shown
from core.arrays import Bools, Floats, InputError, Singles
from core.files.atomic import atomic_folder, check_folder_place
from core.files.faults import faults_named
from core.imaging import color
from core.imaging.images import Image, load, load_mask
from core.imaging.images import write as write_picture
from core.linalg.jobs_beside import use_all_processors
from core.overlay.decomposition import decompose, decompose_whole_cloth
from core.overlay.detection.corrections import lattices_of
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError
from core.overlay.detection.stages import Stage
from core.overlay.filters.shrinking import shrunk
from core.overlay.laying.compositing import encode, searchable
from core.overlay.storage.folder import read_lattice, write
from core.overlay.storage.pictures import stage_picture
from core.progress import Job, Progress, stepwise

T = TypeVar("T")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("image", type=Path, metavar="IMAGE", help="the photo")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FOLDER", help="where the parts go")
    parser.add_argument("--region", type=Path, metavar="MASK", help="where the cloth is: grey levels are opacity")
    parser.add_argument(
        "--whole-cloth",
        action="store_true",
        help="look again in all of the cloth that stands out where the pattern was found; "
        "where none was, on what stands out in the photo",
    )
    parser.add_argument("--texel-size", type=float, metavar="PX", help="about the side of one texel")
    parser.add_argument("--lattice", type=Path, metavar="LATTICE.json", help="a corrected lattice to go on from")
    parser.add_argument("--stages", type=Path, metavar="DIR", help="write a picture per stage")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="for the random choices (default: 0)")


def run(arguments: argparse.Namespace) -> None:
    """Decompose the photo and write the folder."""
    check(arguments)
    image = load(arguments.image)
    photo, region = encode(image), usable(image, arguments.region)
    lattice = take_lattice(arguments.lattice, image.size_px)
    finding = partial(decompose_whole_cloth, image) if arguments.whole_cloth else partial(decompose, photo)
    job = finding(region=region, texel_px=arguments.texel_size, lattice=lattice, seed=arguments.seed)
    shown: list[Stage] = []
    try:
        with use_all_processors():
            found = run_shown(watch(job, shown))
    except NoPatternError:
        write_stages(arguments.stages, photo, shown)
        along = "" if arguments.lattice is None else f" along {arguments.lattice}"
        raise NoPatternError(f"{arguments.image}{along}") from None
    write_stages(arguments.stages, photo, shown)
    if not np.isfinite(found.uv).any():
        raise InputError(f"{arguments.lattice or arguments.image}: the lattice covers no pixel of the photo")
    write(found, image, arguments.output)


def check(arguments: argparse.Namespace) -> None:
    """Raise `InputError` for what is wrong before any work is done."""
    for folder in (arguments.output, arguments.stages):
        if folder is not None:
            check_folder_place(folder)
    if arguments.texel_size is not None and not 2 <= arguments.texel_size < 1e5:
        raise InputError(f"--texel-size {arguments.texel_size:g}: not a length of 2 pixels or more")
    if arguments.seed < 0:
        raise InputError(f"--seed {arguments.seed}: must not be negative")


def take_lattice(path: Path | None, size_px: tuple[int, int]) -> list[Lattice] | None:
    """Return the lattice of a file in connected parts, or None; refuse one that has nothing to do with the picture."""
    if path is None:
        return None
    keys, points = read_lattice(path)
    if not any(0 <= x < size_px[0] and 0 <= y < size_px[1] for x, y in points):
        raise InputError(f"{path}: none of its vertices lies in the picture of {size_px[0]}x{size_px[1]} pixels")
    with faults_named(path):
        return lattices_of(np.array(keys, np.int64).reshape(-1, 2), np.array(points, np.float64).reshape(-1, 2))


def watch(job: Job[T], shown: list[Stage]) -> Job[T]:
    """Run a job and keep the last preview of every stage."""

    def keep(step: Progress) -> Progress:
        if isinstance(step.preview, Stage):
            if shown and shown[-1].name == step.preview.name:
                shown.pop()
            shown.append(step.preview)
        return step

    return stepwise(job, keep)


def write_stages(folder: Path | None, photo: Floats | Singles, shown: list[Stage]) -> None:
    """Write a numbered picture of every stage, on the photo at the working size, into `folder` if there is one."""
    if folder is None:
        return
    with atomic_folder(folder) as place:
        for number, stage in enumerate(shown):
            shape = stage.shape or photo.shape[:2]
            small = shrunk(photo, -(-photo.shape[0] // shape[0]))
            pictures = {stage.name: stage_picture(small, stage)}
            if stage.texel is not None:
                pictures["texel"] = color.quantise(stage.texel.tiled(3, 3).astype(np.float32), np.uint8)
            for name, pixels in pictures.items():
                file = f"{number:02d}-{name}.png"
                write_picture(Image(pixels), place / file, named=folder / file)


def usable(image: Image, mask: Path | None) -> Bools | Singles | None:
    """Return the opacity of what is laid at each pixel (H, W), 0 where there is no cloth, or None for 1 everywhere."""
    if mask is None:
        return searchable(image, None)
    opacity = color.unit(load_mask(mask, image.size_px))
    if not opacity.any():
        raise InputError(f"{mask}: the mask marks nothing")
    return searchable(image, opacity)
