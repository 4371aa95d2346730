"""Unsaved work is kept while the editor runs, and found after a crash; `rescues` says in which files."""

import threading
import time
import uuid
from pathlib import Path
from typing import TypedDict

from app.model.jobs import Jobs, Task
from app.state import rescues
from app.state.preferences import Preferences
from app.state.rescues import Drawer, Rescue, recovery_folder
from core.document.document import Document
from core.document.project import save_project
from core.files.faults import system_faults_named
from core.files.ownership import Claim, claim
from core.progress import Job, Progress, run


class Origin(TypedDict):
    """What a document is called, and where its project and its picture lie."""

    name: str
    project: Path | None
    source: Path | None


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
        self._drawer = Drawer(self.folder, uuid.uuid4().hex)
        self._claim: Claim | None = None
        self._writing = threading.Lock()
        """Held while the files are written: by a job, or at the end of the program."""

    @property
    def due_at(self) -> float | None:
        """When the clock must read at least for `update` to keep something; None while nothing waits."""
        return self._due_at

    def update(
        self,
        document: Document,
        *,
        saved: bool,
        name: str,
        project: Path | None,
        now: float,
        source: Path | None = None,
    ) -> None:
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
            steps = lambda: self._keeping(document, name, project, source)  # noqa: E731
            task = Task("Keep unsaved work", steps, self._succeed, self._try_again)
            self._jobs.submit("recovery", task, beside=True)

    def hurry(self) -> None:
        """Have the next `update` keep what is not kept yet: who knows how long the program goes on."""
        self._hurries = True

    def keep(self, document: Document, *, name: str, project: Path | None, source: Path | None = None) -> None:
        """Keep `document` at once, on this thread: the program is about to end without having asked.

        Raises `InputError` if it cannot be written.
        """
        self._jobs.drop("recovery")
        run(self._keeping(document, name, project, source))

    def _keeping(self, document: Document, name: str, project: Path | None, source: Path | None) -> Job[None]:
        """Write `document` and what belongs to it."""
        yield Progress(0.0)
        with self._writing:
            rescues.prepare(self.folder)
            self._own()
            self._drawer.age(time.time())
            save_project(document, self._drawer.project(), is_whole=False)
            rescues.write_note(self._drawer, name, project, source)
            rescues.write_picture(self._drawer, document)

    def _own(self) -> None:
        """Hold the lock of the files."""
        if self._claim is None:
            with system_faults_named(self._drawer.lock):
                self._claim = claim(self._drawer.lock)

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
        with self._writing:
            if self._claim is not None:
                self._drawer.remove()
                self._claim.release()
                self._claim = None
            self._drawer = Drawer(self.folder, uuid.uuid4().hex)

    def adopt(self, rescue: Rescue, document: Document) -> None:
        """Take over what was rescued as `document`, so that it stays until it is saved or given up.

        Where another editor has taken it meanwhile, the document is kept anew, as any other.
        """
        self.forget()
        try:
            taken = claim(rescue.drawer.lock)
            if taken is None:
                return
            rescue.drawer.bring_forward(rescue.generation)
        except OSError:
            return
        self._claim, self._drawer, self._kept = taken, rescue.drawer, document

    def found(self) -> list[Rescue]:
        """Return what other editors left behind when they ended without asking, the newest first."""
        return rescues.find(self.folder)
