"""What is held while the pointer acts: modifier keys by what they do with which tool, and as other programs have it.

A tool asks for the modifiers of its own, those that its gestures are written for. Which keys stand for them the artist
chooses: what is held is translated once, before a tool gets the event, and so are the words of its hints.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType

from app.model.events import Modifiers

PREFIX = "pointer."
"""What the names begin with, among those of actions whose keys were set."""
PAN = "pointer.pan"
"""The key that is held to move the view: no modifier."""
Keys = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class PointerKey:
    """Something that a modifier does with some tools."""

    name: str
    """For preferences: "pointer.brush.line"; what stands before the last point is its group."""
    own: str
    """The modifier that the tools ask for: "Shift"."""
    how: str
    """What the hand does with it: "-click"."""
    meaning: str
    tools: frozenset[str]

    @property
    def group(self) -> str:
        """Keys of one group differ from one another."""
        return self.name.rpartition(".")[0]


_OUTLINED = ("rectangle", "ellipse", "lasso", "polygon", "cling", "wand", "colour-range", "object", "region")
_POINTS = ("split", "resize", "outline", "pins", "curves", "feature-curves", "lattice")


def _key(name: str, own: str, how: str, meaning: str, *tools: str) -> PointerKey:
    return PointerKey(PREFIX + name, own, how, meaning, frozenset(tools))


POINTER_KEYS = (
    _key("select.add", "Shift", "-drag", "Add to what is selected", *_OUTLINED),
    _key("select.cut", "Alt", "-drag", "Cut out of it; both cross", *_OUTLINED),
    _key("select.square", "Ctrl", "-drag", "A square, a circle", "rectangle", "ellipse"),
    _key("brush.line", "Shift", "-click", "A straight line from the last stroke", "brush"),
    _key("brush.size", "Alt", "-drag", "Size and hardness of the brush", "brush"),
    _key("points.axis", "Shift", "", "Several; axis, steps, ratio", *_POINTS),
    _key("points.remove", "Alt", "-click", "Remove a point, break a knot", *_POINTS),
    _key("points.other", "Ctrl", "-drag", "Source, straight on, seam; never snaps", *_POINTS, "trace"),
    _key("zoom.out", "Alt", "-click", "Zoom out with the magnifier", "zoom"),
    _key("texture.turn", "Shift", "-drag", "Turn the texture on the cloth", "drape"),
    _key("texture.scale", "Ctrl", "-drag", "Scale the texture on the cloth", "drape"),
)
PRESETS: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "photoshop": MappingProxyType({}),
        "krita": MappingProxyType(
            {"pointer.brush.size": "Shift", "pointer.brush.line": "Alt", "pointer.zoom.out": "Ctrl"}
        ),
    }
)
"""By preset, what is other than Weft's own. Photoshop has the same modifiers."""
_WORD = re.compile(r"\b(Shift|Alt|Ctrl)\b(?!\+)")


@lru_cache(maxsize=4)
def assigned(preset: str, own: Keys) -> Mapping[str, str]:
    """Return what is held for each of `POINTER_KEYS`, and to move the view, by name; empty for nothing."""
    usual = {PAN: "Space", **{key.name: key.own for key in POINTER_KEYS}, **PRESETS.get(preset, {})}
    return MappingProxyType(usual | {name: chord for name, chord in own if name in usual})


def chord_of_modifiers(held: Modifiers) -> str:
    """Return what is held as it is written: "Ctrl+Shift"."""
    return "+".join(name for name, on in (("Ctrl", held.ctrl), ("Alt", held.alt), ("Shift", held.shift)) if on)


def translate(held: Modifiers, tool: str, chords: Mapping[str, str]) -> Modifiers:
    """Return the modifiers that a tool asks for where these are held and stand for what `chords` say."""
    down, said = set(chord_of_modifiers(held).split("+")), [key for key in POINTER_KEYS if tool in key.tools]
    found = held
    for own in {key.own for key in said}:
        chosen = [chords[key.name] for key in said if key.own == own]
        found = replace(found, **{own.lower(): any(chord and set(chord.split("+")) <= down for chord in chosen)})
    return found


def word(hint: str, tool: str, chords: Mapping[str, str]) -> str:
    """Return the hint of a tool with the modifiers that are to be held."""
    by_own = {key.own: chords[key.name] or "–" for key in POINTER_KEYS if tool in key.tools}
    return _WORD.sub(lambda found: by_own.get(found[1], found[1]), hint)


def with_own_pointer(own: Keys, preset: str, name: str, chord: str) -> Keys:
    """Return the artist's keys with another one for the pointer; one of its group that had it gets the one before."""
    before, group = assigned(preset, own), name.rpartition(".")[0]
    given = {name: chord}
    for key in POINTER_KEYS:
        if chord and key.group == group and key.name != name and before[key.name] == chord:
            given[key.name] = before[name]
    return tuple(sorted({**dict(own), **given}.items()))
