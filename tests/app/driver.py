"""Drives the editor as a user would, without a window: `drive.tool("brush").press(10, 10).move(40, 10).release()`."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from app.editor.editor import Editor
from app.live.warp import REST_S
from app.model.events import Button, Key, KeyUp, Modifiers, Move, Position, Press, Release, Wheel
from app.model.jobs import Jobs
from app.model.spaces import View, canvas_from_screen, screen_from_canvas
from app.tools.all import TOOLS
from core.arrays import Points
from core.document.document import Document
from core.imaging.images import Image

PLAIN = Modifiers()


def picture(width: int = 200, height: int = 150) -> Image:
    """Return a colourful picture."""
    y, x = np.mgrid[:height, :width]
    channels = [x * 255 // width, y * 255 // height, (x // 10 + y // 10) % 2 * 255]
    return Image(np.stack(channels, axis=-1).astype(np.uint8))


def document(width: int = 200, height: int = 150, *, cell_px: float = 8.0) -> Document:
    """Return a document on a coarse grid."""
    return Document.of(picture(width, height)).with_warp(cell_px=cell_px)


@dataclass
class Clock:
    """A clock that goes when told."""

    now: float = 0.0

    def __call__(self) -> float:
        return self.now


class EditorDriver:
    """An editor on inline jobs. Positions are screen pixels; the view shows canvas pixels one to one at first.

    Every event is followed by a frame, unless inside `frozen`.
    """

    def __init__(self, start: Document | None = None, *, jobs: Jobs | None = None) -> None:
        self.clock = Clock()
        self.start = start or document()
        self.editor = Editor(self.start, TOOLS, jobs=jobs or Jobs.inline(), clock=self.clock)
        self.editor.show(view=View(size=(800.0, 600.0)))
        self.frame()

    @property
    def document(self) -> Document:
        return self.editor.document

    @property
    def mask(self) -> Points:
        return self.document.mask.array.astype(float)

    def tool(self, name: str) -> "EditorDriver":
        self.editor.choose_tool(name)
        return self

    def press(self, x: float, y: float, **mods: bool) -> "EditorDriver":
        return self.press_button(x, y, mods=Modifiers(**mods))

    def press_button(
        self, x: float, y: float, *, button: Button = "left", clicks: int = 1, mods: Modifiers = PLAIN
    ) -> "EditorDriver":
        self.editor.handle(Press((x, y), button, mods, clicks))
        return self.frame()

    def move(self, x: float, y: float, **mods: bool) -> "EditorDriver":
        self.editor.handle(Move((x, y), Modifiers(**mods)))
        return self.frame()

    def release(self, x: float | None = None, y: float | None = None, **mods: bool) -> "EditorDriver":
        last = self.editor.session.pointer or (0.0, 0.0)
        pos: Position = last if x is None or y is None else (x, y)
        self.editor.handle(Release(pos, Modifiers(**mods)))
        return self.frame()

    def click(self, x: float, y: float, **mods: bool) -> "EditorDriver":
        return self.move(x, y, **mods).press(x, y, **mods).release(x, y, **mods)

    def double_click(self, x: float, y: float) -> "EditorDriver":
        return self.click(x, y).press_button(x, y, clicks=2).release(x, y)

    def drag(self, *path: Position, **mods: bool) -> "EditorDriver":
        self.move(*path[0], **mods).press(*path[0], **mods)
        for place in path[1:]:
            self.move(*place, **mods)
        return self.release(*path[-1], **mods)

    def wheel(self, x: float, y: float, notches: float) -> "EditorDriver":
        self.editor.handle(Wheel((x, y), notches))
        return self.frame()

    def key(self, name: str, **mods: bool) -> "EditorDriver":
        self.editor.handle(Key(name, Modifiers(**mods)))
        return self.frame()

    def key_up(self, name: str) -> "EditorDriver":
        self.editor.handle(KeyUp(name))
        return self.frame()

    def undo(self) -> "EditorDriver":
        self.editor.undo()
        return self.frame()

    def redo(self) -> "EditorDriver":
        self.editor.redo()
        return self.frame()

    def frame(self) -> "EditorDriver":
        """Draw a frame, and one more for what jobs have ready."""
        self.editor.update()
        if not self.editor.jobs.is_idle:
            self.editor.update()
        return self

    def rest(self) -> "EditorDriver":
        """Let the artist's hand rest until the final answer is there."""
        self.clock.now += REST_S
        return self.frame().frame()

    def in_(self, state: str) -> bool:
        return self.editor.state == state

    @property
    def labels(self) -> tuple[str, ...]:
        return self.editor.history.labels[1:]

    def screen_of(self, x: float, y: float) -> Position:
        """Return where the picture's pixel (x, y) is on the screen now."""
        canvas = self.editor.answer.mesh.canvas_from_image(np.array([[x, y]]))
        place = screen_from_canvas(self.editor.session.view, canvas)[0]
        return float(place[0]), float(place[1])

    def picture_at(self, x: float, y: float) -> Points:
        """Return the pixel of the picture that is at screen (x, y)."""
        canvas = canvas_from_screen(self.editor.session.view, np.array([[x, y]]))
        return self.editor.answer.mesh.image_from_canvas(canvas).reshape(2)


class Later:
    """An executor that runs what was submitted when told."""

    def __init__(self) -> None:
        self.waiting: list[Callable[[], None]] = []

    def submit(self, work: Callable[[], None]) -> None:
        self.waiting.append(work)

    def run(self) -> None:
        while self.waiting:
            self.waiting.pop(0)()

    def close(self) -> None:
        self.run()
