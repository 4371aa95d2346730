"""The editor: a document with its history, a session, and what is in progress. It knows no GL and no ImGui."""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

from app.editor.animation import Animation
from app.editor.errands import Errands
from app.editor.interaction import Interaction
from app.editor.tool import Tool, first_tool
from app.editor.unwarped import Unwarped
from app.live.answer import Answer
from app.live.gpu_frames import MakeSolver
from app.live.overlay import LiveOverlay
from app.live.retexture import LiveRetexture
from app.live.warp import LiveWarp
from app.model.events import Event
from app.model.history import History
from app.model.jobs import Jobs
from app.model.requests import ExportOptions, Request
from app.model.session import Brush, Session
from app.state.preferences import Preferences, save_preferences
from app.state.project_file import OnDisk
from app.state.recovery import Origin, Recovery
from core import tracing
from core.arrays import WeftError
from core.document.document import Document, Mode
from core.document.retexture import moves
from core.files.text import legible
from core.progress import Job

Exporter: TypeAlias = Callable[[Document, ExportOptions], Job[None]]


class Editor(Errands):
    """Everything the window shows; events and actions go in, the document and the session come out."""

    def __init__(
        self,
        document: Document,
        tools: Mapping[str, Tool],
        *,
        jobs: Jobs | None = None,
        recovery: Recovery | None = None,
        exporter: Exporter | None = None,
        grid_solver: Callable[[str], MakeSolver | None] = lambda preferred: None,
        preferences: Preferences | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__(jobs or Jobs())
        self.preferences = preferences or Preferences()
        self.preferences_file: Path | None = None
        """Where the preferences are kept from run to run; None keeps them nowhere."""
        self.history = self._history(document)
        self.session = Session(brush=Brush.of(document.size_px))
        self.tools = tools
        self.recovery = recovery
        """Keeps unsaved work; None keeps nothing."""
        self.exporter = exporter
        """Writes a document's picture; None where nothing can draw it."""
        self.clock = clock
        self.live = LiveWarp(self.jobs, clock=clock, gpu=lambda: grid_solver(self.preferences.solver))
        self.regrowth = LiveRetexture(self.jobs)
        self.overlay = LiveOverlay(self.jobs)
        self.project_path: Path | None = None
        """Where the project is saved; None while it is not."""
        self.on_disk = OnDisk()
        """The projects' files as this editor has seen them last."""
        self.source_path: Path | None = None
        """The picture that was opened."""
        self.recent_file: Path | None = None
        """Where `Session.recent` is kept from run to run; None keeps it nowhere."""
        self.is_closing = False
        """Whether the artist has asked to leave and nothing stands against it."""
        self.requests: list[Request] = []
        """What the window is to ask the artist, the oldest first; whoever shows one takes it out."""
        self._hand = Interaction(self, tools)
        self.unwarped = Unwarped(self)
        """Shows Warp mode's picture as it was, to paint on."""
        self._tools_left: dict[Mode, str] = {}
        """By mode, the tool in hand when it was left."""
        self.animation = Animation(self)
        self.choose_mode(document.mode)

    @property
    def document(self) -> Document:
        """The present document as it is at the present frame; set it inside a group only."""
        return self.animation.show(self.history.document)

    @document.setter
    def document(self, document: Document) -> None:
        self.history.document = self.animation.take(document)

    @property
    def tool(self) -> Tool:
        """The tool in hand: the spring-loaded one while its key is held, else the chosen one."""
        return self._hand.tool

    @property
    def name(self) -> str:
        """What the document is called in the title."""
        path = self.project_path or self.source_path
        return legible(path.name) if path is not None else "Untitled"

    @property
    def answer(self) -> Answer:
        """The map on the screen."""
        if self.session.mode == "retexture":
            return self.regrowth.answer(self.document)
        if self.session.mode == "overlay":
            return self.overlay.answer(self.document)
        return self.unwarped.answer() if self.unwarped.is_shown else self.map

    @property
    def map(self) -> Answer:
        """Warp mode's map, whether it is on the screen or not."""
        return self.live.current(self.document)

    @property
    def fault(self) -> str | None:
        """Why the present document has no answer of its own."""
        by_mode = {"warp": self.live.fault, "retexture": self.regrowth.fault, "overlay": self.overlay.fault}
        return by_mode[self.session.mode]

    @property
    def canvas_px(self) -> tuple[int, int]:
        """Width and height of what the canvas shows: the result of the present mode, or the picture as it was."""
        warped = self.session.mode == "warp" and not self.unwarped.is_shown
        return self.document.canvas_px if warped else self.document.size_px

    @property
    def is_busy(self) -> bool:
        """Whether a gesture is in progress or a slider held."""
        return bool(self._hand)

    @property
    def state(self) -> str:
        """Tool and whether a gesture is in progress: "pins.idle", "pins.busy"."""
        return self._hand.state

    def _history(self, document: Document, *, saved: bool = True) -> History:
        return History(document, saved=saved, budget_bytes=self.preferences.undo_bytes)

    def prefer(self, preferences: Preferences, *, keep: bool = True) -> None:
        """Take other preferences, and `keep` them for later runs."""
        self.preferences = preferences
        self.history.budget_bytes = preferences.undo_bytes
        if self.recovery is not None:
            self.recovery.every_s = preferences.keep_every_s
        if keep and self.preferences_file is not None:
            try:
                save_preferences(self.preferences_file, preferences)
            except WeftError as fault:
                self.fail(fault)

    @contextmanager
    def group(self, label: str, *, joins: bool = False) -> Iterator[None]:
        """Make one undo entry of all edits in the block; with `joins`, of those just before with this label too."""
        self.animation.stop()
        with self.history.group(label, joins=joins):
            before = self.document
            yield
            if self.document is not before:
                self.document = self.document.changed(mode=self.session.mode)

    def edit(self, label: str, document: Document, *, joins: bool = False) -> None:
        """Finish what is in progress and make `document` the present one, as one undo entry."""
        self.finish()
        with self.group(label, joins=joins):
            self.document = document

    def slide(self, label: str, document: Document) -> None:
        """Show `document` while a slider is held; all calls with one label until `finish` are one undo entry."""
        self._hand.hold_slider(label, self.group)
        self.document = document

    def show(self, **changes: object) -> None:
        """Change the session."""
        self.session = replace(self.session, **changes)  # type: ignore[arg-type]

    def update(self) -> None:
        """Take what jobs have ready and bring the map up to date; once per frame, after the events."""
        self.jobs.drain(hold_edits=self.is_busy)
        for text in self.jobs.take_notices():
            self.notify(text)
        self.animation.update()
        self.unwarped.update()
        if self.session.mode == "retexture":
            self._update_retexture()
        elif self.session.mode == "overlay":
            self.overlay.update(self.document, held=self.is_busy)
        else:
            on_canvas, in_space = not self.unwarped.is_shown, self.document.surface is not None
            self.live.update(self.document, is_seen=on_canvas or in_space, beside=not on_canvas)
        if self.recovery is not None and not self.is_busy:
            self.recovery.update(self.history.document, saved=self.history.is_saved, now=self.clock(), **self._origin)

    def keep_unsaved(self) -> None:
        """Keep unsaved work at once, since the program ends without having asked for it."""
        if self.recovery is not None and not self.history.is_saved:
            self.recovery.keep(self.history.document, **self._origin)

    @property
    def _origin(self) -> Origin:
        """What the document is called, and where it and its picture lie."""
        return {"name": self.name, "project": self.project_path, "source": self.source_path}

    def _update_retexture(self) -> None:
        """Follow the curves; who moves a target wants to see it."""
        session = self.session
        moved = self.regrowth.update(self.document, held=self.is_busy, starts=session.auto_retexture)
        if moved and self.is_busy and session.look == "original":
            self.show(look="retextured")

    @property
    def wait_s(self) -> float | None:
        """Seconds until `update` has something to do without an event; None when that needs an event."""
        due = None if self.recovery is None else self.recovery.due_at
        waits = [self.animation.wait_s, None if due is None else max(0.0, due - self.clock())]
        waits += [self.live.wait_s] if self.session.mode == "warp" else []
        return min((wait for wait in waits if wait is not None), default=None)

    def choose_tool(self, name: str) -> None:
        """Finish what is in progress and take another tool."""
        self.finish()
        self.show(tool=name, hover=None)
        if self.tools[name].on_original and moves(self.document):
            self.show(look="original")
        if self.tools[name].group:
            self.show(select_tool=name)
        (self.unwarped.show if self.tools[name].marks else self.unwarped.hide)()

    def choose_mode(self, mode: Mode) -> None:
        """Finish what is in progress and work in another mode, with the tool that was last used there."""
        self.finish()
        before = self.session
        if mode != before.mode:
            self._tools_left[before.mode] = before.tool
            tool = self._tools_left.get(mode) or first_tool(self.tools, mode)
            self.show(mode=mode, tool=tool, hover=None, selected_curve=None, selected_knots=frozenset())

    def undo(self) -> None:
        """Cancel a gesture in progress, or else take back the last entry."""
        if self._hand.has_gesture:
            self.cancel()
            return
        self.finish()
        self.history.undo()
        self.show(hover=None)

    def redo(self) -> None:
        """Do again what was taken back."""
        self.finish()
        self.history.redo()
        self.show(hover=None)

    def go_to(self, index: int) -> None:
        """Make entry number `index` of the history the present one."""
        self.finish()
        self.history.go_to(index)
        self.show(hover=None)

    def replace_document(
        self, document: Document, *, project: Path | None, source: Path | None, saved: bool = True
    ) -> None:
        """Begin anew with another document and an empty history."""
        self.cancel()
        self.jobs.cancel_all()
        self.session = self.session.for_document(self.document.size_px, document.size_px)
        self.history = self._history(document, saved=saved)
        self.project_path, self.source_path = project, source
        self.animation.open_up()
        if source is None:
            self.choose_mode(document.mode)

    def finish(self) -> None:
        """End the gesture or the held slider in progress and keep what it did."""
        self._hand.finish()

    def cancel(self) -> bool:
        """End the gesture or the held slider in progress without a trace; say whether there was one."""
        return self._hand.cancel()

    def handle(self, event: Event) -> bool:
        """Let the tools act on `event`; return whether they did. What they refuse is a notice."""
        with tracing.span("event", kind=type(event).__name__):
            try:
                return self._hand.handle(event)
            except WeftError as fault:
                self.cancel()
                self.fail(fault)
                return True
