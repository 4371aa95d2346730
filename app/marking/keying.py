"""Keys on the timeline: what can have them, which are selected, and what is done to them."""

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace

from app.editor.editor import Editor
from core.arrays import InputError
from core.document.animated import NUMBERS, Animated, key_frames, tracks_of, value_of, with_track
from core.document.document import Document
from core.document.keys import Easing, Span, Track, with_easing, with_key, with_moved_keys, without_keys
from core.warps.presets import PRESETS

Chosen = Mapping[Animated, Collection[float]]
"""Frames of keys by what has them."""


def name_of(document: Document, what: Animated) -> str:
    """Return what a parameter or a pin is called on the panels."""
    if isinstance(what, int):
        return f"Pin {what + 1}"
    own = {setting.name: setting.label for setting in PRESETS[document.warp.preset or "none"].settings}
    return what.capitalize() if what in NUMBERS else own.get(what, what)


def has_key(editor: Editor, what: Animated) -> bool:
    """Return whether there is a key at the frame that is shown."""
    return any(key.frame == editor.session.frame for key in tracks_of(editor.document).get(what, ()))


def set_keys(editor: Editor, whats: Collection[Animated]) -> None:
    """Put keys with the present values at the frame that is shown."""
    document, frame = editor.document, editor.session.frame
    for what in whats:
        track = tracks_of(document).get(what, ())
        document = with_track(document, what, with_key(track, frame, value_of(document, what)))
    editor.animation.edit(_label("Set key", len(whats)), document)


def toggle_key(editor: Editor, what: Animated) -> None:
    """Put a key at the frame that is shown, or take it out."""
    if has_key(editor, what):
        remove_keys(editor, {what: (editor.session.frame,)})
    else:
        set_keys(editor, (what,))


def to_key(editor: Editor) -> tuple[Animated, ...]:
    """Return what a key is set for at once: the selected pins, else all that has keys, else the bend."""
    pins = sorted(number for number in editor.session.selected if number < len(editor.document.pins))
    return tuple(pins) or tuple(tracks_of(editor.document)) or ("bend",)


def find_chosen_keys(editor: Editor) -> dict[Animated, frozenset[float]]:
    """Return the selected keys that there are."""
    selected = editor.session.selected_keys
    found = {
        what: frozenset(key.frame for key in track if (what, key.frame) in selected)
        for what, track in tracks_of(editor.document).items()
    }
    return {what: frames for what, frames in found.items() if frames}


def select_keys(editor: Editor, keys: Collection[tuple[Animated, float]]) -> None:
    """Select keys, and nothing else that the Delete key could be meant for."""
    editor.show(selected_keys=frozenset(keys))
    if keys:
        editor.show(selected=frozenset(), selected_knots=frozenset(), selected_corners=frozenset())


def remove_keys(editor: Editor, chosen: Chosen) -> None:
    """Take keys out; what is left without any keeps its present value."""
    document = _each(editor.document, chosen, without_keys)
    editor.animation.edit(_label("Remove key", _count(chosen)), document)


def ease_keys(editor: Editor, chosen: Chosen, easing: Easing) -> None:
    """Choose how the values go from keys to those after them."""
    document = _each(editor.document, chosen, lambda track, frames: with_easing(track, frames, easing))
    editor.animation.edit("Easing", document)


def find_easing(editor: Editor) -> Easing | None:
    """Return the easing that all selected keys have."""
    tracks, chosen = tracks_of(editor.document), find_chosen_keys(editor)
    found = {key.easing for what, frames in chosen.items() for key in tracks[what] if key.frame in frames}
    return found.pop() if len(found) == 1 else None


def move_keys(editor: Editor, start: Document, chosen: Chosen, by: int) -> None:
    """While keys are dragged: show `start` with keys moved by whole frames, and select them where they are now."""
    document = _each(start, chosen, lambda track, frames: with_moved_keys(track, frames, by))
    editor.animation.slide(_label("Move key", _count(chosen)), document)
    select_keys(editor, {(what, frame + by) for what, frames in chosen.items() for frame in frames})


def set_span(editor: Editor, **changes: float) -> None:
    """Change the first or the last frame, or the frames a second; say what cannot be."""
    try:
        span: Span = replace(editor.document.span, **changes)  # type: ignore[arg-type]
    except InputError as fault:
        editor.fail(fault)
        return
    if span != editor.document.span:
        editor.edit("Timeline", editor.document.changed(span=span))
    editor.animation.go_to(editor.session.frame)


def go_to_key(editor: Editor, *, forward: bool) -> None:
    """Show the next frame that has a key, or the one before."""
    frames, now = key_frames(editor.document), editor.session.frame
    place = bisect_right(frames, now) if forward else bisect_left(frames, now) - 1
    if 0 <= place < len(frames):
        editor.animation.go_to(frames[place])


def _each(document: Document, chosen: Chosen, change: Callable[[Track, Collection[float]], Track]) -> Document:
    """Return the document with `change` done to the keys of every track that are chosen."""
    tracks = tracks_of(document)
    for what, frames in chosen.items():
        document = with_track(document, what, change(tracks[what], frames))
    return document


def _count(chosen: Chosen) -> int:
    return sum(map(len, chosen.values()))


def _label(text: str, count: int) -> str:
    return text if count == 1 else f"{text}s"
