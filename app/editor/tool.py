"""What the pointer does on the canvas, as a record.

A tool's gesture is a generator that owns its state in local variables: a press creates it, every later event is sent
to it, and it ends by returning. Escape closes it, and the `with editor.group("Move pin")` inside rolls back. A gesture
recomputes from the document it started with; it never adds up what moves brought.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from app.model.events import Key, Position, Press
from app.model.gestures import Gesture
from app.model.shapes import Shape
from core.document.document import Mode

if TYPE_CHECKING:
    from app.editor.editor import Editor


def _no_hover(editor: "Editor", pos: Position) -> object:
    """Find nothing."""
    return None


def _always(editor: "Editor") -> bool:
    """Return True."""
    return True


def _no_more(editor: "Editor") -> str:
    """Say nothing beyond the hint."""
    return ""


def _no_key(editor: "Editor", key: Key) -> bool:
    """Take no key."""
    return False


def _no_shapes(editor: "Editor") -> Sequence[Shape]:
    """Draw nothing."""
    return ()


@dataclass(frozen=True)
class Tool:
    """What the pointer does on the canvas."""

    name: str
    label: str
    icon: str
    """Name of a Font Awesome 6 icon, without its prefix: "paintbrush"."""
    key: str
    hint: str
    """What can be done with it, for the status bar."""
    press: Callable[["Editor", Press], Gesture | None]
    modes: frozenset[Mode] = frozenset(("warp", "retexture", "overlay"))
    cursor: Literal["arrow", "cross", "hand", "none", "move"] = "cross"
    hover: Callable[["Editor", Position], object] = _no_hover
    """What lies under a screen position, kept in `Session.hover`."""
    take_key: Callable[["Editor", Key], bool] = _no_key
    """Act on a key and say so, before the action table sees it."""
    moment: Callable[["Editor"], str] = _no_more
    """What can be done just now, where that is something else than the hint says."""
    on_original: bool = False
    """Whether it works on Retexture mode's picture as it was, which is shown when the tool is chosen."""
    marks: bool = False
    """Whether it paints or selects parts of the picture: Warp mode then shows the picture as it was."""
    can_act: Callable[["Editor"], bool] = _always
    """Whether there is something that it can be used on."""
    group: str = ""
    """Tools of one group share a button, which takes the one of them that was in hand last."""
    overlay: Callable[["Editor"], Sequence[Shape]] = _no_shapes
    """What is drawn over the picture while the tool is in hand, in screen pixels, the lowest first."""


def first_tool(tools: Mapping[str, Tool], mode: Mode) -> str:
    """Return the name of the first tool that no other mode has, or of the first that `mode` has."""
    fitting = [tool for tool in tools.values() if mode in tool.modes]
    return min(fitting, key=lambda tool: len(tool.modes)).name
