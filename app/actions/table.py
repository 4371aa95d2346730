"""The one table of actions, which feeds menus, toolbar, keys, palette and tests."""

from collections.abc import Mapping
from dataclasses import replace

from app.actions import Action, ActionGroup, chord_of
from app.actions.edit import EDIT, HELP
from app.actions.feature_curves import FEATURE_CURVES
from app.actions.file import FILE
from app.actions.handles import HANDLES
from app.actions.keys import Keys, with_keys
from app.actions.overlay import OVERLAY
from app.actions.retexture import RETEXTURE
from app.actions.selecting import SELECTING
from app.actions.surfaces import SURFACES
from app.actions.timeline import TIMELINE
from app.actions.view import MODES, VIEW
from app.actions.warp import MASK, WARP
from app.editor.editor import Editor
from app.editor.tool import Tool
from app.model.events import Key
from app.model.pointer_keys import assigned, word

_TOOLS = ActionGroup("tool", "Tools")


class ActionTable:
    """All actions of an editor with given tools, in menu order."""

    def __init__(self, tools: Mapping[str, Tool]) -> None:
        tool_actions = tuple(_tool(tool) for tool in tools.values())
        self._plain = (
            *(*FILE, *EDIT, *VIEW, *MASK, *SELECTING, *WARP, *SURFACES, *HANDLES),
            *(*FEATURE_CURVES, *RETEXTURE, *OVERLAY, *TIMELINE, *tool_actions, *MODES, *HELP),
        )
        self.actions: list[Action] = []
        self.by_name: dict[str, Action] = {}
        self._by_chord: dict[str, list[Action]] = {}
        self._held: dict[str, Action] = {}
        self.set_keys("weft")

    def set_keys(self, preset: str, own: Keys = ()) -> None:
        """Give the actions the chords of a preset, and then the artist's own."""
        chords = assigned(preset, own)
        self.actions[:] = [_worded(action, chords) for action in with_keys(self._plain, preset, own)]
        self.by_name.clear()
        self.by_name.update((action.name, action) for action in self.actions)
        self._by_chord.clear()
        for action in self.actions:
            for chord in (action.chord, *action.more_chords):
                if chord:
                    self._by_chord.setdefault(chord, []).append(action)

    def chord_of_tool(self, name: str) -> str:
        """Return the key that takes a tool; empty for none."""
        return self.by_name[f"tool.{name}"].chord

    def run(self, name: str, editor: Editor) -> bool:
        """Run the action called `name` if it is enabled; say whether it was."""
        return self.by_name[name].try_run(editor)

    def for_key(self, key: Key, editor: Editor) -> Action | None:
        """Return the action on `key`; of tools that share it, the one of the present mode."""
        found = self._by_chord.get(chord_of(key), [])
        return next((action for action in found if action.enabled(editor)), None)

    def press(self, key: Key, editor: Editor) -> bool:
        """Run what is on `key`; say whether there was something. Call it with keys that the editor did not take."""
        action = self.for_key(key, editor)
        if action is None:
            return False
        if action.release is not None:
            self._held[key.name] = action
        if not (key.repeated and action.checked is not None):
            action.run(editor)
        return True

    def release(self, name: str, editor: Editor) -> bool:
        """End what lasts as long as the key called `name` is held; say whether there was something."""
        action = self._held.pop(name, None)
        if action is None or action.release is None:
            return False
        action.release(editor)
        return True


def _worded(action: Action, chords: Mapping[str, str]) -> Action:
    """Return an action whose tooltip names the modifiers that are to be held, where it takes a tool."""
    group, _, tool = action.name.partition(".")
    return replace(action, tooltip=word(action.tooltip, tool, chords)) if group == _TOOLS.name else action


def _tool(tool: Tool) -> Action:
    """Return the action that takes `tool`."""
    return _TOOLS.action(
        tool.name,
        tool.label,
        lambda editor: editor.choose_tool(tool.name),
        tool.icon,
        tool.hint,
        tool.key.upper(),
        enabled=lambda editor: editor.session.mode in tool.modes and tool.can_act(editor),
        checked=lambda editor: editor.session.tool == tool.name,
    )
