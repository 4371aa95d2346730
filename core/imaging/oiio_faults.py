"""What OpenImageIO says is wrong, as text: it quotes the file, which may hold anything."""

from typing import Protocol

LOST = "damaged (what is wrong with it is not text)"


class Speaker(Protocol):
    """OpenImageIO itself, or one of its files."""

    def geterror(self) -> str:
        """Return what went wrong and forget it."""


def take_fault(speaker: Speaker) -> str:
    """Return what went wrong, empty if nothing did."""
    try:
        return speaker.geterror()
    except UnicodeDecodeError:
        return LOST
