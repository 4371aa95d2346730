"""Actions on the mask and the warp."""

from types import MappingProxyType
from typing import get_args

import numpy as np

from app.actions import Action, ActionGroup, in_warp
from app.editor.editor import Editor
from app.editor.painting import BLANK, LAYERS, choose_raster, is_painted, layer, with_layer
from app.files import document_io, masks
from core.document.animated import NUMBERS
from core.document.document import Document, Keep, WarpSettings
from core.imaging.images import Image
from core.rasters.raster import Raster
from core.selection.sources import has_transparency
from core.warps.presets import PRESETS

_MASK, _WARP = ActionGroup("mask", "Mask"), ActionGroup("warp", "Warp", in_warp)
_PRESET = ActionGroup("warp.preset", "Warp/Preset", in_warp)
_KEPT = ActionGroup("warp.keep", "Warp/Features", in_warp)


def _fill(editor: Editor, value: int | None) -> None:
    """Give all of what is painted one value, None for that of nothing painted."""
    document, name = editor.document, choose_raster(editor)
    label = f"{'Clear' if value is None else 'Fill'} {LAYERS[name]}"
    value = BLANK.get(name, 0) if value is None else value
    editor.edit(label, with_layer(document, name, Raster.filled(*document.size_px, value)))


def _invert(editor: Editor) -> None:
    document, name = editor.document, choose_raster(editor)
    editor.edit(f"Invert {LAYERS[name]}", with_layer(document, name, layer(document, name).inverted))


def _has_mask(editor: Editor) -> bool:
    return is_painted(editor.document, choose_raster(editor))


def _can_fit(editor: Editor) -> bool:
    """Return whether something is painted that objects can be looked for under: neither a result nor some cloth."""
    return choose_raster(editor) in ("mask", "source_mask") and _has_mask(editor)


MASK = (
    _MASK.action("fill", "Fill mask", lambda e: _fill(e, 255), "fill-drip", "Keep everything"),
    _MASK.action(
        "clear", "Clear mask", lambda e: _fill(e, None), "eraser", "Keep nothing", "Ctrl+Shift+A", enabled=_has_mask
    ),
    _MASK.action("invert", "Invert mask", _invert, "circle-half-stroke", "Keep what was not kept", "Ctrl+I"),
    _MASK.action(
        "fit",
        "Fit mask to objects",
        masks.fit_to_objects,
        "wand-magic-sparkles",
        "Paint over something roughly; this finds its outline",
        "Ctrl+Shift+F",
        enabled=_can_fit,
    ),
    _MASK.action(
        "transparency",
        "Mask from transparency",
        masks.mark_opaque,
        "clone",
        "Mark what is opaque: every letter or cut-out is a feature of its own",
        enabled=lambda editor: has_transparency(editor.document.image),
    ),
    _MASK.action(
        "load",
        "Load mask…",
        masks.ask_mask,
        "file-import",
        "Take the mask from a picture of the same size, or from another project",
        separated=True,
    ),
    _MASK.action(
        "save",
        "Save mask…",
        masks.ask_save_mask,
        "file-export",
        "Write the mask as a picture, for other programs and the command line",
        enabled=_has_mask,
    ),
)


def choose_preset(editor: Editor, name: str) -> None:
    """Take a preset, bent visibly where the artist has not bent anything yet."""
    warp = editor.document.warp
    if name == "none":
        document = _without_own_tracks(editor.document)
        editor.edit("No preset", document.with_warp(preset=None, values=WarpSettings().values))
        return
    bent = warp.bend != 0 or "bend" in editor.document.tracks or not PRESETS[name].bends
    document, values = editor.document, warp.values
    if name != warp.preset:
        document, values = _without_own_tracks(document), WarpSettings().values
    changes = {"preset": name, "bend": warp.bend if bent else 50.0, "values": values}
    editor.edit(f"Preset {PRESETS[name].label}", document.with_warp(**changes))


def _without_own_tracks(document: Document) -> Document:
    """Return the document without keys of parameters that only its preset has."""
    kept = {name: track for name, track in document.tracks.items() if name in NUMBERS}
    return document if len(kept) == len(document.tracks) else document.changed(tracks=MappingProxyType(kept))


_RESET = ("preset", "bend", "horizontal", "vertical", "vertical_axis", "values", "aspect")


def reset_warp(editor: Editor) -> None:
    """Take preset, sliders and size back, and their keys; how features are kept stays."""
    still = editor.document if not editor.document.tracks else editor.document.changed(tracks=MappingProxyType({}))
    editor.edit("Reset warp", still.with_warp(**{name: getattr(_PLAIN, name) for name in _RESET}))


def _is_bent(editor: Editor) -> bool:
    """Return whether there is anything that `reset_warp` takes back."""
    document = editor.document
    bends = any(getattr(document.warp, name) != getattr(_PLAIN, name) for name in _RESET)
    return in_warp(editor) and (bends or bool(document.tracks))


def _has_warp(editor: Editor) -> bool:
    """Return whether there is a warp to copy."""
    return _is_bent(editor) or (in_warp(editor) and any(getattr(editor.document, part) for part in COPIED[1:]))


def _preset(name: str) -> Action:
    preset = PRESETS[name]
    return _PRESET.action(
        name,
        preset.label,
        lambda editor: choose_preset(editor, name),
        tooltip=f"Warp by {preset.label}" if name != "none" else "Warp by nothing but handles",
        checked=lambda editor: (editor.document.warp.preset or "none") == name,
    )


_KEEP = {
    "similarity": ("Keep shape", "Features may turn, move and change their size"),
    "rigid": ("Keep shape and size", "Features may turn and move"),
    "none": ("Keep nothing", "The plain warp"),
}


def _keep(keep: Keep) -> Action:
    label, tooltip = _KEEP[keep]
    return _KEPT.action(
        keep,
        label,
        lambda editor: editor.edit(label, editor.document.with_warp(keep=keep)),
        tooltip=tooltip,
        checked=lambda editor: editor.document.warp.keep == keep,
    )


def _toggle_axis(editor: Editor) -> None:
    editor.edit("Turn axis", editor.document.with_warp(vertical_axis=not editor.document.warp.vertical_axis))


def _paste(editor: Editor) -> None:
    """Do to this picture what was done to the one whose warp was copied; places are shares of the picture's size."""
    copied = editor.session.copied_warp
    assert copied is not None
    parts = {name: getattr(copied, name) for name in COPIED}
    editor.animation.edit("Paste warp", editor.document.changed(**parts))


_PLAIN = WarpSettings()
_NO_PICTURE = Image(np.zeros((1, 1, 1), np.uint8))
COPIED = ("warp", "outline", "pins", "curves", "warp_map", "surface", "tracks")
"""The parts of a document that make its warp; the mask stays with its picture."""

WARP = (
    *(_preset(name) for name in PRESETS),
    *(_keep(keep) for keep in get_args(Keep)),
    _WARP.action(
        "vertical_axis",
        "Vertical axis",
        _toggle_axis,
        "arrows-up-down",
        "Bend along the other axis",
        checked=lambda editor: editor.document.warp.vertical_axis,
    ),
    _WARP.action("reset", "Reset warp", reset_warp, "arrow-rotate-left", "Take the preset back", enabled=_is_bent),
    _WARP.action(
        "copy",
        "Copy warp",
        lambda editor: editor.show(copied_warp=editor.document.with_image(_NO_PICTURE)),
        "copy",
        "Take preset, outline, pins and curves, to be pasted on another picture",
        "Ctrl+Alt+C",
        enabled=_has_warp,
        separated=True,
    ),
    _WARP.action(
        "paste",
        "Paste warp",
        _paste,
        "paste",
        "Do to this picture what was done to the one whose warp was copied; the mask stays",
        "Ctrl+Alt+V",
        enabled=lambda editor: in_warp(editor) and editor.session.copied_warp is not None,
    ),
    _WARP.action(
        "export",
        "Export warp…",
        document_io.ask_export_warp,
        "file-export",
        "Write the warp itself for other programs: an ST map (EXR) or a mesh with texture coordinates (OBJ)",
        separated=True,
    ),
)
