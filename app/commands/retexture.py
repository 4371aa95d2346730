"""Move feature curves of a picture and regrow the texture along them instead of stretching it."""

import argparse
import json
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np

from app.console import run_shown
from core.arrays import Bytes, InputError
from core.curves import feature_curves
from core.curves.edge_snapping import snap_to_edge
from core.curves.feature_curves import FeatureCurve
from core.files.atomic import AtomicFiles, check_outputs
from core.files.faults import faults_named
from core.imaging.images import Image, check_writable_format, load, load_mask, write
from core.notices import notice
from core.retexture.job import Settings, retexture
from core.retexture.magnification import bands
from core.retexture.region import REFUSED
from core.retexture.result import Retexture
from core.retexture.synthesis.patches import PatchShape

MASKS = ("matte", "source_mask", "regrow")


def size(text: str) -> tuple[int, int]:
    """Parse `ALONGxACROSS`, two whole numbers of pixels."""
    along, _, across = text.partition("x")
    if not (along.isdecimal() and across.isdecimal() and min(int(along), int(across)) >= 1):
        raise argparse.ArgumentTypeError(f"{text!r} is not ALONGxACROSS in pixels, as in 37x19")
    return int(along), int(across)


def pixels(text: str) -> float:
    """Parse a length in pixels."""
    try:
        length = float(text)
    except ValueError:
        length = 0.0
    if not 0 < length < 1e6:
        raise argparse.ArgumentTypeError(f"{text!r} is not a length in pixels")
    return length


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add = parser.add_argument
    add("image", type=Path, metavar="IMAGE", help="the picture")
    add("--curves", type=Path, required=True, metavar="CURVES.json", help="where curves are and where they shall go")
    add(
        "-o",
        "--output",
        type=Path,
        action="append",
        required=True,
        metavar="OUT",
        help="the result; once more for each --also, in their order",
    )
    add(
        "--also",
        type=Path,
        action="append",
        default=[],
        metavar="LAYER",
        help="a layer to carry along, such as normals",
    )
    add("--deformed", type=Path, metavar="FILE", help="write the plain deformation, too")
    add("--matte", type=Path, metavar="MATTE", help="where the result may differ from it: over 127")
    add("--regrow", type=Path, metavar="GREY", help="what is regrown, over 191, or not, under 64, whatever is found")
    add("--source-mask", type=Path, metavar="MASK", help="where texture may be taken from: over 127")
    add(
        "--patch",
        type=size,
        metavar="ALONGxACROSS",
        help="a patch's sides, px (default: 37x19, more in large pictures)",
    )
    add("--search", type=size, metavar="ALONGxACROSS", help="candidates' region, px (default: 25x13, and more)")
    add("--reach", type=pixels, metavar="PX", help="regrow this far from a curve (default: by the motion)")
    add("--move-within", type=pixels, metavar="PX", help="move nothing farther than this from a curve")
    add("--no-snap", action="store_true", help="leave curves that were drawn beside an edge where they are")
    add("--no-edges", action="store_true", help="do not keep long edges near moved curves as passive curves")
    add("--mirror", action="store_true", help="allow mirrored patches")
    add("--seed", type=int, default=0, metavar="N", help="for the random choices (default: 0)")
    add("--report", type=Path, metavar="REPORT.json", help="write what was done and how long it took")


def run(arguments: argparse.Namespace) -> None:
    """Retexture the picture and its layers; nothing is written before all of them are done."""
    check(arguments)
    image = load(arguments.image)
    width, height = image.size_px
    drawn = feature_curves.read(arguments.curves)
    curves = drawn if arguments.no_snap else snap(image, drawn)
    layers = [load(path) for path in arguments.also]
    for path, layer in zip(arguments.also, layers, strict=True):
        if layer.size_px != image.size_px:
            raise InputError(f"{path}: has {layer.width_px}x{layer.height_px} pixels, the image {width}x{height}")
    settings = choose(arguments, image.size_px)
    masks = {name: mask(getattr(arguments, name), name, image.size_px) for name in MASKS}
    with faults_named(arguments.curves):
        result = run_shown(retexture(image.pixels, curves, settings, linear=image.linear, previews=False, **masks))
    started = time.perf_counter()
    pictures = [image.with_pixels(result.apply(image.pixels, linear=image.linear))]
    # A layer holds data, not light: its numbers are resampled as they are.
    pictures += [layer.with_pixels(result.apply(layer.pixels, linear=True)) for layer in layers]
    blend = time.perf_counter() - started
    paths = list(arguments.output)
    if arguments.deformed is not None:
        pictures.append(image.with_pixels(result.deformed(image.pixels, linear=image.linear)))
        paths.append(arguments.deformed)
    with AtomicFiles() as files:

        def keep(picture: Image, path: Path) -> None:
            with files.place(path) as place:
                write(picture, place, named=path)

        with ThreadPoolExecutor(2) as helpers:
            list(helpers.map(keep, pictures, paths))
        if arguments.report is not None:
            text = json.dumps(report(image, curves, result, blend, arguments.seed), indent=1)
            with files.place(arguments.report) as place:
                place.write_text(f"{text}\n", encoding="utf-8")


def snap(image: Image, curves: list[FeatureCurve]) -> list[FeatureCurve]:
    """Return the curves, those with a target that were drawn beside an edge on it, and say which these are."""
    snapped = [curve if curve.passive else snap_to_edge(image, curve) for curve in curves]
    for number, (curve, found) in enumerate(zip(curves, snapped, strict=True), 1):
        if found is not curve:
            t = curve.source.parameters(step=4.0)
            far = np.linalg.norm(found.source.at(t) - curve.source.at(t), axis=1).max()
            notice(f"curve {number}: moved onto the edge beside it, by up to {far:.0f} px; --no-snap leaves it")
    return snapped


def check(arguments: argparse.Namespace) -> None:
    """Raise `InputError` for options that do not fit together."""
    if len(arguments.output) != 1 + len(arguments.also):
        raise InputError(f"{len(arguments.also)} --also need {1 + len(arguments.also)} -o, not {len(arguments.output)}")
    pictures = [*arguments.output, *([arguments.deformed] if arguments.deformed else [])]
    for path in pictures:
        check_writable_format(path)
    sources = [arguments.image, *arguments.also]
    check_outputs(
        [*pictures, arguments.report], beside=[arguments.curves, *(getattr(arguments, name) for name in MASKS)]
    )
    check_outputs([arguments.deformed, arguments.report], beside=sources)
    for path, own in zip(arguments.output, sources, strict=True):
        # A result may take the place of what it is made from, and of nothing else that is read.
        check_outputs([path], beside=[source for source in sources if source != own])
    if arguments.seed < 0:
        raise InputError(f"--seed {arguments.seed}: must not be negative")


def choose(arguments: argparse.Namespace, size_px: tuple[int, int]) -> Settings:
    """Return the engine's settings for a picture of that width and height."""
    patch = PatchShape.for_picture(*reversed(size_px))
    if arguments.patch is not None:
        along, across = arguments.patch
        if not (9 <= along <= 501 and 5 <= across <= 501):
            raise InputError("--patch takes 9x5 to 501x501 pixels")
        patch = replace(patch, spine=along // 2, rib=across // 2)
    if arguments.search is not None:
        along, across = arguments.search
        if max(along, across) > 201:
            raise InputError("--search takes up to 201x201 pixels")
        patch = replace(patch, search_along=along // 2, search_across=across // 2)
    return Settings(
        patch=patch,
        reach_px=arguments.reach,
        diffusion_reach_px=arguments.move_within,
        mirrored=arguments.mirror,
        long_edges=not arguments.no_edges,
        seed=arguments.seed,
    )


def mask(path: Path | None, name: str, size_px: tuple[int, int]) -> Bytes | None:
    """Return a mask for a picture of that width and height, or None; refuse one that says nothing."""
    if path is None:
        return None
    marked = load_mask(path, size_px)
    if not (marked > 127).any() and not (name == "regrow" and (marked < REFUSED).any()):
        raise InputError(f"{path}: the mask marks nothing")
    return marked


def report(image: Image, curves: list[FeatureCurve], result: Retexture, blend: float, seed: int) -> dict[str, object]:
    """Return what `--report` writes."""
    seconds = {**result.seconds, "blend": blend, "total": result.seconds["total"] + blend}
    return {
        "size": [image.height_px, image.width_px],
        "patches": result.patches,
        "candidates": result.candidates,
        "magnified": [
            {key: round(value, 4) for key, value in band._asdict().items()}
            for band in bands(result, [curve.target for curve in curves if curve.target is not None])
        ],
        "seconds": {stage: round(value, 4) for stage, value in seconds.items()},
        "seed": seed,
    }
