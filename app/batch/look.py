"""What a recipe does to a picture: its document, at every frame."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from app.batch.frames import is_numbered, numbered
from app.batch.plan import Batch
from app.batch.recipe import KeyTable, PinTable, Recipe, RecipeTable
from core.document.animated import NUMBERS, document_at, is_animated, key_frames
from core.document.document import Document, Pin, places_from_pixels
from core.document.keys import KeyFrame, Track, check_track
from core.document.map import preset_of, with_handles, with_warp_map
from core.document.mask_file import with_mask_file, with_said
from core.document.project import load_project
from core.files.faults import faults_named
from core.imaging.images import Image
from core.notices import hear_notices
from core.warps.map_file import warp_map_of

_WARP_NAMES = {"cell": "cell_px", "outline": "frame"}
"""Keys of `[warp]` that `WarpSettings` calls otherwise."""


class Look:
    """The document of a batch, and what is found once for all of its frames."""

    def __init__(self, batch: Batch) -> None:
        self._recipe, self._table = batch.recipe, batch.recipe.table
        self._base = base_document(batch)
        self._masks, self._st_maps, self._displacements = (
            str(self._recipe.place(name)) if name is not None and is_numbered(name) else None
            for name in (self._table.mask, self._table.stmap, self._table.displacement)
        )
        self._sized = self._base

    @property
    def base(self) -> Document:
        """The document before any frame."""
        return self._base

    @property
    def moves(self) -> bool:
        """Whether the warp is another in every frame."""
        return is_animated(self._base) or any((self._masks, self._st_maps, self._displacements))

    def inputs(self, frame: int, source: str) -> list[str]:
        """Return the files that belong to one frame."""
        found = [source] if source else []
        sequences = self._masks, self._st_maps, self._displacements
        return found + [numbered(name, frame) for name in sequences if name is not None]

    def at(self, frame: int, picture: Image | None) -> Document:
        """Return the document at a frame whose picture is given, None for the document's own.

        In Overlay, the picture is the new texture. The masks stay the same objects while the size does, so that
        features are found once.
        """
        document = self._base
        if picture is not None and document.mode == "overlay":
            document = document.with_cloth(texture=picture)
        elif picture is not None:
            if picture.size_px != self._sized.size_px:
                self._sized = self._base.with_image(picture)
            document = self._sized.changed(image=picture)
        if self._masks is not None:
            with hear_notices():  # what is said of a mask is said of all of them, and only once
                document = with_mask_file(document, Path(numbered(self._masks, frame)))
            document = with_said(document, self._table.said, only_there=True)
        st_map, displacement = (_of_frame(name, frame) for name in (self._st_maps, self._displacements))
        found = warp_map_of(st_map, displacement)
        return document_at(document if found is None else document.changed(warp_map=found), frame)


def _of_frame(name: str | None, frame: int) -> Path | None:
    """Return the file of a frame in a sequence."""
    return None if name is None else Path(numbered(name, frame))


def base_document(batch: Batch) -> Document:
    """Return the recipe's document, on its project's picture or on a blank one of the first picture's size.

    Raises `InputError` that names the file that is at fault.
    """
    recipe, table = batch.recipe, batch.recipe.table
    if recipe.project is not None:
        document = load_project(recipe.project)
    else:
        document = Document.of(Image(np.broadcast_to(np.uint8(0), (*reversed(batch.size_px), 1))))
    names = (table.stmap, table.displacement)
    places = (None if name is None else str(recipe.place(name)) for name in names)
    found = warp_map_of(*(_of_frame(place, batch.first.frame) for place in places))
    if found is not None:
        document = with_warp_map(document, found)
    with faults_named(recipe.path):
        document = with_keys(with_warp(document, recipe, table), table)
        for frame in {batch.first.frame, *key_frames(document)}:
            preset_of(document_at(document, frame))
    if table.handles is not None:
        document = with_handles(document, recipe.place(table.handles))
    if table.mask is not None and is_numbered(table.mask):
        return document
    if table.mask is not None:
        document = with_mask_file(document, recipe.place(table.mask))
    with faults_named(recipe.path):
        return with_said(document, table.said)


def with_warp(document: Document, recipe: Recipe, table: RecipeTable) -> Document:
    """Return the document with what `[warp]` and `[[pins]]` say."""
    given = recipe.data.get("warp", {})
    changes = {_WARP_NAMES.get(name, name): getattr(table.warp, name) for name in given if name != "size"}
    if table.warp.size is not None:
        width, height = document.size_px
        changes["aspect"] = table.warp.size[0] / width, table.warp.size[1] / height
    document = document.with_warp(**changes)
    return (
        document.changed(pins=(*document.pins, *(_pin(document, pin) for pin in table.pins)))
        if table.pins
        else document
    )


def with_keys(document: Document, table: RecipeTable) -> Document:
    """Return the document with the tracks of `[keys]`, each in the place of the project's."""
    if not table.keys:
        return document
    tracks = {name: _track(document, name, keys) for name, keys in table.keys.items()}
    return document.changed(tracks={**document.tracks, **tracks})


def _track(document: Document, name: str, keys: tuple[KeyTable, ...]) -> Track:
    """Return the track of a parameter; sizes become shares of the picture's."""
    track = tuple(KeyFrame(key.frame, key.value, key.easing) for key in keys)
    check_track(track, NUMBERS.get(name, 1), name)
    if name != "size":
        return track
    width, height = document.size_px
    return tuple(replace(key, value=(key.value[0] / width, key.value[1] / height)) for key in track)


def _pin(document: Document, pin: PinTable) -> Pin:
    """Return a pin whose recipe is in pixels."""
    x, y = places_from_pixels(document.size_px, np.array(pin.at)).tolist()
    place: Callable[[tuple[float, float]], tuple[float, float]] = lambda at: tuple(  # noqa: E731
        places_from_pixels(document.canvas_px, np.array(at)).tolist()
    )
    keys = tuple(KeyFrame(key.frame, place(key.to), key.easing) for key in pin.keys)
    return Pin((x, y), keys[0].value if pin.to is None else place(pin.to), keys=keys)  # type: ignore[arg-type]
