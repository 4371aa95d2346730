"""What is found of the photo of a document: the layers that a texture is laid into (`overlay_texture`).

The layers belong to the picture and to `Cloth.search`, which are what they are found from. What the last searches came
to is kept, layers or a refusal, so that undo, export and the window do not search twice.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from core.arrays import InputError, Singles
from core.document.document import Document, pixels_from_places
from core.document.overlay_layers import OverlayLayers, cover_layers, layers_of, mend_layers
from core.document.overlay_settings import Search
from core.imaging import color
from core.imaging.image import Image
from core.overlay.detail.bare_layers import find_bare_layers
from core.overlay.detection.corrections import lattices_of, texel_between
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.lattice import Lattice
from core.overlay.detection.seeding import NoPatternError
from core.overlay.laying.compositing import encode, searchable
from core.overlay.storage.layers_file import detail_of, lattice_of, pack, unpacked
from core.overlay.texel import Texel
from core.progress import Job, Progress, part
from core.rasters.raster import Raster

if TYPE_CHECKING:
    from core.overlay.decomposition import Decomposition
    from core.overlay.found_cloth import FoundCloth

KEPT, KEPT_BYTES = 2, 2**27
"""So many finds are kept, and more while they and their photos take no more memory than this; and so many refusals."""
FIRST_TRIAL = 0.3
"""Share of the work that growing a lattice from a marked texel takes."""
FINDING = 0.96
"""Share of the work that is not freeing the detail of the old pattern."""
AGAIN = 0.5
"""Share of the work that finding what is mended or followed on takes, if that is to be found again."""
UNSOUGHT = "no pattern was found yet that a texture could take the place of: find the pattern first"
"""Why nothing can be laid on the cloth of a document in which no search was begun."""
_PACKED: "WeakKeyDictionary[OverlayLayers, dict[str, bytes]]" = WeakKeyDictionary()
"""Layers as files: those of a project are packed once, however often it is saved."""


@dataclass
class _Kept:
    """What the last searches came to, by the objects that they began from; used from several threads."""

    entries: list[tuple[Image, Search, OverlayLayers | NoPatternError]] = field(default_factory=list)
    lock: threading.Lock = field(default_factory=threading.Lock)
    covered: OverlayLayers | None = None
    """The last layers that were covered by hand."""

    def get(self, image: Image, search: Search) -> OverlayLayers | NoPatternError | None:
        """Return what is kept, which is the last to go from then on."""
        with self.lock:
            known = next((entry for entry in self.entries if entry[0] is image and entry[1] is search), None)
            if known is None:
                return None
            self.entries = [known, *(entry for entry in self.entries if entry is not known)]
            return known[2]

    def put(self, image: Image, search: Search, found: OverlayLayers | NoPatternError) -> None:
        with self.lock:
            finds: list[tuple[Image, Search, OverlayLayers | NoPatternError]] = []
            refusals, taken = finds.copy(), 0
            for entry in [(image, search, found), *self.entries]:
                if not isinstance(entry[2], OverlayLayers):
                    refusals.append(entry)
                    continue
                taken += entry[0].pixels.nbytes + entry[2].nbytes
                if len(finds) < KEPT or taken <= KEPT_BYTES:
                    finds.append(entry)
            self.entries = finds + refusals[:KEPT]


_kept = _Kept()


def get_layers(document: Document) -> OverlayLayers | None:
    """Return the document's layers if they are known already."""
    found = get_found(document)
    painted = _painted(document)
    if found is None or painted is None:
        return found
    last = _kept.covered
    return last if last is not None and last.uncovered is found and last.painted is painted else None


def get_found(document: Document) -> OverlayLayers | None:
    """Return the layers that are found, without what is covered by hand, if they are known already."""
    search = document.cloth.search
    outcome = None if search is None else _kept.get(document.image, search)
    return outcome if isinstance(outcome, OverlayLayers) else None


def find_layers(document: Document) -> Job[OverlayLayers]:
    """Return the document's layers, found now or before; raise `NoPatternError` where there are none.

    What is covered by hand is laid too.
    """
    painted = _painted(document)
    if painted is None:
        return (yield from _find(document))
    found = yield from part(_find(document), 0.0, FINDING)
    known = get_layers(document)
    if known is None:
        yield Progress(FINDING, "covering what is painted")
        known = _kept.covered = cover_layers(document, found, painted)
    return known


def _painted(document: Document) -> Raster | None:
    """Return what is covered by hand, None for nothing."""
    painted = document.cloth.covered
    return None if painted is None or painted.is_empty else painted


def _find(document: Document) -> Job[OverlayLayers]:
    """Return what `get_found` does, found now or before; raise `NoPatternError` where there is none."""
    search = document.cloth.search
    if search is None:
        raise InputError(UNSOUGHT)
    outcome = _kept.get(document.image, search)
    if outcome is None and search.mending is not None:
        before = yield from part(_find(document.with_cloth(search=search.mending.of)), 0.0, AGAIN)
        outcome = yield from part(mend_layers(document, before, search.mending), AGAIN, 1.0)
        _kept.put(document.image, search, outcome)
    elif outcome is None:
        try:
            result = yield from part(_decompose(document, search), 0.0, FINDING)
        except NoPatternError as refusal:
            _kept.put(document.image, search, refusal)
            raise
        yield Progress(FINDING, "freeing the detail of the old pattern")
        outcome = layers_of(result)
        _kept.put(document.image, search, outcome)
    if isinstance(outcome, NoPatternError):
        raise outcome
    return outcome


def files_of(document: Document) -> dict[str, bytes]:
    """Return the files in which a project keeps what was found of its photo; none where nothing is known."""
    layers = get_found(document)
    if layers is None:
        return {}
    if layers not in _PACKED:
        frames = layers.lattice.frames
        arrays = {
            "uv": layers.uv,
            "shading": layers.shading,
            "coverage": layers.coverage,
            "texel": layers.pattern.pixels,
            "basis": layers.basis,
            "keys": layers.lattice.keys,
            "points": frames.points,
            "bases": frames.bases,
            "scores": frames.scores,
            "explained": np.array(layers.explained),
        }
        _PACKED[layers] = pack(arrays)
    return _PACKED[layers]


def take_files(document: Document, read: Callable[[str], bytes]) -> None:
    """Take what `files_of` returned, given by `read`, for what is found of the document: no search is needed.

    Raises `InputError` where the files are damaged or of another picture.
    """
    search = document.cloth.search
    if search is None:
        return
    arrays = unpacked(read, (document.image.height_px, document.image.width_px))
    uv, shading, coverage = (np.asarray(arrays[name], np.float32) for name in ("uv", "shading", "coverage"))
    texel, basis = Texel(arrays["texel"].astype(np.float64) / 255), np.asarray(arrays["basis"], np.float64)
    detail = detail_of(encode(document.image), uv, shading, texel)
    bare = find_bare_layers(detail, uv, shading, texel, basis)
    explained = float(arrays["explained"])
    layers = OverlayLayers(uv, shading, detail, *bare, coverage, texel.pixels, basis, lattice_of(arrays), explained)
    _kept.put(document.image, search, layers)


def _decompose(document: Document, search: Search) -> "Job[Decomposition]":
    """Find the layers, of a part of the cloth or of all of it."""
    before = search.whole_of
    inside = _mark(search if before is None else before)
    try:
        if before is None:
            return (yield from _decompose_photo(document, search))
        return (yield from _decompose_whole_cloth(document, before, search.seed))
    except NoPatternError:
        raise NoPatternError("the picture" if inside is None else "the painted region") from None


def _decompose_whole_cloth(document: Document, before: Search, seed: int) -> "Job[Decomposition]":
    """Go on from what the search `before` has found, or finds now, over all of the cloth."""
    # A window opens sooner without the engine.
    from core.overlay.decomposition import decompose_whole_cloth

    # What begins at a marked texel is not found as whole cloth is: it may only tell how large a texel is.
    is_known = _kept.get(document.image, before) is not None or before.texel is not None
    finds = (yield from part(_finds_of(document, before), 0.0, AGAIN)) if is_known else None
    start, lattice = _texel_of(document, before), _lattices_of(document, before)
    region = searchable(document.image, _mark(before))
    job = decompose_whole_cloth(document.image, region=region, start=start, lattice=lattice, seed=seed, finds=finds)
    return (yield from part(job, AGAIN if is_known else 0.0, 1.0))


def _finds_of(document: Document, search: Search) -> "Job[list[FoundCloth]]":
    """Return what a search has found; none where that is no pattern."""
    try:
        found = (yield from part(_find(document.with_cloth(search=search)), 0.0, 0.5)).found
    except NoPatternError:
        return []
    if found is None:
        # Files of layers do not have it.
        found = (yield from part(_decompose(document, search), 0.5, 1.0)).found
    assert found is not None
    return [found]


def _decompose_photo(document: Document, search: Search) -> "Job[Decomposition]":
    """Find the layers; a marked texel from which no lattice grows says at least how large a texel is."""
    from core.overlay.decomposition import decompose

    photo, region = encode(document.image), searchable(document.image, _mark(search))
    start, lattice = _texel_of(document, search), _lattices_of(document, search)
    try:
        job = decompose(photo, region=region, start=start, lattice=lattice, seed=search.seed)
        return (yield from part(job, 0.0, 1.0 if start is None else FIRST_TRIAL))
    except NoPatternError:
        if start is None:
            raise
    side_px = float(np.abs(start.basis).sum()) / 2
    job = decompose(photo, region=region, texel_px=side_px, seed=search.seed)
    return (yield from part(job, FIRST_TRIAL, 1.0))


def _mark(search: Search) -> Singles | None:
    """Return the opacity (H, W) of what is laid on cloth, 0 where there is none; None for 1 everywhere."""
    if search.region is None or search.region.is_empty:
        return None
    return color.unit(search.region.array)


def _texel_of(document: Document, search: Search) -> Proposal | None:
    """Return the texel that the artist has marked, in pixels."""
    if search.texel is None:
        return None
    return texel_between(*pixels_from_places(document.size_px, np.array(search.texel)))


def _lattices_of(document: Document, search: Search) -> list[Lattice] | None:
    """Return the lattice that the artist has corrected, in connected parts and in pixels."""
    if search.lattice is None:
        return None
    places = pixels_from_places(document.size_px, search.lattice.places)
    return lattices_of(np.rint(search.lattice.keys).astype(np.int64), places)
