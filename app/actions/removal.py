"""Actions that take a part of the document back to nothing."""

from collections.abc import Mapping
from typing import Any

from app.actions import Action, ActionGroup
from app.editor.editor import Editor


def removal(
    group: ActionGroup, name: str, label: str, icon: str, tooltip: str, emptied: Mapping[str, Any], **more: Any
) -> Action:
    """Return an action that gives parts of the document the values in `emptied`, if one holds something."""

    def holds_something(editor: Editor) -> bool:
        return group.enabled(editor) and any(getattr(editor.document, part) for part in emptied)

    def remove(editor: Editor) -> None:
        editor.edit(label, editor.document.changed(**emptied))

    return group.action(name, label, remove, icon, tooltip, enabled=holds_something, **more)
