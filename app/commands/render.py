"""Export a saved project; of one with key frames its first frame, `weft batch` makes them all."""

import argparse
from pathlib import Path

from app.console import run_shown
from app.render.picture_file import writing
from core.arrays import InputError
from core.document.animated import document_at
from core.document.project import load_project
from core.files.atomic import check_outputs
from core.imaging.images import check_writable_format, load


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `weft render`."""
    parser.add_argument("project", type=Path, metavar="PROJECT")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT")
    parser.add_argument(
        "--picture", type=Path, metavar="IMAGE", help="do to this picture what the project does to its own; any size"
    )
    parser.add_argument(
        "--frame",
        choices=("warp", "picture"),
        default="warp",
        help="warp, the default: a frame that holds all of the warped picture; picture: that of the project's canvas",
    )
    parser.add_argument("--scale", type=float, default=1.0, metavar="S", help="output pixels per pixel, 1 by default")
    parser.add_argument(
        "--bits", type=int, choices=(8, 16, 32), help="depth of a sample, 32 for float; by default that of the picture"
    )
    parser.add_argument("--quality", type=int, default=95, metavar="1-100", help="of JPEG and WebP")


def run(arguments: argparse.Namespace) -> None:
    """Read the project, map it, render and write."""
    check_writable_format(arguments.output)
    check_outputs([arguments.output], beside=[arguments.project])
    if not 1 <= arguments.quality <= 100:
        raise InputError(f"--quality {arguments.quality}: not from 1 to 100")
    if not 0 < arguments.scale <= 64:
        raise InputError(f"--scale {arguments.scale:g}: not above 0 and up to 64")
    document = load_project(arguments.project)
    if arguments.picture is not None:
        document = document.with_image(load(arguments.picture))
    document = document_at(document, document.span.first)
    job = writing(
        document,
        arguments.output,
        frame=arguments.frame,
        scale=arguments.scale,
        bits=arguments.bits,
        quality=arguments.quality,
    )
    try:
        run_shown(job)
    except InputError as fault:
        if str(arguments.output) in str(fault):
            raise
        raise InputError(f"{arguments.project}: {fault}") from fault
