"""Unsaved work, kept in the user's state folder while the editor runs, and found there after a crash.

Every running editor owns one project file and, beside it, a note of what it is called and which process writes it.
Both go when the work is saved or given up. What belongs to no living process is offered at the next start.
"""

import contextlib
import json
import os
from dataclasses import dataclass
from pathlib import Path

import platformdirs

from app.jobs import Jobs, Task
from app.preferences import Preferences
from core.arrays import InputError
from core.document import Document
from core.files import write_text
from core.progress import Job, Progress, run
from core.project import SUFFIX, save_project


def recovery_folder() -> Path:
    """Return the folder of the user's unsaved work."""
    return Path(platformdirs.user_state_path("weft")) / "recovery"


@dataclass(frozen=True)
class Rescue:
    """Work that an editor left behind."""

    file: Path
    name: str
    """What it was called."""
    project: Path | None
    """Where it was saved before."""


class Recovery:
    """Keeps the present document of one editor."""

    def __init__(self, jobs: Jobs, *, folder: Path | None = None, every_s: float = Preferences().keep_every_s) -> None:
        self.folder = folder or recovery_folder()
        self._jobs = jobs
        self.every_s = every_s
        """Changes are kept at most so much later."""
        self.fault: str | None = None
        """Why the last try to keep unsaved work failed; None once one succeeds, or nothing is to be kept."""
        self._kept: Document | None = None
        self._due_at: float | None = None
        self._hurries = False
        self._file = self.folder / f"{os.getpid()}-{id(self):x}{SUFFIX}"

    @property
    def due_at(self) -> float | None:
        """When the clock must read at least for `update` to keep something; None while nothing waits."""
        return self._due_at

    def update(self, document: Document, *, saved: bool, name: str, project: Path | None, now: float) -> None:
        """Keep `document` from time to time while it is not saved; forget it when it is."""
        if saved or document is self._kept:
            self._due_at = None
            if saved and (self._kept is not None or self.fault is not None):
                self.forget()
            return
        if self._due_at is None:
            self._due_at = now + self.every_s
        if (self._hurries or now >= self._due_at) and not self._jobs.holds("recovery"):
            self._due_at, self._kept, self._hurries = None, document, False
            steps = lambda: _keep(document, self._file, name, project)  # noqa: E731
            task = Task("Keep unsaved work", steps, self._succeed, self._try_again)
            self._jobs.submit("recovery", task, beside=True)

    def hurry(self) -> None:
        """Have the next `update` keep what is not kept yet: who knows how long the program goes on."""
        self._hurries = True

    def keep(self, document: Document, *, name: str, project: Path | None) -> None:
        """Keep `document` at once, on this thread: the program is about to end without having asked.

        Raises `InputError` if it cannot be written.
        """
        self._jobs.drop("recovery")
        run(_keep(document, self._file, name, project))

    def _succeed(self, _: None) -> None:
        """Take back what was said of a fault."""
        self.fault = None

    def _try_again(self, fault: Exception) -> None:
        """Let the next `update` keep what could not be written now, such as on a full disk; say so meanwhile."""
        self._kept = None
        self.fault = str(fault) or type(fault).__name__

    def forget(self) -> None:
        """Remove what was kept: it is saved, or given up."""
        self._jobs.drop("recovery")
        self._kept = self._due_at = self.fault = None
        discard(Rescue(self._file, "", None))

    def adopt(self, rescue: Rescue, document: Document) -> None:
        """Take over what was rescued as `document`, so that it stays until it is saved or given up."""
        with contextlib.suppress(OSError, InputError):
            rescue.file.replace(self._file)
            _note(self._file, rescue.name, rescue.project)
            self._kept = document
        discard(rescue)

    def found(self) -> list[Rescue]:
        """Return what other editors left behind when they ended without asking, the newest first."""
        rescues = []
        for note in sorted(self.folder.glob("*.json"), key=lambda file: file.stat().st_mtime, reverse=True):
            file = note.with_suffix(SUFFIX)
            with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
                data = json.loads(note.read_text(encoding="utf-8"))
                if file.exists() and not _is_alive(int(data["process"])):
                    project = None if data["project"] is None else Path(data["project"])
                    rescues.append(Rescue(file, str(data["name"]), project))
        return rescues


def discard(rescue: Rescue) -> None:
    """Remove the files of a rescue."""
    for file in (rescue.file, rescue.file.with_suffix(".json")):
        with contextlib.suppress(OSError):
            file.unlink(missing_ok=True)


def _keep(document: Document, file: Path, name: str, project: Path | None) -> Job[None]:
    """Write `document` and the note beside it."""
    yield Progress(0.0)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise InputError(f"{file.parent}: {fault.strerror}") from fault
    save_project(document, file)
    _note(file, name, project)


def _note(file: Path, name: str, project: Path | None) -> None:
    """Write beside `file` what it is and that this process owns it."""
    data = {"process": os.getpid(), "name": name, "project": None if project is None else str(project)}
    write_text(file.with_suffix(".json"), json.dumps(data))


def _is_alive(process: int) -> bool:
    """Return whether another process of this number runs; where that cannot be told, that none does."""
    if process == os.getpid():
        return True
    if os.name != "posix":
        return False
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
