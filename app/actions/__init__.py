"""Everything the artist can do by menu, key, toolbar or palette, as records; `app.actions.table` lists them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from app.editor.editor import Editor
from app.model.events import Key
from app.model.requests import Panel, ShowPanel


def always(editor: Editor) -> bool:
    """Return True."""
    return True


def in_warp(editor: Editor) -> bool:
    """Return whether the editor is in Warp mode."""
    return editor.session.mode == "warp"


@dataclass(frozen=True, eq=False)
class Action:
    """Something the artist can ask for."""

    name: str
    """For programs and tests: "file.open"."""
    label: str
    """For people: "Open…"."""
    menu: str
    """Where it stands in the menus, "/" between levels: "View/Overlays"."""
    run: Callable[[Editor], None]
    chord: str = ""
    """Its key, "Ctrl+Shift+Z", or empty."""
    icon: str = ""
    """Name of a Font Awesome 6 icon, without its prefix, or empty."""
    tooltip: str = ""
    enabled: Callable[[Editor], bool] = always
    checked: Callable[[Editor], bool] | None = None
    """Whether it is switched on; None for what is no switch."""
    release: Callable[[Editor], None] | None = None
    """What happens when its key is let go, for actions that last as long as the key is held."""
    more_chords: tuple[str, ...] = ()
    """Further keys that do the same."""
    separated: bool = False
    """Whether a line stands before it in its menu."""

    def try_run(self, editor: Editor) -> bool:
        """Run it if it is enabled; say whether it was."""
        if not self.enabled(editor):
            return False
        self.run(editor)
        return True


@dataclass(frozen=True)
class ActionGroup:
    """What the actions have in common that stand together in a menu."""

    name: str
    """What their names begin with: "file"."""
    menu: str
    enabled: Callable[[Editor], bool] = always
    """Of those that do not say when they are."""

    def action(
        self,
        name: str,
        label: str,
        run: Callable[[Editor], None],
        icon: str = "",
        tooltip: str = "",
        chord: str = "",
        **more: Any,
    ) -> Action:
        """Return one of them; `more` are further parts of `Action`."""
        parts = {"enabled": self.enabled, **more}
        return Action(f"{self.name}.{name}", label, self.menu, run, chord, icon, tooltip, **parts)

    def choice(
        self,
        value: str,
        label: str,
        choose: Callable[[Editor, Any], None],
        present: Callable[[Editor], object],
        *shown: str,
    ) -> Action:
        """Return one that chooses a value, on while that is the present one; `shown` are icon, tooltip and chord."""

        def is_present(editor: Editor) -> bool:
            return present(editor) == value

        return self.action(value, label, lambda editor: choose(editor, value), *shown, checked=is_present)

    def switch(self, name: str, label: str, part: str, icon: str, tooltip: str, chord: str = "", **more: Any) -> Action:
        """Return one that switches a part of the session on and off."""

        def is_on(editor: Editor) -> bool:
            return bool(getattr(editor.session, part))

        def toggle(editor: Editor) -> None:
            editor.show(**{part: not is_on(editor)})

        return self.action(name, label, toggle, icon, tooltip, chord, checked=is_on, **more)

    def removal(
        self, name: str, label: str, icon: str, tooltip: str, emptied: Mapping[str, Any], **more: Any
    ) -> Action:
        """Return one that gives parts of the document the values in `emptied`, if one of them holds something."""

        def holds_something(editor: Editor) -> bool:
            return self.enabled(editor) and any(getattr(editor.document, part) for part in emptied)

        def remove(editor: Editor) -> None:
            editor.edit(label, editor.document.changed(**emptied))

        return self.action(name, label, remove, icon, tooltip, enabled=holds_something, **more)


def make_toggle(panel: Panel) -> Callable[[Editor], None]:
    """Return what an action does that shows one of the window's own panels."""
    return lambda editor: editor.requests.append(ShowPanel(panel))


def chord_of(key: Key) -> str:
    """Return the chord of a key with its modifiers, as actions name it: "Ctrl+Shift+Z"."""
    held = [name for name, on in (("Ctrl", key.mods.ctrl), ("Alt", key.mods.alt), ("Shift", key.mods.shift)) if on]
    name = key.name.upper() if len(key.name) == 1 or key.name[1:].isdigit() else key.name.capitalize()
    return "+".join([*held, name])
