"""The switch that keeps straight lines straight, on both pages of the Warp panel."""

from app.editor.editor import Editor
from app.ui.widgets.controls import check

HINT = (
    "Horizons, walls and other long lines stay straight beside features and under handles, as far as these leave room"
)


def draw_straight(editor: Editor) -> None:
    """Draw the switch."""
    switched = check("Straight lines", editor.document.warp.straight, HINT)
    if switched is not None:
        editor.edit("Straight lines", editor.document.with_warp(straight=switched))
