"""A pattern found again on the same photo, anew or on the whole cloth; what was put right by hand is carried over."""

from dataclasses import replace

import numpy as np

from core.arrays import Bools, Floats, InputError, Ints, Points
from core.document.document import Document, pixels_from_places
from core.document.overlay import OverlayLayers, find_layers, vertices_of
from core.document.overlay_settings import LatticeVertices, Mending, Search
from core.masks.object_masks import as_bytes
from core.overlay.detection.corrections import lattices_of
from core.overlay.mending import CELL
from core.overlay.whole_cloth import widen
from core.progress import Job, part
from core.rasters.raster import Raster


def find_whole_cloth(document: Document) -> Job[Search]:
    """Return the search whose lattice goes on over all of the cloth on which the document's own was found.

    Its layers are found then. Raises `InputError` where there is no more cloth, or where the search explains less.
    """
    layers = yield from find_layers(document)
    search = Search(lattice=_connected_vertices(document, layers), seed=document.cloth.seed)

    def find_on(cloth: Bools) -> Job[OverlayLayers]:
        nonlocal search
        search = replace(search, region=Raster.from_array(as_bytes(cloth)))
        return find_layers(document.with_cloth(search=search))

    yield from part(widen(document.image, layers, find_on), 0.0, 0.9)
    return (yield from part(find_again(document, search), 0.9, 1.0))


def _connected_vertices(document: Document, layers: OverlayLayers) -> LatticeVertices | None:
    """Return the vertices of what was found, None where texels are so large that none of them are neighbours."""
    try:
        lattices_of(layers.lattice.keys, layers.lattice.frames.points)
    except InputError:
        return None
    return vertices_of(document, layers)


def find_again(document: Document, search: Search) -> Job[Search]:
    """Return `search`, mended as the document's own is, once its layers are found; raise `NoPatternError` for none."""
    found = yield from part(find_layers(document.with_cloth(search=search)), 0.0, 0.9)
    before = document.cloth.search
    if before is None or before.mending is None:
        return search
    mended = carry_mending(document, before.mending, search, found)
    yield from part(find_layers(document.with_cloth(search=mended)), 0.9, 1.0)
    return mended


def carry_mending(document: Document, mending: Mending, search: Search, found: OverlayLayers) -> Search:
    """Return `search`, by which `found` was found, mended once more as `mending` says.

    A vertex found where one is held lies where the hand has it, and is held; one found where one was removed goes;
    seams stay. Where means within the half of a texel around it.
    """
    size_px, lattice = document.size_px, vertices_of(document, found)
    places, keys = lattice.places.copy(), lattice.keys
    held = _are_in(mending.lattice.keys, mending.held)
    goals = mending.lattice.places[held]
    row, is_near = _find_nearest(pixels_from_places(size_px, goals), found)
    row, goals = row[is_near], goals[is_near]
    places[row] = goals
    gone, is_gone = _find_nearest(pixels_from_places(size_px, mending.removed), found)
    kept = np.ones(len(keys), np.bool_)
    kept[gone[is_gone]] = False
    kept[row] = True
    vertices = LatticeVertices(keys[kept], places[kept])
    return replace(search, mending=replace(mending, of=search, lattice=vertices, held=keys[np.unique(row)]))


def _are_in(keys: Points, some: Points) -> Bools:
    """Return which of the lattice coordinates `keys` (n, 2) are among `some` (k, 2)."""
    wanted = {tuple(key) for key in np.rint(some).tolist()}
    return np.array([tuple(key) in wanted for key in np.rint(keys).tolist()], np.bool_)


def _find_nearest(points: Floats, found: OverlayLayers) -> tuple[Ints, Bools]:
    """Return the vertices (k,) nearest to `points` (k, 2), pixels, and whether each point is in its vertex's cell."""
    frames = found.lattice.frames
    row = np.linalg.norm(frames.points - points[:, None], axis=-1).argmin(1)
    inside = np.linalg.solve(frames.bases[row], (points - frames.points[row])[..., None])[..., 0]
    return np.asarray(row, np.int64), np.asarray((np.abs(inside) <= CELL).all(1), np.bool_)
