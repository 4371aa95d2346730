"""What shows one of the window's own panels."""

from collections.abc import Callable

from app.editor.editor import Editor
from app.model.requests import Panel, ShowPanel


def make_toggle(panel: Panel) -> Callable[[Editor], None]:
    """Return what an action does that shows a panel."""
    return lambda editor: editor.requests.append(ShowPanel(panel))
