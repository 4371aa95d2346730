"""A pattern found again on the same photo, anew or on the whole cloth; what was put right by hand is carried over."""

from dataclasses import replace

import numpy as np

from core.arrays import Bools, Floats, Ints, Points
from core.document.document import Document, pixels_from_places
from core.document.overlay import find_layers
from core.document.overlay_layers import OverlayLayers, vertices_of
from core.document.overlay_settings import Cloth, LatticeVertices, Mending, Search
from core.masks.object_masks import as_bytes
from core.overlay.mending import CELL
from core.progress import Job, part
from core.rasters.raster import Raster


def find_whole_cloth(document: Document) -> Job[Cloth]:
    """Return the document's cloth with a search that follows what is found over all of the cloth on which it lies.

    Where nothing is painted, what stands out is said to be cloth. The layers are found then, and the region is what
    they cover. Raises `InputError` where there is no more cloth than was known, or where that explains less, and
    `NoPatternError` where there is none.
    """
    region, seed = document.cloth.region, document.cloth.seed
    before = document.cloth.search or Search(region, seed=seed)
    if before.mending is not None:
        before = before.mending.of
    cloth = yield from find_again(document, Search(seed=seed, whole_of=before))
    layers = yield from find_layers(document.changed(cloth=cloth))
    found = layers.uncovered or layers
    return cloth.changed(region=Raster.from_array(as_bytes(found.covered)))


def find_again(document: Document, search: Search) -> Job[Cloth]:
    """Return the document's cloth with `search`, mended as its own is, once its layers are found.

    Its region is the search's. Raises `NoPatternError` where none are found.
    """
    found = yield from part(find_layers(document.with_cloth(search=search)), 0.0, 0.9)
    before = document.cloth.search
    if before is not None and before.mending is not None:
        search = carry_mending(document, before.mending, search, found)
        yield from part(find_layers(document.with_cloth(search=search)), 0.9, 1.0)
    return document.cloth.changed(search=search, region=search.region)


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
