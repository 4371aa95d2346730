"""What a document says of its map, in the terms of the mapping: W, handles, options; and where its result is drawn.

The preset warps the picture; the outline, the pins and the inner curves edit the preset's result; the features then
keep their shape within that. `map_solver` has the answer.
"""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from core.arrays import Points
from core.canvas import Canvas, Framing
from core.curves.bezier import Curve
from core.curves.curve_edit import through
from core.document import handles_file
from core.document.document import (
    CurvePair,
    Document,
    Outline,
    Pin,
    WarpSettings,
    pixels_from_places,
    places_from_pixels,
)
from core.files.faults import faults_named
from core.grid import Grid
from core.mapping.features.straight_lines import Lines
from core.mapping.handles.handles import Handles
from core.mapping.options import MappingOptions
from core.mapping.result import Warped
from core.surfaces.chart import Chart
from core.warps.map_file import WarpMap
from core.warps.presets import make_warp
from core.warps.warp import Warp, compose, resize

_EDGE_SAMPLES = 65
"""Points of a side at which a cubic is fitted to it."""


def grid_of(document: Document) -> Grid:
    """Return the grid over the document's picture."""
    return Grid(*document.size_px, cell_px=document.warp.cell_px)


def preset_of(document: Document) -> Warp:
    """Return the map, the preset and the resizing, from pixels of the picture to pixels of the canvas."""
    start, bend = start_of(document), bend_of(document)
    return bend if start is None else compose(start, bend)


def start_of(document: Document) -> Warp | None:
    """Return what takes the picture where the preset begins, to pixels of the picture: a map that was read, a chart."""
    return _start(_source_of(document), document.size_px)


def bend_of(document: Document) -> Warp:
    """Return the preset and the resizing, from pixels of the picture to pixels of the canvas."""
    return _bend(document.warp, document.size_px, document.canvas_px)


def _source_of(document: Document) -> WarpMap | Chart | None:
    return document.warp_map if document.surface is None else document.surface.chart


def _start(source: WarpMap | Chart | None, size_px: tuple[int, int]) -> Warp | None:
    if source is None:
        return None
    given_px = source.size_px(size_px) if isinstance(source, Chart) else source.size_px
    return compose(source.warp(size_px), resize(given_px, size_px))


def _bend(warp: WarpSettings, size_px: tuple[int, int], canvas_px: tuple[int, int]) -> Warp:
    bent = make_warp(
        warp.preset or "none",
        *size_px,
        bend=warp.bend,
        horizontal=warp.horizontal,
        vertical=warp.vertical,
        vertical_axis=warp.vertical_axis,
        settings=warp.values,
    )
    return bent if canvas_px == size_px else compose(bent, resize(size_px, canvas_px))


def handles_of(document: Document) -> Handles:
    """Return pins and inner curves in pixels."""
    here, there = document.size_px, document.canvas_px
    return Handles(
        pixels_from_places(here, np.reshape([pin.at for pin in document.pins], (-1, 2))),
        pixels_from_places(there, np.reshape([pin.to for pin in document.pins], (-1, 2))),
        [
            (Curve(pixels_from_places(here, pair.source)), Curve(pixels_from_places(there, pair.target)))
            for pair in document.curves
        ],
        np.array([np.nan if pin.ring is None else pin.ring.f for pin in document.pins], np.complex128),
    )


def with_handles(document: Document, path: Path) -> Document:
    """Return `document` with the handles in the file `path`, in pixels; raise `InputError` for what they cannot be."""
    handles = handles_file.read(path, document.size_px)
    at = places_from_pixels(document.size_px, handles.pins_at)
    to = places_from_pixels(document.canvas_px, handles.pins_to)
    curves = tuple(
        CurvePair(
            places_from_pixels(document.size_px, curve.source.points),
            places_from_pixels(document.canvas_px, curve.target.points),
            curve.source.closed,
        )
        for curve in handles.curves
        if curve.target is not None
    )
    outline = None if handles.outline is None else Outline(places_from_pixels(document.canvas_px, handles.outline))
    diagonal = float(np.hypot(*document.size_px))
    said = zip(at.tolist(), to.tolist(), handles.rings, handles.stiff_px, strict=True)
    pins = tuple(Pin((x, y), (u, v), ring, stiff=px / diagonal) for (x, y), (u, v), ring, px in said)
    document = replace(document, outline=outline, pins=pins, curves=curves)
    with faults_named(path):
        handles_of(document).probes(grid_of(document))
    return document


def with_warp_map(document: Document, found: WarpMap) -> Document:
    """Return `document` under a warp that was read, on a canvas of its size."""
    width, height = document.size_px
    aspect = found.size_px[0] / width, found.size_px[1] / height
    return document.changed(warp_map=found, surface=None).with_warp(aspect=aspect)


def frame_result(document: Document, found: Warped, framing: Framing) -> tuple[Canvas, Points]:
    """Return the canvas of a document's result, and where the nodes (R, C, 2) are on it; of a surface, its texture."""
    if document.surface is not None:
        return Canvas(*document.size_px), lay_on_surface(document, found)
    canvas = Canvas.of(framing, found.warped, document.canvas_px)
    return canvas, canvas.placed(found.warped)


def lay_on_surface(document: Document, found: Warped) -> Points:
    """Return where the nodes (R, C, 2) of a map lie in the texture of the document's surface, in the picture's pixels.

    The texture has the picture's size, and nodes of the edge that are where the chart has them lie on its edge.
    """
    assert document.surface is not None
    chart, size = document.surface.chart, np.array(document.size_px)
    extent = chart.places.max(axis=(0, 1))
    share = chart.texture_at((found.warped + 0.5) / document.canvas_px * extent)
    unmoved = (found.warped == found.plain).all(axis=-1) & found.grid.outline
    share[unmoved] = ((found.rest + 0.5) / size)[unmoved]
    return np.asarray(share * size - 0.5)


def outline_of(document: Document) -> Outline:
    """Return the document's outline, or the one nearest to where the preset takes the picture's edge."""
    if document.outline is not None:
        return document.outline
    return _outline_of_preset(document.warp, _source_of(document), document.size_px, document.canvas_px)


@lru_cache(maxsize=1)
def _outline_of_preset(
    warp: WarpSettings, source: WarpMap | Chart | None, size_px: tuple[int, int], canvas_px: tuple[int, int]
) -> Outline:
    u = np.linspace(0, 1, _EDGE_SAMPLES)
    low, high = np.zeros_like(u), np.ones_like(u)
    edges = [(u, low), (high, u), (1 - u, high), (low, 1 - u)]
    start, bend = _start(source, size_px), _bend(warp, size_px, canvas_px)
    preset = bend if start is None else compose(start, bend)
    sides = []
    for edge in edges:
        pixels = preset(pixels_from_places(size_px, np.stack(edge, axis=-1)))
        sides.append(through(places_from_pixels(canvas_px, pixels), u)[:3])
    return Outline(np.concatenate(sides))


def options_of(document: Document, lines: Lines | None = None) -> MappingOptions:
    """Return what the document says about its features, beside the lines that are to stay straight."""
    warp = document.warp
    usual = MappingOptions(
        keep=warp.keep,
        method=warp.method,
        weight=warp.weight,
        falloff=warp.falloff,
        lines=lines,
        frame=warp.frame,
    )
    limits = ((feature.number, feature.limits(rigid=warp.keep == "rigid")) for feature in document.said)
    return replace(usual, single=tuple((n, limit) for n, limit in limits if limit != usual.limits_of(n)))
