"""Warp a picture and keep its features.

Places in HANDLES.json are pixels of the picture; with --frame warp the canvas is moved there afterwards.
"""

import argparse
import json
import re
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from app.commands.surfaces import add_surface_options, add_view_options, surface_of
from app.console import run_shown
from app.render.export import COMMAND_TILE_PX, rendering_file
from app.render.surface_view import draw_view
from core.arrays import InputError
from core.canvas import Canvas, Framing
from core.document.document import Document, WarpSettings
from core.document.feature import Feature, read_feature
from core.document.map import frame_result, with_handles
from core.document.map_solver import MapSolver
from core.document.mask_file import with_mask_file, with_said
from core.files.atomic import AtomicFiles, check_outputs
from core.imaging.images import Image, check_writable_format, load, write
from core.interchange.obj import obj_mesh
from core.interchange.stmap import write_st_map
from core.mapping.result import Warped
from core.notices import notice
from core.rasters.raster import Raster
from core.selection.importance import importance, propose_objects
from core.warps.map_file import warp_map_of
from core.warps.presets import PRESETS


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `weft warp`."""
    parser.add_argument("image", type=Path, metavar="IMAGE")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT")
    _add_warp_options(parser.add_argument_group("the warp"))
    _add_mapping_options(parser.add_argument_group("the features"))
    _add_output_options(parser.add_argument_group("the output"))


def _add_warp_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument("--preset", metavar="NAME", help="one of: " + ", ".join(PRESETS))
    for name in ("bend", "horizontal", "vertical"):
        group.add_argument(f"--{name}", type=float, default=0.0, metavar="P", help="per cent, -100 to 100")
    group.add_argument("--vertical-axis", action="store_true", help="turn the preset by 90 degrees clockwise")
    group.add_argument(
        "--set",
        action="append",
        default=[],
        type=_setting,
        dest="settings",
        metavar="KEY=VALUE",
        help="a parameter of the preset's own; see weft presets",
    )
    maps = group.add_mutually_exclusive_group()
    maps.add_argument("--from-stmap", type=Path, metavar="FILE.exr", help="the warp of an ST map")
    maps.add_argument("--from-displacement", type=Path, metavar="FILE.exr", help="that of offsets in pixels, y up")
    add_surface_options(group, maps)
    group.add_argument("--size", type=_size, metavar="WxH", help="resize to another size and aspect ratio")
    group.add_argument("--handles", type=Path, metavar="HANDLES.json", help="pins, inner curves and outline")
    group.add_argument(
        "--outline",
        choices=("held", "free"),
        default="held",
        help="whether pins and curves leave the picture's outline where it is (held, the default) or draw it along",
    )


def _add_mapping_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--mask",
        type=Path,
        metavar="MASK",
        help="a picture of the same size; over 127 is a feature, or each of a few labels",
    )
    group.add_argument(
        "--propose",
        type=float,
        metavar="PERCENT",
        help="without a mask: keep what stands out of its ground, about so much of the picture",
    )
    group.add_argument("--keep", choices=("similarity", "rigid", "none"), default="similarity")
    group.add_argument(
        "--feature",
        action="append",
        default=[],
        type=_feature,
        dest="features",
        metavar="N=HOW",
        help="how feature N of the report is kept instead: similarity, rigid, none, lines (long straight ones only), "
        "upright, least:SIZE, most:SIZE, weight:0-1; several with commas between them",
    )
    group.add_argument(
        "--straight", action="store_true", help="keep long straight lines straight beside features: horizons, walls"
    )
    group.add_argument("--method", choices=("exact", "per-quad"), default="exact")
    group.add_argument("--allow-folds", action="store_true", help="do not remove the folds that features bring")
    group.add_argument("--cell", type=float, metavar="PX", help="grid cell; by default 20 000 to 50 000 nodes")
    group.add_argument("--weight", type=float, default=10.0, metavar="W", help="of the features, 10 by default")
    group.add_argument("--falloff", type=float, default=2.0, metavar="CELLS", help="of that weight, 2 by default")


def _add_output_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--frame",
        choices=("warp", "picture"),
        help="warp, the default: a canvas that holds all of the warped picture; picture: the frame it had, or its map",
    )
    group.add_argument("--quality", type=int, default=95, metavar="1-100", help="of JPEG and WebP")
    group.add_argument("--map", type=Path, metavar="MAP.npz", help="also write the grid, before and after")
    group.add_argument("--stmap", type=Path, metavar="FILE.exr", help="also write the warp as an ST map")
    group.add_argument("--mesh", type=Path, metavar="FILE.obj", help="also write the warp as a textured mesh")
    group.add_argument("--report", type=Path, metavar="REPORT.json", help="also write what became of the features")
    add_view_options(group)


def _setting(text: str) -> tuple[str, float]:
    """Read KEY=VALUE."""
    key, _, value = text.partition("=")
    try:
        return key, float(value)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: not KEY=NUMBER") from None


def _feature(text: str) -> Feature:
    """Read N=HOW,HOW."""
    number, _, how = text.partition("=")
    try:
        return read_feature(number, how)
    except InputError as fault:
        raise argparse.ArgumentTypeError(f"{text!r}: {fault}") from None


def _size(text: str) -> tuple[int, int]:
    """Read WxH."""
    match = re.fullmatch(r"([1-9]\d{0,5})x([1-9]\d{0,5})", text)
    if match is None:
        raise argparse.ArgumentTypeError(f"{text!r}: not WIDTHxHEIGHT in pixels")
    return int(match[1]), int(match[2])


def run(arguments: argparse.Namespace) -> None:
    """Read, warp, render and write."""
    _check_outputs(arguments)
    document = document_from(arguments)
    found = _solve_pixels(document, allow_folds=arguments.allow_folds)
    framing: Framing = arguments.frame or ("warp" if document.warp_map is None else "picture")
    canvas, moved = frame_result(document, found, framing)
    if document.surface is None:
        handles = replace(found.handles, pins_to=canvas.placed(found.handles.pins_to))
        placed = replace(found, w=canvas.placed(found.plain), field=None, warped=moved, folds=None, handles=handles)
        report = placed.report()
    else:
        # Features have their shape on the chart, pins their places.
        placed, report = replace(found, w=found.rest, field=None, warped=moved, folds=None), found.report()
    view = None if arguments.view is None else draw_view(document, found, arguments.orbit)
    _write(arguments, document.image, placed, canvas, report, view)
    for complaint in [] if arguments.allow_folds else found.complaints():
        notice(f"{arguments.output}: {complaint}")


def _solve_pixels(document: Document, *, allow_folds: bool) -> Warped:
    """Return the map; what the solver has built is let go before the picture is drawn."""
    solver = MapSolver()
    return solver.frame(document) if allow_folds else run_shown(solver.settle(document))


def _check_outputs(arguments: argparse.Namespace) -> None:
    """Refuse, before any work, what cannot be written in the end."""
    check_writable_format(arguments.output)
    if not 1 <= arguments.quality <= 100:
        raise InputError(f"--quality {arguments.quality}: not from 1 to 100")
    if arguments.stmap is not None and arguments.stmap.suffix.lower() != ".exr":
        raise InputError(f"{arguments.stmap}: an ST map is an .exr file")
    if arguments.mesh is not None and arguments.mesh.suffix.lower() != ".obj":
        raise InputError(f"{arguments.mesh}: a mesh is an .obj file")
    if arguments.view is not None:
        check_writable_format(arguments.view)
    further = arguments.map, arguments.stmap, arguments.mesh, arguments.report, arguments.view
    check_outputs([arguments.output, *further], beside=_read(arguments))
    check_outputs(further, beside=[arguments.image])


def _read(arguments: argparse.Namespace) -> list[Path | None]:
    """Return the files that are read beside the picture."""
    mesh = None if arguments.surface is None else Path(arguments.surface)
    return [arguments.mask, arguments.handles, arguments.from_stmap, arguments.from_displacement, mesh]


def document_from(arguments: argparse.Namespace) -> Document:
    """Return the document that the options describe; raise `InputError` for what they cannot mean."""
    if not arguments.preset and (arguments.bend or arguments.settings or arguments.vertical_axis):
        raise InputError("--bend, --vertical-axis and --set bend a preset: choose one with --preset")
    image = load(arguments.image)
    document = Document.of(image)
    found = warp_map_of(arguments.from_stmap, arguments.from_displacement)
    size = arguments.size or (document.size_px if found is None else found.size_px)
    settings = WarpSettings(
        preset=arguments.preset,
        bend=arguments.bend,
        horizontal=arguments.horizontal,
        vertical=arguments.vertical,
        vertical_axis=arguments.vertical_axis,
        values=dict(arguments.settings),
        aspect=(size[0] / image.width_px, size[1] / image.height_px),
        frame=arguments.outline,
        keep=arguments.keep,
        method=arguments.method,
        weight=arguments.weight,
        falloff=arguments.falloff,
        straight=arguments.straight,
        cell_px=arguments.cell,
    )
    document = replace(document, warp=settings, warp_map=found, surface=surface_of(arguments))
    if arguments.propose is not None:
        if arguments.mask is not None or not 0 <= arguments.propose <= 100:
            raise InputError("--propose: from 0 to 100, and not with --mask")
        what_stands_out = run_shown(importance(image))
        mask = run_shown(propose_objects(image, what_stands_out, arguments.propose / 100))
        document = replace(document, mask=Raster.from_array(mask))
    if arguments.mask is not None:
        document = with_mask_file(document, arguments.mask)
    document = with_said(document, arguments.features)
    return document if arguments.handles is None else with_handles(document, arguments.handles)


def _write(
    arguments: argparse.Namespace,
    image: Image,
    found: Warped,
    canvas: Canvas,
    report: dict[str, Any],
    view: Image | None,
) -> None:
    """Render, and write all files that were asked for; they appear together, once each is whole."""
    grid = found.rest, found.warped, image.size_px, canvas
    with AtomicFiles() as files:
        started = time.perf_counter()
        with files.place(arguments.output) as place:
            run_shown(
                rendering_file(
                    image,
                    found.rest,
                    found.warped,
                    place,
                    named=arguments.output,
                    size=canvas.size,
                    quality=arguments.quality,
                    tile_px=COMMAND_TILE_PX,
                )
            )
        report["seconds"]["render"] = time.perf_counter() - started
        if arguments.map is not None:
            with files.place(arguments.map) as place, place.open("wb") as file:
                np.savez(file, rest=found.rest, plain=found.plain, warped=found.warped)
        if arguments.stmap is not None:
            with files.place(arguments.stmap) as place:
                write_st_map(*grid, place, named=arguments.stmap)
        if arguments.mesh is not None:
            with files.place(arguments.mesh) as place:
                place.write_text(obj_mesh(*grid), encoding="utf-8")
        if view is not None:
            with files.place(arguments.view) as place:
                write(view, place, named=arguments.view, quality=arguments.quality)
        if arguments.report is not None:
            with files.place(arguments.report) as place:
                place.write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
