"""A bar of parts; those that find no room in it stand in a menu at its end."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from imgui_bundle import ImVec2, imgui

from app.ui.widgets.controls import end_popup, icon_button
from app.ui.widgets.theme import em

BUTTON_EM = 1.9
"""Side of the button that opens the menu."""


@dataclass(frozen=True)
class BarPart:
    """Something that stands in a bar."""

    extent: float
    """How much of the bar it takes with the room after it, in screen pixels."""
    draw: Callable[[], None]
    """Draws it in the bar; the next part begins where its extent ends."""
    draw_row: Callable[[], None] | None = None
    """Draws it in the menu; None for what only holds others apart."""


def extent(parts: Sequence[BarPart]) -> float:
    """Return how much of a bar the parts take together, in screen pixels."""
    return sum(part.extent for part in parts)


def count_fitting(parts: Sequence[BarPart], room: float) -> int:
    """Return how many parts, from the first on, a bar holds: all, or those that leave room for the menu's button."""
    if extent(parts) <= room:
        return len(parts)
    left, count = room - em(BUTTON_EM), 0
    for part in parts:
        left -= part.extent
        if left < 0:
            break
        count += 1
    return count


def draw_parts(parts: Sequence[BarPart], x: float, y: float, *, down: bool = False) -> None:
    """Draw parts in a row, or a column, that begins at (x, y) in the window."""
    for part in parts:
        imgui.set_cursor_pos(ImVec2(x, y))
        part.draw()
        x, y = (x, y + part.extent) if down else (x + part.extent, y)
    imgui.dummy(ImVec2(0, 0))


def draw_menu(name: str, parts: Sequence[BarPart], x: float, y: float) -> None:
    """Draw the button that opens a menu of the parts a bar has no room for, at (x, y) in the window."""
    imgui.set_cursor_pos(ImVec2(x, y))
    if icon_button(name, "ellipsis", quiet=True, hint=name, size_em=BUTTON_EM):
        imgui.open_popup(f"##{name}")
    if not imgui.begin_popup(f"##{name}"):
        return
    after_rows = False
    for number, part in enumerate(parts):
        if part.draw_row is not None:
            part.draw_row()
            after_rows = True
        elif after_rows and any(other.draw_row for other in parts[number:]):
            imgui.separator()
            after_rows = False
    end_popup()
