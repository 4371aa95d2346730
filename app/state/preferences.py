"""What the artist prefers from run to run, kept in the user's settings folder."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from types import MappingProxyType

import platformdirs

from app.model.pointer_keys import assigned
from app.state.state_files import read_state
from core.files.atomic import write_text
from core.files.faults import make_folder

LIMITS = MappingProxyType(
    {
        "undo_mb": (64.0, 16384.0),
        "scale": (0.5, 3.0),
        "keep_every_s": (2.0, 600.0),
        "mask_color": (0, 0xFFFFFF),
        "mask_opacity": (0.05, 1.0),
    }
)
"""Least and most of each number."""


@dataclass(frozen=True)
class Preferences:
    """Settings of the program rather than of a picture."""

    undo_mb: float = 512.0
    """Memory for what can be undone, in mebibytes."""
    scale: float = 1.0
    """Size of text and controls, over that which the display asks for."""
    keep_every_s: float = 5.0
    """Unsaved work is kept at most so much later."""
    backups: bool = True
    """Whether a save keeps the version before beside the project, as `name~`."""
    drafts: bool = True
    """Whether the picture is drawn faster, at less quality, while something moves."""
    solver: str = "auto"
    """What answers on large grids while something moves: "gpu", "processor", or what is likely the faster of both."""
    mask_color: int = 0xF53B57
    """Of what is painted, as 0xRRGGBB."""
    mask_opacity: float = 0.4
    feature_colors: bool = True
    """Whether each feature is shown in a colour of its own instead."""
    key_preset: str = "weft"
    """Whose keys are used."""
    keys: tuple[tuple[str, str], ...] = ()
    """Keys that the artist has set: names of actions and their chords."""

    @property
    def pointer_keys(self) -> Mapping[str, str]:
        """What is held for what the pointer does, by the names of `app.model.pointer_keys`."""
        return assigned(self.key_preset, self.keys)

    @property
    def undo_bytes(self) -> int:
        """How many bytes of memory what can be undone may take."""
        return int(self.undo_mb * 2**20)

    def changed(self, **changes: object) -> "Preferences":
        """Return the preferences with some changed; numbers are taken into their limits."""
        limited = {
            name: min(max(value, LIMITS[name][0]), LIMITS[name][1])
            if name in LIMITS and isinstance(value, int | float)
            else value
            for name, value in changes.items()
        }
        return replace(self, **limited)  # type: ignore[arg-type]


def preferences_file() -> Path:
    """Return the file of the user's preferences."""
    return Path(platformdirs.user_config_path("weft")) / "preferences.json"


def load_preferences(file: Path) -> Preferences:
    """Return what `file` says; the default in place of everything that is missing or makes no sense."""
    known = asdict(Preferences())
    said = read_state(file, dict) or {}
    said["keys"] = _pairs(said.get("keys"))
    return Preferences().changed(**{name: said[name] for name in known if _fits(said.get(name), known[name])})


def save_preferences(file: Path, preferences: Preferences) -> None:
    """Write `preferences` to `file`, whole or not at all; raise `InputError` where that cannot be done."""
    make_folder(file.parent)
    write_text(file, json.dumps(asdict(preferences), indent=1) + "\n")


def _fits(value: object, default: object) -> bool:
    """Return whether a value is of the default's kind: a switch, or a number that is one."""
    if isinstance(default, bool) or isinstance(value, bool):
        return isinstance(default, bool) and isinstance(value, bool)
    if isinstance(default, str | tuple):
        return isinstance(value, type(default))
    if isinstance(default, int):
        return isinstance(value, int)
    return isinstance(value, int | float) and value == value


def _pairs(data: object) -> tuple[tuple[str, str], ...]:
    """Return the pairs of texts in a list that was read, and nothing else of it."""
    rows = data if isinstance(data, list) else []
    return tuple(
        (row[0], row[1]) for row in rows if isinstance(row, list) and [type(part) for part in row] == [str, str]
    )
