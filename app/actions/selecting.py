"""Actions on selections: how they meet what is painted, which feature they are of, and how the mask is refined."""

from collections.abc import Callable
from dataclasses import replace

from app.actions import Action, ActionGroup, in_warp
from app.editor.editor import Editor
from app.editor.painting import choose_raster, is_painted
from app.marking.applying import refine
from app.marking.feature_list import merge
from app.model.session import Part
from core.arrays import Bytes
from core.selection import refining
from core.selection.combining import Combining

_HOW: tuple[tuple[Combining, str, str, str], ...] = (
    ("replace", "Replace", "square", "A selection takes the place of what is painted"),
    ("add", "Add", "plus", "A selection is added to what is painted; with Shift always"),
    ("subtract", "Cut out", "minus", "A selection is cut out of what is painted; with Alt always"),
    ("intersect", "Intersect", "clone", "Of what is painted only what is selected stays; with Shift and Alt always"),
)
_PARTS: tuple[tuple[Part, str, str, str], ...] = (
    ("joined", "One with what it touches", "object-group", "What is painted next is one feature with what it touches"),
    (
        "new",
        "A new feature",
        "square-plus",
        "Every stroke and selection is a new feature, also where it touches others",
    ),
    ("chosen", "The chosen feature", "bullseye", "What is painted next is of the feature that is chosen in the list"),
)
_REFINED: tuple[tuple[str, str, str, str, Callable[[Bytes, float], Bytes]], ...] = (
    ("grow", "Grow", "maximize", "Make what is painted larger all around", refining.grow),
    ("shrink", "Shrink", "minimize", "Make what is painted smaller all around", lambda m, px: refining.grow(m, -px)),
    ("smooth", "Smooth", "wave-square", "Take corners and spikes off its outline", refining.smooth),
    ("feather", "Feather", "feather", "Give it a soft edge", refining.feather),
    ("fill_holes", "Fill holes", "fill", "Paint what it encloses", lambda m, _: refining.fill_holes(m)),
)
REFINED = tuple(f"mask.{row[0]}" for row in _REFINED)


def set_selecting(editor: Editor, **changes: object) -> None:
    """Set the tools that select."""
    editor.show(selecting=replace(editor.session.selecting, **changes))  # type: ignore[arg-type]


def _is_painted(editor: Editor) -> bool:
    return is_painted(editor.document, choose_raster(editor))


def _paints_features_or_masks(editor: Editor) -> bool:
    return editor.session.mode != "overlay"


_SELECT = ActionGroup("select", "Mask/Selections", _paints_features_or_masks)
_FEATURES = ActionGroup("features", "Mask/Features", in_warp)
_REFINE = ActionGroup("mask", "Mask/Refine", _is_painted)


def _choose_how(editor: Editor, how: Combining) -> None:
    set_selecting(editor, how=how)


def _present_how(editor: Editor) -> Combining:
    return editor.session.selecting.how


def _switch(name: str, label: str, icon: str, tooltip: str) -> Action:
    """Return the action that switches a part of `Selecting`."""
    return _SELECT.action(
        name,
        label,
        lambda editor: set_selecting(editor, **{name: not getattr(editor.session.selecting, name)}),
        icon,
        tooltip,
        checked=lambda editor: bool(getattr(editor.session.selecting, name)),
        separated=name == "contiguous",
    )


def _part(part: Part, label: str, icon: str, tooltip: str) -> Action:
    return _FEATURES.action(
        part,
        label,
        lambda editor: editor.show(part="joined" if editor.session.part == part else part),
        icon,
        tooltip,
        "N" if part == "new" else "",
        enabled=lambda editor: in_warp(editor) and (part != "chosen" or bool(editor.session.features)),
        checked=lambda editor: editor.session.part == part,
    )


def _refine(name: str, label: str, icon: str, tooltip: str, change: Callable[[Bytes, float], Bytes]) -> Action:
    def run(editor: Editor) -> None:
        refine(editor, label, lambda mask: change(mask, editor.session.selecting.refine_px))

    return _REFINE.action(name, label, run, icon, tooltip)


SELECTING = (
    *(_SELECT.choice(how, label, _choose_how, _present_how, *shown) for how, label, *shown in _HOW),
    _switch("contiguous", "Only what hangs together", "link", "The wand takes what hangs together with the click only"),
    _switch("by_stroke", "Objects by rough paint", "paintbrush", "Paint over an object instead of dragging a box"),
    *(_part(*row) for row in _PARTS),
    _FEATURES.action(
        "merge",
        "Make one feature",
        lambda editor: merge(editor, "Make one feature", editor.session.features),
        "object-group",
        "Let the features that are chosen in the list, with Shift several, move as one, however far apart",
        enabled=lambda editor: editor.session.mode == "warp" and len(editor.session.features) > 1,
        separated=True,
    ),
    *(_refine(*row) for row in _REFINED),
)
