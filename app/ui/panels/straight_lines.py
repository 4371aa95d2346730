"""The switch that keeps straight lines straight, on both pages of the Warp panel."""

from app.editor.editor import Editor
from app.ui.widgets.controls import check

HINT = "Horizons, walls and other long lines of the picture stay straight beside features, as far as these leave room"


def draw_straight(editor: Editor) -> None:
    """Draw the switch."""
    switched = check("Straight lines", editor.document.warp.straight, HINT)
    if switched is not None:
        editor.edit("Straight lines", editor.document.with_warp(straight=switched))
