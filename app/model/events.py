"""What the pointer and the keyboard did, as plain data. Positions are screen pixels of the canvas widget."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

Button: TypeAlias = Literal["left", "middle", "right"]
Position: TypeAlias = tuple[float, float]


@dataclass(frozen=True)
class Modifiers:
    """Which modifier keys are held."""

    shift: bool = False
    ctrl: bool = False
    alt: bool = False


@dataclass(frozen=True)
class Press:
    """A button went down."""

    pos: Position
    button: Button = "left"
    mods: Modifiers = Modifiers()
    clicks: int = 1
    """2 for the second press of a double click."""


@dataclass(frozen=True)
class Move:
    """The pointer moved."""

    pos: Position
    mods: Modifiers = Modifiers()


@dataclass(frozen=True)
class Release:
    """The button went up."""

    pos: Position
    mods: Modifiers = Modifiers()


@dataclass(frozen=True)
class Wheel:
    """The wheel turned by `notches`, up and left positive."""

    pos: Position
    notches: float
    mods: Modifiers = Modifiers()


@dataclass(frozen=True)
class Key:
    """A key went down: "a", "delete", "left", "enter", "escape", "space", "[" ..."""

    name: str
    mods: Modifiers = Modifiers()
    repeated: bool = False


@dataclass(frozen=True)
class KeyUp:
    """A key went up."""

    name: str


@dataclass(frozen=True)
class Finish:
    """Whatever is in progress is to end now and keep what it did: something else is about to happen."""


Event: TypeAlias = Press | Move | Release | Wheel | Key | KeyUp | Finish
