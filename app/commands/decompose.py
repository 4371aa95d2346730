"""Split a photo of patterned cloth into its mean texel, texture coordinates, shading and detail."""

import argparse
from pathlib import Path

import numpy as np

from app.console import run_shown
from core.arrays import Bools, InputError
from core.images import Image, load, load_mask
from core.overlay.decomposition import decompose
from core.overlay.folder import encoded, write
from core.overlay.seeding import NoPatternError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("image", type=Path, metavar="IMAGE", help="the photo")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FOLDER", help="where the parts go")
    parser.add_argument("--region", type=Path, metavar="MASK", help="where the cloth is: over 127, the photo's size")
    parser.add_argument("--texel-size", type=float, metavar="PX", help="about the side of one texel")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="for the random choices (default: 0)")


def run(arguments: argparse.Namespace) -> None:
    """Decompose the photo and write the folder."""
    image = load(arguments.image)
    region = usable(image, arguments.region)
    job = decompose(encoded(image), region=region, texel_px=arguments.texel_size, seed=arguments.seed)
    try:
        found = run_shown(job)
    except NoPatternError:
        raise NoPatternError(str(arguments.image)) from None
    write(found, image, arguments.output)


def usable(image: Image, mask: Path | None) -> Bools | None:
    """Return the pixels that may be cloth, or None for all of them."""
    opaque = image.pixels[..., -1] > 0.5 * (1 if image.linear else np.iinfo(image.pixels.dtype).max)
    if mask is None:
        return np.asarray(opaque, np.bool_) if image.has_alpha else None
    inside = load_mask(mask, (image.height_px, image.width_px)) > 127
    if not inside.any():
        raise InputError(f"{mask}: the mask marks nothing")
    return np.asarray(inside & opaque if image.has_alpha else inside, np.bool_)
