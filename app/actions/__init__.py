"""Everything the artist can do by menu, key, toolbar or palette, as records; `app.actions.table` lists them."""

from collections.abc import Callable
from dataclasses import dataclass

from app.editor.editor import Editor
from app.model.events import Key


def _always(editor: Editor) -> bool:
    """Return True."""
    return True


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
    enabled: Callable[[Editor], bool] = _always
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


def chord_of(key: Key) -> str:
    """Return the chord of a key with its modifiers, as actions name it: "Ctrl+Shift+Z"."""
    held = [name for name, on in (("Ctrl", key.mods.ctrl), ("Alt", key.mods.alt), ("Shift", key.mods.shift)) if on]
    name = key.name.upper() if len(key.name) == 1 or key.name[1:].isdigit() else key.name.capitalize()
    return "+".join([*held, name])
