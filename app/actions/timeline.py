"""Actions on the timeline: to play, to go from frame to frame, and on keys."""

from app.actions import Action
from app.editor.editor import Editor
from app.marking import keying
from core.document.animated import is_animated
from core.document.keys import EASINGS, Easing


def _in_warp(editor: Editor) -> bool:
    return editor.session.mode == "warp"


def _has_keys(editor: Editor) -> bool:
    return _in_warp(editor) and is_animated(editor.document)


def _has_chosen(editor: Editor) -> bool:
    return _in_warp(editor) and bool(keying.find_chosen_keys(editor))


def _step(editor: Editor, frames: int) -> None:
    editor.animation.go_to(editor.session.frame + frames)


def _set_keys(editor: Editor) -> None:
    editor.show(timeline=True)
    keying.set_keys(editor, keying.to_key(editor))


def _remove_chosen(editor: Editor) -> None:
    keying.remove_keys(editor, keying.find_chosen_keys(editor))


EASING_LABELS: dict[Easing, tuple[str, str]] = {
    "linear": ("Linear", "Evenly from this key to the next"),
    "hold": ("Hold", "Stays until the next key, then jumps"),
    "ease": ("Ease", "Gently at both ends"),
    "ease-in": ("Ease in", "Begins gently"),
    "ease-out": ("Ease out", "Ends gently"),
}


def _easing(easing: Easing) -> Action:
    label, tooltip = EASING_LABELS[easing]
    return Action(
        f"timeline.easing.{easing}",
        label,
        "Timeline/Easing",
        lambda editor: keying.ease_keys(editor, keying.find_chosen_keys(editor), easing),
        tooltip=f"{tooltip}: of the selected keys",
        enabled=_has_chosen,
        checked=lambda editor: keying.find_easing(editor) == easing,
    )


TIMELINE = (
    Action(
        "timeline.show",
        "Timeline",
        "Timeline",
        lambda editor: editor.show(timeline=not editor.session.timeline),
        "Shift+T",
        "timeline",
        "Show the frames and the keys, and what puts keys on sliders and pins",
        enabled=_in_warp,
        checked=lambda editor: editor.session.timeline,
    ),
    Action(
        "timeline.play",
        "Play",
        "Timeline",
        lambda editor: editor.animation.toggle(),
        "Shift+Space",
        "play",
        "Play the frames, or stop",
        enabled=_has_keys,
        checked=lambda editor: editor.animation.is_playing,
        separated=True,
    ),
    Action(
        "timeline.loop",
        "Loop",
        "Timeline",
        lambda editor: editor.show(loops=not editor.session.loops),
        icon="repeat",
        tooltip="Begin anew at the end",
        checked=lambda editor: editor.session.loops,
    ),
    Action(
        "timeline.first",
        "First frame",
        "Timeline",
        lambda editor: editor.animation.go_to(editor.document.span.first),
        "Home",
        "backward-fast",
        "Show the first frame",
        enabled=_in_warp,
        separated=True,
    ),
    Action(
        "timeline.previous_key",
        "Key before",
        "Timeline",
        lambda editor: keying.go_to_key(editor, forward=False),
        "Shift+,",
        "backward-step",
        "Show the frame of the key before",
        enabled=_has_keys,
    ),
    Action(
        "timeline.previous",
        "Frame before",
        "Timeline",
        lambda editor: _step(editor, -1),
        ",",
        "caret-left",
        "Show the frame before",
        enabled=_in_warp,
    ),
    Action(
        "timeline.next",
        "Next frame",
        "Timeline",
        lambda editor: _step(editor, 1),
        ".",
        "caret-right",
        "Show the next frame",
        enabled=_in_warp,
    ),
    Action(
        "timeline.next_key",
        "Next key",
        "Timeline",
        lambda editor: keying.go_to_key(editor, forward=True),
        "Shift+.",
        "forward-step",
        "Show the frame of the next key",
        enabled=_has_keys,
    ),
    Action(
        "timeline.last",
        "Last frame",
        "Timeline",
        lambda editor: editor.animation.go_to(editor.document.span.last),
        "End",
        "forward-fast",
        "Show the last frame",
        enabled=_in_warp,
    ),
    Action(
        "timeline.set_keys",
        "Set keys",
        "Timeline",
        _set_keys,
        "Shift+K",
        "diamond",
        "Put keys at this frame: for the selected pins, else for all that has keys, else for the bend",
        enabled=_in_warp,
        separated=True,
    ),
    Action(
        "timeline.remove_keys",
        "Remove keys",
        "Timeline",
        _remove_chosen,
        "Delete",
        "trash-can",
        "Take the selected keys out",
        enabled=_has_chosen,
    ),
    *(_easing(easing) for easing in EASINGS),
)
