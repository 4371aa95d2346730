"""Options of `weft warp` about a surface in space, and what they mean."""

import argparse
from pathlib import Path

from app.model.orbit import Orbit
from core.arrays import InputError
from core.files.faults import faults_named
from core.surfaces.mesh_file import read_mesh
from core.surfaces.shapes import SHAPES, make_shape
from core.surfaces.surface import Surface

PROPORTIONS = "; ".join(f"{name}: {shape.number}, {shape.usual:g}" for name, shape in SHAPES.items())


def add_surface_options(group: argparse._ArgumentGroup, maps: argparse._MutuallyExclusiveGroup) -> None:
    """Declare the options that say which surface; it is one of several `maps`."""
    maps.add_argument(
        "--surface", metavar="NAME|MESH", help="lay it on a surface: " + ", ".join(SHAPES) + ", or an OBJ or glTF file"
    )
    group.add_argument("--proportion", type=float, metavar="P", help="of a surface by name: " + PROPORTIONS)


def add_view_options(group: argparse._ArgumentGroup) -> None:
    """Declare the options that say how it is seen."""
    group.add_argument("--view", type=Path, metavar="VIEW.png", help="also write the surface with the picture on it")
    group.add_argument(
        "--orbit", type=_orbit, default=Orbit(), metavar="TURN,TILT", help="degrees the camera goes right and up"
    )


def _orbit(text: str) -> Orbit:
    """Read TURN,TILT."""
    try:
        turn, tilt = (float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: not TURN,TILT in degrees") from None
    return Orbit(turn, tilt)


def surface_of(arguments: argparse.Namespace) -> Surface | None:
    """Return the surface that was asked for, by name or in a file."""
    if arguments.surface is None:
        if arguments.view is not None:
            raise InputError("--view: shows a surface: choose one with --surface")
        if arguments.proportion is not None:
            raise InputError("--proportion: is that of a surface: choose one with --surface")
        return None
    for name in ("size", "frame"):
        if getattr(arguments, name) is not None:
            raise InputError(f"--{name}: the texture of a surface has the picture's size and frame")
    if arguments.surface in SHAPES:
        surface = make_shape(arguments.surface, arguments.proportion)
    elif arguments.proportion is not None:
        raise InputError("--proportion: is that of a surface by name, not of a mesh")
    elif "." not in arguments.surface:
        raise InputError(f"--surface {arguments.surface}: neither a file nor one of {', '.join(SHAPES)}")
    else:
        surface = read_mesh(Path(arguments.surface))
    with faults_named(arguments.surface):
        surface.chart.size_px((1, 1))
    return surface
