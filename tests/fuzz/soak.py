"""Use the real window at random: `python -m tests.fuzz.soak [--minutes M | --deeds D] [--seed N]`.

A hand without a plan drags on the canvas and over the panels, presses keys and chords, runs actions, sets sliders to
their ends, types into fields and answers dialogs. No fault may come up, and memory must stay bounded.
"""

import argparse
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from imgui_bundle import ImVec2, imgui

from app.editor.editor import Editor
from app.model.jobs import Jobs
from app.model.requests import ExportOptions
from app.state.recovery import Recovery
from app.tools.all import TOOLS
from core.document.document import Document
from core.imaging.images import Image
from core.progress import Job, Progress
from core.warps.presets import PRESETS
from tests.gui.window_driver import WindowDriver, drive

SIZE = (1280, 800)
GROWTH_MB = 400
"""Memory may grow by so much after the first third of the soak, when all modes have been seen."""
LOOKS = 24
"""So often memory is looked at."""
LEFT_OUT = ("file.quit", "file.open", "file.new", "file.replace_picture", "view.full_screen")
SCRAPS = ("a", "/", "12", "-5", "1e9", ".", "~", "é")
KEYS = tuple("bpochxgmk[]\\") + ("escape", "delete", "enter", "left", "up", "tab", "f1", "space")
NAMED = {"[": "left_bracket", "]": "right_bracket", "\\": "backslash", "left": "left_arrow", "up": "up_arrow"}


def picture() -> Image:
    """Return a picture of 480 x 320 pixels with some texture."""
    y, x = np.mgrid[:320, :480]
    noise = np.random.default_rng(0).integers(0, 30, (320, 480))
    channels = [x * 255 // 480, y * 255 // 320, ((x // 24 + y // 24) % 2) * 180 + noise]
    return Image(np.stack(channels, axis=-1).astype(np.uint8))


def exporting(document: Document, options: ExportOptions) -> Job[None]:
    """Pretend to export."""
    yield Progress(0.5, "soaking")


class Hand:
    """A hand without a plan."""

    def __init__(self, window: WindowDriver, draw: random.Random) -> None:
        self._window, self._draw = window, draw
        self._editor = window.editor
        table = window.shell.workspace.table
        self._actions = [action for action in table.actions if action.name not in LEFT_OUT]
        self.done = 0

    def act(self) -> None:
        """Do one thing."""
        deeds: tuple[Callable[[], None], ...] = (
            self._drag, self._drag, self._drag, self._click, self._key, self._action, self._setting, self._wheel,
            self._type, self._undo,
        )  # fmt: skip
        self._draw.choice(deeds)()
        self.done += 1
        if self._draw.random() < 0.3:
            self._window.wait(1)
        if self.done % 40 == 0:
            self._clear()

    def _place(self) -> ImVec2:
        area = self._window.shell.workspace.canvas.area
        if self._draw.random() < 0.7:
            x, y = area.x + self._draw.random() * area.width, area.y + self._draw.random() * area.height
        else:
            x, y = self._draw.random() * SIZE[0], self._draw.random() * SIZE[1]
        return ImVec2(x, y)

    def _drag(self) -> None:
        context, button = self._window.context, self._draw.choice((0, 0, 0, 0, 1, 2))
        context.mouse_move_to_pos(self._place())
        context.mouse_down(button)
        for _ in range(self._draw.randrange(4)):
            context.mouse_move_to_pos(self._place())
        context.mouse_up(button)

    def _click(self) -> None:
        self._window.context.mouse_move_to_pos(self._place())
        self._window.context.mouse_click(0)

    def _wheel(self) -> None:
        self._window.context.mouse_move_to_pos(self._place())
        self._window.context.mouse_wheel_y(self._draw.choice((-2, -1, 1, 2)))

    def _key(self) -> None:
        name = self._draw.choice(KEYS)
        chord = [getattr(imgui.Key, NAMED.get(name, name))]
        if self._draw.random() < 0.2:
            chord.append(self._draw.choice((imgui.Key.mod_shift, imgui.Key.mod_alt)))
        self._window.key(*chord)

    def _action(self) -> None:
        self._draw.choice(self._actions).try_run(self._editor)
        self._window.wait(1)

    def _setting(self) -> None:
        preset = self._draw.choice(list(PRESETS))
        settings = {p.name: self._draw.choice((p.low, p.high, p.default)) for p in PRESETS[preset].settings}
        bend = self._draw.choice((-100.0, -30.0, 0.0, 45.0, 100.0))
        document = self._editor.document
        self._editor.edit("Setting", document.with_warp(preset=preset, bend=bend, values=settings))

    def _type(self) -> None:
        self._window.context.key_chars("".join(self._draw.choices(SCRAPS, k=3)))

    def _undo(self) -> None:
        for _ in range(self._draw.randrange(6)):
            self._editor.undo()

    def _clear(self) -> None:
        """Close what lies over the window, and stop what takes long."""
        self._editor.jobs.cancel_all()
        for _ in range(3):
            self._window.key(imgui.Key.escape).wait(1)
        self._editor.show(panels=True, compare="result")


def memory_mb() -> float:
    """Return how much memory the process has in use, in mebibytes."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def soak(share: Callable[[int], float], seed: int) -> int:
    """Use the window until `share`, which is told how many deeds are done, is 1; return 1 where memory ran away."""
    grown: list[float] = []
    jobs = Jobs()
    with tempfile.TemporaryDirectory() as folder:
        start = Document.of(picture()).with_warp(cell_px=16.0)
        editor = Editor(
            start,
            TOOLS,
            jobs=jobs,
            exporter=exporting,
            recovery=Recovery(jobs, folder=Path(folder) / "kept", every_s=2.0),
        )
        os.chdir(folder)

        def script(window: WindowDriver) -> None:
            hand = Hand(window, random.Random(seed))
            while (done := share(hand.done)) < 1:
                if done * LOOKS >= len(grown):
                    grown.append(memory_mb())
                    sys.stdout.write(f"{done:4.0%}  {hand.done:7d} deeds  {grown[-1]:6.0f} MiB\n")
                    sys.stdout.flush()
                hand.act()

        drive(editor, script, size=SIZE)
        jobs.close()
        os.chdir("/")
    settled = [*grown[LOOKS // 3 :], memory_mb()]
    return 1 if max(settled) - settled[0] > GROWTH_MB else 0


def main() -> int:
    """Run from the command line, under a display of its own where there is none."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--deeds", type=int, help="end after so many deeds, however long they take")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        screen = f"-screen 0 {SIZE[0]}x{SIZE[1]}x24"
        command = ["xvfb-run", "-a", "-s", screen, sys.executable, "-m", "tests.fuzz.soak", *sys.argv[1:]]
        return subprocess.run(command, check=False).returncode
    begun, seconds = time.monotonic(), 60 * arguments.minutes
    if arguments.deeds:
        return soak(lambda done: done / arguments.deeds, arguments.seed)
    return soak(lambda _: (time.monotonic() - begun) / seconds, arguments.seed)


if __name__ == "__main__":
    sys.exit(main())
