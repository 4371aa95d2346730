"""Which raster of the document the brush paints, by mode."""

from dataclasses import replace
from typing import Literal, TypeAlias

from app.editor.editor import Editor
from app.model.events import Position
from core.document.document import UNSAID, Document
from core.mesh import Mesh
from core.rasters.raster import Raster
from core.selection.features import only_marked

Layer: TypeAlias = Literal["mask", "matte", "source_mask", "regrow", "region", "protected", "covered"]
Side: TypeAlias = Literal["before", "result"]
LAYERS: dict[Layer, str] = {
    "mask": "mask",
    "matte": "matte",
    "source_mask": "source mask",
    "regrow": "what is regrown",
    "region": "region",
    "protected": "protection",
    "covered": "cover",
}
"""What the brush can paint, by its part of the document."""
BLANK: dict[Layer, int] = {"regrow": UNSAID}
"""What each holds where nothing was painted, if not 0."""
OF_CLOTH = ("region", "protected", "covered")
"""Those that Overlay mode paints."""


def choose_raster(editor: Editor) -> Layer:
    """Return which raster of the document the brush paints."""
    session = editor.session
    by_mode: dict[str, Layer] = {"retexture": session.painted, "overlay": session.painted_on_cloth}
    return by_mode.get(session.mode, "mask")


def show_painted(editor: Editor) -> None:
    """Switch on what lies over the picture where something is painted: nobody paints what does not show."""
    if not editor.session.overlays.mask:
        editor.show(overlays=replace(editor.session.overlays, mask=True))


def layer(document: Document, name: Layer) -> Raster:
    """Return a raster of the document; an empty one where it has none yet."""
    raster: Raster | None = getattr(document.cloth if name in OF_CLOTH else document, name)
    return raster or Raster.filled(*document.size_px, BLANK.get(name, 0))


def is_painted(document: Document, name: Layer) -> bool:
    """Return whether anything is painted in a raster of the document."""
    return not layer(document, name).holds_only(BLANK.get(name, 0))


def with_layer(document: Document, name: Layer, raster: Raster) -> Document:
    """Return the document with a raster exchanged; features' numbers go where the mask goes."""
    if name in OF_CLOTH:
        return document.with_cloth(**{name: raster})
    if name == "mask" and document.numbers is not None and raster is not document.mask:
        numbers = only_marked(document.numbers, raster)
        return document.changed(mask=raster, numbers=numbers, features=document.features if numbers else ())
    return document.changed(**{name: raster})


def side_at(editor: Editor, pos: Position) -> Side:
    """Return which side of a split view lies at a screen position; there is only the result where it is not split."""
    session = editor.session
    return "before" if session.compare == "split" and pos[0] < session.split * session.view.size[0] else "result"


def mesh_on(editor: Editor, side: Side) -> Mesh:
    """Return where the picture is on a side of the canvas."""
    if editor.session.mode == "retexture":
        return editor.regrowth.flat
    return editor.unwarped.answer().mesh if side == "before" else editor.answer.mesh
