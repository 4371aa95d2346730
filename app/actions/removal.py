"""Actions that take a part of the document back to nothing."""

from collections.abc import Mapping

from app.actions import Action
from app.editor.editor import Editor
from core.document.document import Mode


def removal(
    name: str,
    label: str,
    menu: str,
    mode: Mode,
    icon: str,
    tooltip: str,
    emptied: Mapping[str, object],
    *,
    separated: bool = False,
) -> Action:
    """Return an action of `mode` that gives parts of the document the values in `emptied`, if one holds something."""

    def holds_something(editor: Editor) -> bool:
        return editor.session.mode == mode and any(getattr(editor.document, part) for part in emptied)

    return Action(
        name,
        label,
        menu,
        lambda editor: editor.edit(label, editor.document.changed(**emptied)),
        icon=icon,
        tooltip=tooltip,
        enabled=holds_something,
        separated=separated,
    )
