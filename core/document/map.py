"""From a document to its map: what the window shows at rest, and what is saved, reopened and exported.

The preset warps the picture; the outline, the pins and the inner curves edit the preset's result; the features then
keep their shape within that. `settle_map` is the one way to the final answer. It begins from nothing but the document,
so that the same document gives the same bits, on screen and in a file.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from core.arrays import Points, readonly
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
from core.document.straight_lines import straight_lines_of
from core.files.faults import faults_named
from core.grid import Features, Grid
from core.linalg.grid_solver import GridSolver
from core.linalg.multifrontal import GridFactor
from core.mapping.handles.handles import Handles
from core.mapping.options import MappingOptions
from core.mapping.result import Warped
from core.mapping.warper import Warper
from core.progress import Job
from core.selection.nodes import MarkedNodes
from core.surfaces.chart import Chart
from core.warps.map_file import WarpMap
from core.warps.outline import follow_outline
from core.warps.presets import make_warp
from core.warps.warp import Warp, compose, resize

_EDGE_SAMPLES = 65
"""Points of a side at which a cubic is fitted to it."""


def grid_of(document: Document) -> Grid:
    """Return the grid over the document's picture."""
    return Grid(*document.size_px, cell_px=document.warp.cell_px)


def preset_of(document: Document) -> Warp:
    """Return the map, the preset and the resizing, from pixels of the picture to pixels of the canvas."""
    return _preset(document.warp, _source_of(document), document.size_px, document.canvas_px)


def _source_of(document: Document) -> WarpMap | Chart | None:
    """Return what takes the picture where the preset begins."""
    return document.warp_map if document.surface is None else document.surface.chart


def _preset(
    warp: WarpSettings, source: WarpMap | Chart | None, size_px: tuple[int, int], canvas_px: tuple[int, int]
) -> Warp:
    bent = make_warp(
        warp.preset or "none",
        *size_px,
        bend=warp.bend,
        horizontal=warp.horizontal,
        vertical=warp.vertical,
        vertical_axis=warp.vertical_axis,
        settings=warp.values,
    )
    bent = compose(bent, resize(size_px, canvas_px))
    if source is None:
        return bent
    given_px = source.size_px(size_px) if isinstance(source, Chart) else source.size_px
    return compose(source.warp(size_px), resize(given_px, size_px), bent)


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
    pins = tuple(
        Pin((x, y), (u, v), ring) for (x, y), (u, v), ring in zip(at.tolist(), to.tolist(), handles.rings, strict=True)
    )
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
    preset = _preset(warp, source, size_px, canvas_px)
    sides = []
    for edge in edges:
        pixels = preset(pixels_from_places(size_px, np.stack(edge, axis=-1)))
        sides.append(through(places_from_pixels(canvas_px, pixels), u)[:3])
    return Outline(np.concatenate(sides))


def options_of(document: Document) -> MappingOptions:
    """Return what the document says about its features."""
    warp = document.warp
    usual = MappingOptions(
        keep=warp.keep,
        method=warp.method,
        weight=warp.weight,
        falloff=warp.falloff,
        lines=straight_lines_of(document),
        frame=warp.frame,
    )
    limits = ((feature.number, feature.limits(rigid=warp.keep == "rigid")) for feature in document.said)
    return replace(usual, single=tuple((n, limit) for n, limit in limits if limit != usual.limits_of(n)))


def settle_map(document: Document) -> Job[Warped]:
    """Return the map of `document`, without folds where W has none."""
    return (yield from MapSolver().settle(document))


class MapSolver:
    """What is worth keeping from one answer to the next: analyses, factors and responses, while their inputs stay.

    For one thread at a time. Raises `InputError` for a document that has no map. `analyse` makes what solves the system
    of a grid of that shape.
    """

    def __init__(self, *, analyse: Callable[[tuple[int, int]], GridSolver] = GridFactor) -> None:
        self._analyse = analyse
        self._live: Warper | None = None
        self._marked: MarkedNodes | None = None
        self._base: tuple[object, Points] | None = None

    def is_heavy(self, document: Document) -> bool:
        """Return whether the next answer needs more than a frame's time: another grid, or straight lines."""
        live = self._live
        if live is None or live.grid != grid_of(document):
            return True
        return not live.is_ready(self._features_of(live.grid, document), options_of(document))

    def frame(self, document: Document) -> Warped:
        """Return the linear answer, which may fold: a solve, and a factorisation where structure changed."""
        live = self._prepared(document)
        return live.frame(self._base_of(document, live.grid), handles_of(document))

    def settle(self, document: Document, *, near: Warped | None = None) -> Job[Warped]:
        """Return the answer without folds where W has none; the same bits, whatever was answered before.

        Of several answers that are about as good, it is the one next to that of a document that is `near`.
        """
        live = self._prepared(document)
        reference = None if near is None else near.reference
        return (yield from live.settle(self._base_of(document, live.grid), handles_of(document), near=reference))

    def folds(self, document: Document) -> bool:
        """Return whether the linear answer folds where W does not, so that there may be several answers at rest."""
        live = self._prepared(document)
        return live.folds(self._base_of(document, live.grid))

    def learn(self, document: Document, settled: Warped) -> None:
        """Take the picture without handles from an answer at rest to the same document."""
        live = self._prepared(document)
        if settled.reference is not None:
            live.learn(self._base_of(document, live.grid), settled.reference)

    def _base_of(self, document: Document, grid: Grid) -> Points:
        """Return where preset and outline take the nodes, kept while pins and curves are dragged."""
        key = (document.warp, _source_of(document), document.size_px, document.outline)
        if self._base is None or self._base[0] != key or self._base[1].shape[:2] != grid.shape:
            base = preset_of(document)(grid.nodes)
            if document.outline is not None:
                base = follow_outline(base, pixels_from_places(document.canvas_px, document.outline.ring))
            self._base = key, readonly(base)
        return self._base[1]

    def _prepared(self, document: Document) -> Warper:
        live = self._on_grid(document)
        live.use(self._features_of(live.grid, document), options_of(document))
        return live

    def _on_grid(self, document: Document) -> Warper:
        grid = grid_of(document)
        if self._live is None or self._live.grid != grid:
            self._live = Warper(grid, analyse=self._analyse)
            self._marked = None
        return self._live

    def _features_of(self, grid: Grid, document: Document) -> Features:
        """Return the features of the document, the same object as before while no node's number changed."""
        if self._marked is None:
            self._marked = MarkedNodes(grid)
        return self._marked.features(document.mask, document.numbers, document.given_up)
