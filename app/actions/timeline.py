"""Actions on the timeline: to play, to go from frame to frame, and on keys."""

from app.actions import Action, ActionGroup, in_warp
from app.editor.editor import Editor
from app.marking import keying
from core.document.animated import is_animated
from core.document.keys import EASINGS, Easing


def _has_keys(editor: Editor) -> bool:
    return in_warp(editor) and is_animated(editor.document)


def _has_chosen(editor: Editor) -> bool:
    return in_warp(editor) and bool(keying.find_chosen_keys(editor))


def _is_past_first(editor: Editor) -> bool:
    return in_warp(editor) and editor.session.frame > editor.document.span.first


def _is_before_last(editor: Editor) -> bool:
    return in_warp(editor) and editor.session.frame < editor.document.span.last


def _step(editor: Editor, frames: int) -> None:
    editor.animation.go_to(editor.session.frame + frames)


def _set_keys(editor: Editor) -> None:
    editor.show(timeline=True)
    keying.set_keys(editor, keying.to_key(editor))


def _remove_chosen(editor: Editor) -> None:
    keying.remove_keys(editor, keying.find_chosen_keys(editor))


_TIMELINE = ActionGroup("timeline", "Timeline", in_warp)
_EASING = ActionGroup("timeline.easing", "Timeline/Easing", _has_chosen)

EASING_LABELS: dict[Easing, tuple[str, str]] = {
    "linear": ("Linear", "Evenly from this key to the next"),
    "hold": ("Hold", "Stays until the next key, then jumps"),
    "ease": ("Ease", "Gently at both ends"),
    "ease-in": ("Ease in", "Begins gently"),
    "ease-out": ("Ease out", "Ends gently"),
}


def _easing(easing: Easing) -> Action:
    label, tooltip = EASING_LABELS[easing]
    return _EASING.action(
        easing,
        label,
        lambda editor: keying.ease_keys(editor, keying.find_chosen_keys(editor), easing),
        tooltip=f"{tooltip}: of the selected keys",
        checked=lambda editor: keying.find_easing(editor) == easing,
    )


TIMELINE = (
    _TIMELINE.switch(
        "show",
        "Timeline",
        "timeline",
        "timeline",
        "Show the frames and the keys, and what puts keys on sliders and pins",
        "Shift+T",
    ),
    _TIMELINE.action(
        "play",
        "Play",
        lambda editor: editor.animation.toggle(),
        "play",
        "Play the frames, or stop",
        "Shift+Space",
        enabled=_has_keys,
        checked=lambda editor: editor.animation.is_playing,
        separated=True,
    ),
    _TIMELINE.switch(
        "loop",
        "Loop",
        "loops",
        "repeat",
        "Begin anew at the end",
    ),
    _TIMELINE.action(
        "first",
        "First frame",
        lambda editor: editor.animation.go_to(editor.document.span.first),
        "backward-fast",
        "Show the first frame",
        "Home",
        enabled=_is_past_first,
        separated=True,
    ),
    _TIMELINE.action(
        "previous_key",
        "Key before",
        lambda editor: keying.go_to_key(editor, forward=False),
        "backward-step",
        "Show the frame of the key before",
        "Shift+,",
        enabled=_has_keys,
    ),
    _TIMELINE.action(
        "previous",
        "Frame before",
        lambda editor: _step(editor, -1),
        "caret-left",
        "Show the frame before",
        ",",
        enabled=_is_past_first,
    ),
    _TIMELINE.action(
        "next",
        "Next frame",
        lambda editor: _step(editor, 1),
        "caret-right",
        "Show the next frame",
        ".",
        enabled=_is_before_last,
    ),
    _TIMELINE.action(
        "next_key",
        "Next key",
        lambda editor: keying.go_to_key(editor, forward=True),
        "forward-step",
        "Show the frame of the next key",
        "Shift+.",
        enabled=_has_keys,
    ),
    _TIMELINE.action(
        "last",
        "Last frame",
        lambda editor: editor.animation.go_to(editor.document.span.last),
        "forward-fast",
        "Show the last frame",
        "End",
        enabled=_is_before_last,
    ),
    _TIMELINE.action(
        "set_keys",
        "Set keys",
        _set_keys,
        "diamond",
        "Put keys at this frame: for the selected pins, else for all that has keys, else for the bend",
        "Shift+K",
        separated=True,
    ),
    _TIMELINE.action(
        "remove_keys",
        "Remove keys",
        _remove_chosen,
        "trash-can",
        "Take the selected keys out",
        "Delete",
        enabled=_has_chosen,
    ),
    *(_easing(easing) for easing in EASINGS),
)
