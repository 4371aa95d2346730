"""Lay a new texture into the cloth of a decomposed photo."""

import argparse
from pathlib import Path

import numpy as np

from core import color
from core.arrays import Bools, Floats, InputError
from core.images import Image, check_writable_format, load, save
from core.overlay.composition import Placement, compose
from core.overlay.folder import Parts, encoded, read


def pair(text: str) -> tuple[float, float]:
    """Parse `U,V` or one number for both."""
    values = [float(word) for word in text.split(",")]
    if len(values) not in (1, 2):
        raise argparse.ArgumentTypeError(f"{text!r} is not U,V")
    return values[0], values[-1]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="what decompose wrote")
    parser.add_argument("--texture", type=Path, required=True, metavar="NEW", help="the picture to lay on")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="the result")
    parser.add_argument("--detail", type=float, default=1.0, metavar="A", help="share of the fine detail (default: 1)")
    parser.add_argument("--shading", type=float, default=1.0, metavar="S", help="contrast of the shading (default: 1)")
    parser.add_argument("--repeat", type=pair, default=(1.0, 1.0), metavar="U,V", help="copies a texel (default: 1,1)")
    parser.add_argument("--rotate", type=float, default=0.0, metavar="DEG", help="clockwise, in the cloth's plane")
    parser.add_argument("--offset", type=pair, default=(0.0, 0.0), metavar="U,V", help="shift, in copies")
    parser.add_argument("--mirror", action="store_true", help="mirror every second copy")
    parser.add_argument("--once", action="store_true", help="lay a single copy on the middle of the cloth")


def run(arguments: argparse.Namespace) -> None:
    """Compose and write the picture."""
    check_writable_format(arguments.output)
    if not np.isfinite([arguments.detail, arguments.shading]).all():
        raise InputError("--detail and --shading must be finite numbers")
    parts, texture = read(arguments.folder), load(arguments.texture)
    placement = Placement(
        arguments.repeat, arguments.rotate, arguments.offset, mirror=arguments.mirror, tile=not arguments.once
    )
    result = overlaid(parts, texture, placement, alpha=arguments.detail, strength=arguments.shading)
    save(result, arguments.output)


def overlaid(parts: Parts, texture: Image, placement: Placement, *, alpha: float, strength: float) -> Image:
    """Return the photo with the texture in its folds, at the photo's own depth."""
    colours = encoded(texture)
    if texture.has_alpha:
        colours = np.concatenate([colours, color.unit(texture.pixels[..., -1:])], -1)
    new, opacity = compose(
        colours,
        parts.uv.astype(np.float64),
        parts.shading.astype(np.float64),
        parts.detail.astype(np.float64),
        parts.basis,
        placement=placement,
        alpha=alpha,
        strength=strength,
    )
    photo = encoded(parts.source)
    share = (opacity * parts.coverage)[..., None]
    return in_place_of(parts.source, share * new + (1 - share) * photo, share > 0)


def in_place_of(source: Image, colours: Floats, changed: Bools) -> Image:
    """Return `source` with other colours (H, W, 3), on the encoded 0 to 1 scale, where `changed` (H, W, 1)."""
    values = colours.astype(np.float32)
    rgb = color.quantise(color.decode(values) if source.linear else values, source.pixels.dtype)
    old = source.pixels[..., : color.color_channels(source.channels)]
    pixels = np.where(changed, rgb, np.broadcast_to(old, rgb.shape))
    if source.has_alpha:
        pixels = np.concatenate([pixels, source.pixels[..., -1:]], -1)
    return source.with_pixels(np.ascontiguousarray(pixels))
