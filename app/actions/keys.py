"""Which key does what: the keys of Weft, those that Photoshop's or Krita's users know, and those the artist has set."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType

from app.actions import Action

Keys = tuple[tuple[str, str], ...]
"""Names of actions and the chords that the artist gave them; an empty chord takes the key away."""

PRESETS: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "weft": MappingProxyType({}),
        "photoshop": MappingProxyType(
            {
                "tool.rectangle": "M",
                "tool.ellipse": "Shift+M",
                "tool.lasso": "L",
                "tool.polygon": "Shift+L",
                "tool.wand": "W",
                "tool.object": "Shift+W",
                "tool.colour-range": "I",
                "tool.resize": "Ctrl+Alt+I",
                "mask.clear": "Ctrl+D",
                "mask.invert": "Ctrl+Shift+I",
                "mask.fill": "Ctrl+A",
                "mask.feather": "Shift+F6",
                "handles.select_all": "Ctrl+Alt+A",
                "view.overlay.mask": "Q",
                "view.overlay.grid": "Ctrl+'",
                "view.panels": "Tab",
                "file.export": "Ctrl+Alt+Shift+S",
                "edit.preferences": "Ctrl+K",
            }
        ),
        "krita": MappingProxyType(
            {
                "tool.rectangle": "Ctrl+R",
                "tool.ellipse": "J",
                "view.unwarped": "Shift+J",
                "tool.lasso": "L",
                "tool.wand": "W",
                "tool.resize": "Ctrl+Alt+I",
                "mask.fill": "Ctrl+A",
                "mask.clear": "Ctrl+Shift+A",
                "mask.invert": "Ctrl+Shift+I",
                "mask.feather": "Shift+F6",
                "handles.select_all": "Ctrl+Alt+A",
                "view.overlay.mask": "Ctrl+H",
                "edit.history": "Ctrl+Shift+H",
                "view.fit": "2",
                "view.actual": "1",
                "view.panels": "Tab",
                "view.overlay.grid": "Ctrl+Shift+'",
            }
        ),
    }
)
"""By preset, the chords that are others than Weft's own."""
LABELS = (("weft", "Weft", ""), ("photoshop", "Photoshop", ""), ("krita", "Krita", ""))


def with_keys(actions: Iterable[Action], preset: str, own: Keys = ()) -> list[Action]:
    """Return the actions with the chords of a preset and then the artist's own.

    A chord that is given to an action leaves every other one that has it by itself.
    """
    given = {**PRESETS.get(preset, {}), **dict(own)}
    taken = {chord: name for name, chord in given.items() if chord}
    return [_with_key(action, given, taken) for action in actions]


def _with_key(action: Action, given: Mapping[str, str], taken: Mapping[str, str]) -> Action:
    """Return an action with the chord that it was given, or with those of its own that no other was given."""
    if action.name in given:
        return replace(action, chord=given[action.name], more_chords=())
    free = [chord for chord in (action.chord, *action.more_chords) if chord and chord not in taken]
    if free == [chord for chord in (action.chord, *action.more_chords) if chord]:
        return action
    return replace(action, chord=free[0] if free else "", more_chords=tuple(free[1:]))


def with_own(own: Keys, name: str, chord: str) -> Keys:
    """Return the artist's keys with one more, which leaves the action that had it."""
    kept = {action: key for action, key in own if action != name and (not chord or key != chord)}
    return tuple(sorted({**kept, name: chord}.items()))
