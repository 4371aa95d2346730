"""Lay a new texture into the cloth of a decomposed photo."""

import argparse
from dataclasses import replace
from pathlib import Path

from app.console import run_shown
from app.render.export import COMMAND_TILE_PX, rendering
from app.render.picture_file import scale_size
from core.arrays import InputError
from core.files.atomic import check_outputs
from core.grid import Grid
from core.imaging import color
from core.imaging.images import Image, check_writable_format, load, load_mask, save
from core.overlay.composition import Placement
from core.overlay.covering import cover_parts
from core.overlay.laying.compositing import lay_over, texture_colours
from core.overlay.laying.enlarging import EnlargedParts
from core.overlay.storage.folder import PARTS, read

MOST_STRENGTH = 20


def pair(text: str) -> tuple[float, float]:
    """Parse `U,V` or one number for both."""
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        values = []
    if len(values) not in (1, 2):
        raise argparse.ArgumentTypeError(f"{text!r} is neither U,V nor a number for both")
    return values[0], values[-1]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="what decompose wrote")
    parser.add_argument("--texture", type=Path, required=True, metavar="NEW", help="the picture to lay on")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="the result")
    parser.add_argument("--protect", type=Path, metavar="MASK", help="what stays as it is: grey levels are opacity")
    parser.add_argument("--cover", type=Path, metavar="MASK", help="what is covered though it was left out, likewise")
    parser.add_argument("--detail", type=float, default=1.0, metavar="A", help="share of the fine detail (default: 1)")
    parser.add_argument("--shading", type=float, default=1.0, metavar="S", help="contrast of the shading (default: 1)")
    parser.add_argument("--repeat", type=pair, default=(1.0, 1.0), metavar="U,V", help="copies a texel (default: 1,1)")
    parser.add_argument("--rotate", type=float, default=0.0, metavar="DEG", help="clockwise, in the cloth's plane")
    parser.add_argument("--offset", type=pair, default=(0.0, 0.0), metavar="U,V", help="shift, in copies")
    parser.add_argument("--mirror", action="store_true", help="mirror every second copy")
    parser.add_argument("--upright", action="store_true", help="rectangular copies, where the old repeats lean")
    parser.add_argument("--once", action="store_true", help="lay a single copy on the middle of the cloth")
    parser.add_argument("--scale", type=float, default=1.0, metavar="S", help="output pixels per pixel, 1 by default")


def run(arguments: argparse.Namespace) -> None:
    """Compose and write the picture."""
    check_writable_format(arguments.output)
    check_outputs([arguments.output], beside=[arguments.folder / name for name in PARTS])
    for name in ("detail", "shading"):
        if not abs(getattr(arguments, name)) <= MOST_STRENGTH:
            raise InputError(f"--{name} {getattr(arguments, name):g}: not from {-MOST_STRENGTH} to {MOST_STRENGTH}")
    if not 0 < arguments.scale <= 64:
        raise InputError(f"--scale {arguments.scale:g}: not above 0 and up to 64")
    parts, texture = read(arguments.folder), texture_colours(load(arguments.texture))
    placement = Placement(
        arguments.repeat,
        arguments.rotate,
        arguments.offset,
        mirror=arguments.mirror,
        tile=not arguments.once,
        upright=arguments.upright,
    )
    if arguments.cover is not None:
        parts = cover_parts(parts, color.unit(load_mask(arguments.cover, parts.source.size_px)))
    if arguments.protect is not None:
        kept = color.unit(load_mask(arguments.protect, parts.source.size_px))
        parts = replace(parts, coverage=parts.coverage * (1 - kept))
    parts = parts.under(texture, placement)
    photo = resize(parts.source, max(arguments.scale, 1.0))
    result = lay_over(
        parts if photo is parts.source else EnlargedParts(parts, photo),
        texture,
        placement,
        alpha=arguments.detail,
        strength=arguments.shading,
    )
    save(resize(result, min(arguments.scale, 1.0)), arguments.output)


def resize(image: Image, scale: float) -> Image:
    """Return a picture with `scale` pixels for each, the same one where that is 1."""
    if scale == 1:
        return image
    nodes = Grid(*image.size_px).nodes
    size = scale_size(image.size_px, scale)
    return run_shown(rendering(image, nodes, nodes, size=size, scale=scale, tile_px=COMMAND_TILE_PX))
