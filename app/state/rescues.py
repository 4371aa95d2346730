"""Files of unsaved work in the user's state folder: what is kept there, who owns it, and what was left behind.

Every running editor owns one set of files there, called by a key of its own: the project and a few earlier generations
of it, a note of what it is called and where it came from, a small picture, and a lock that dies with the editor. What
nobody holds the lock of was left behind, with a note or without.
"""

import contextlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import platformdirs

from core.arrays import InputError
from core.document.document import Document
from core.document.project import SUFFIX
from core.files.atomic import write_text
from core.files.faults import system_faults_named
from core.files.json_file import read_json
from core.files.ownership import claim, is_claimed
from core.imaging.images import Image, save
from core.imaging.proxy import proxy, scale_for

GENERATIONS = 3
"""So many states of a document are kept, the newest included."""
GENERATION_S = 300.0
"""A state becomes an earlier generation when the one before it is so old."""
PICTURE_PIXELS = 160 * 110
"""Pixels of the small picture, about."""


def recovery_folder() -> Path:
    """Return the folder of the user's unsaved work."""
    return Path(platformdirs.user_state_path("weft")) / "recovery"


@dataclass(frozen=True)
class Drawer:
    """The files of one document."""

    folder: Path
    key: str
    """What their names begin with; it has no dots."""

    def project(self, generation: int = 0) -> Path:
        """Return the project's file; 0 is the newest generation."""
        return self.folder / (f"{self.key}.{generation}{SUFFIX}" if generation else f"{self.key}{SUFFIX}")

    @property
    def note(self) -> Path:
        """What the document is called."""
        return self.folder / f"{self.key}.json"

    @property
    def picture(self) -> Path:
        """A small picture of it."""
        return self.folder / f"{self.key}.png"

    @property
    def lock(self) -> Path:
        """Who holds this owns the files."""
        return self.folder / f"{self.key}.lock"

    def age(self, now: float) -> None:
        """Make the newest state an earlier generation, if the one before it is old enough at `now`."""
        newest, before = self.project(), self.project(1)
        if not newest.exists() or (before.exists() and now - before.stat().st_mtime < GENERATION_S):
            return
        for generation in range(GENERATIONS - 1, 0, -1):
            if self.project(generation - 1).exists():
                self.project(generation - 1).replace(self.project(generation))

    def bring_forward(self, generation: int) -> None:
        """Make an earlier generation the newest one; the others stay behind it."""
        if generation == 0:
            return
        aside = self.folder / f"{self.key}.aside"
        self.project(generation).replace(aside)
        for number in range(generation, 0, -1):
            self.project(number - 1).replace(self.project(number))
        aside.replace(self.project())

    def remove(self) -> None:
        """Remove the files, the lock last."""
        projects = (self.project(generation) for generation in range(GENERATIONS))
        for file in (*projects, self.note, self.picture, self.lock):
            with contextlib.suppress(OSError):
                file.unlink(missing_ok=True)


@dataclass(frozen=True)
class Rescue:
    """A state of work that an editor left behind."""

    drawer: Drawer
    generation: int
    """0 for the newest state of its document."""
    name: str
    """What the document was called."""
    project: Path | None
    """Where it was saved before."""
    source: Path | None
    """The picture that it was begun with."""
    kept_at: float
    """When it was kept, in seconds of the system's clock."""

    @property
    def file(self) -> Path:
        """The project."""
        return self.drawer.project(self.generation)


def prepare(folder: Path) -> None:
    """Make the folder of unsaved work, which only its owner can read; raise `InputError` where that cannot be done."""
    with system_faults_named(folder):
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        folder.chmod(0o700)


def write_note(drawer: Drawer, name: str, project: Path | None, source: Path | None) -> None:
    """Write what the document is called."""
    paths = {"project": project, "source": source}
    write_text(drawer.note, json.dumps({"name": name} | {key: path and str(path) for key, path in paths.items()}))


def write_picture(drawer: Drawer, document: Document) -> None:
    """Write the small picture, if it is not there yet."""
    if not drawer.picture.exists():
        image = document.image
        save(Image(proxy(image, scale_for(image, PICTURE_PIXELS))), drawer.picture)


def find(folder: Path) -> list[Rescue]:
    """Return what was left behind in `folder`, the newest first."""
    rescues = []
    try:
        keys = {file.name.split(".")[0] for file in folder.glob(f"*{SUFFIX}") if not file.name.startswith(".")}
    except OSError:
        return []
    for drawer in (Drawer(folder, key) for key in keys):
        if not is_claimed(drawer.lock):
            rescues.extend(_generations(drawer))
    return sorted(rescues, key=lambda rescue: -rescue.kept_at)


def _generations(drawer: Drawer) -> list[Rescue]:
    """Return what a drawer holds."""
    try:
        note = read_json(drawer.note)
    except InputError:
        note = None
    said: dict[str, Any] = note if isinstance(note, dict) else {}
    name = said.get("name") if isinstance(said.get("name"), str) else "Unsaved work"
    paths = {key: Path(said[key]) if isinstance(said.get(key), str) else None for key in ("project", "source")}
    rescues = []
    for generation in range(GENERATIONS):
        with contextlib.suppress(OSError):  # it may be gone since the folder was listed
            kept_at = drawer.project(generation).stat().st_mtime
            rescues.append(Rescue(drawer, generation, str(name), paths["project"], paths["source"], kept_at))
    return rescues


def discard(drawer: Drawer) -> None:
    """Remove what was left behind, unless somebody has taken it meanwhile."""
    try:
        held = claim(drawer.lock)
    except OSError:
        return
    if held is not None:
        drawer.remove()
        held.release()
