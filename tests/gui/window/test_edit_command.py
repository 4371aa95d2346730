"""`weft [FILE]`: what it opens, and what it says without a display and for a file that cannot be read."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from app.commands.edit import editor_on, open_up
from app.model.jobs import Jobs
from app.state.recovery import Recovery
from app.tours.samples import warp_sample
from core.document.project import load_project, save_project
from core.imaging.images import Image, load, save
from tests.app.driver import document


def surroundings(home: Path) -> dict[str, str]:
    """Return an environment in which the program keeps its files in `home`."""
    here = {"PYTHONPATH": str(Path(__file__).parents[3]), "XDG_STATE_HOME": str(home), "XDG_CONFIG_HOME": str(home)}
    return os.environ | here


def python(*words: str | Path, cwd: Path, env: dict[str, str]) -> subprocess.CompletedProcess[str]:
    """Run Python."""
    command = [sys.executable, *map(str, words)]
    return subprocess.run(command, cwd=cwd, env=env, capture_output=True, text=True, timeout=120, check=False)


def weft(*words: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run `weft` without a display."""
    hidden = ("DISPLAY", "WAYLAND_DISPLAY")
    env = {name: value for name, value in surroundings(cwd).items() if name not in hidden}
    return python("-m", "app", *words, cwd=cwd, env=env)


@pytest.mark.gpu
def test_without_a_display_it_renders_to_a_file_and_says_what_a_window_needs(tmp_path: Path) -> None:
    done = weft(cwd=tmp_path)
    assert done.returncode == 0
    rendered = tmp_path / "weft-sample.png"
    assert str(rendered) in done.stdout
    assert "DISPLAY" in done.stdout
    pixels = load(rendered).pixels
    assert pixels.shape[1] > warp_sample().image.width_px
    assert pixels[0, 0, 3] == 0, "the arc leaves the corners free"
    assert pixels[pixels.shape[0] // 2, pixels.shape[1] // 2, 3] == 255


@pytest.mark.parametrize("content", [None, b"", b"not a picture"])
def test_a_bad_file_is_one_line_and_status_2(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "picture.png"
    if content is not None:
        path.write_bytes(content)
    done = weft(path, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith("weft: error: ")
    assert "picture.png" in done.stderr


BENT_AND_ENDED = """
import os, signal, sys, threading
from pathlib import Path
from app.commands import edit
from app.window.shell import Shell

class Ended(Shell):
    def _end_frame(self):
        super()._end_frame()
        if self.frames == 5:
            self.editor.edit("Bend", self.editor.document.with_warp(bend=44.0))
            os.kill(os.getpid(), getattr(signal, sys.argv[1]))

import app.window.shell
app.window.shell.Shell = Ended
from app.__main__ import main
sys.exit(main([]))
"""


@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGINT"])
def test_a_signal_ends_the_window_and_keeps_the_work(tmp_path: Path, name: str) -> None:
    done = python("-c", BENT_AND_ENDED, name, cwd=tmp_path, env=surroundings(tmp_path))
    assert done.returncode == 130, done.stderr
    (kept,) = (tmp_path / "weft" / "recovery").glob("*.weft")
    assert load_project(kept).warp.bend == 44.0


def test_it_opens_pictures_and_projects(tmp_path: Path) -> None:
    picture, project = tmp_path / "a.png", tmp_path / "a.weft"
    save(Image(np.zeros((20, 30, 3), np.uint8)), picture)
    save_project(document().with_warp(preset="arc"), project)
    assert open_up(picture).size_px == (30, 20)
    assert open_up(project).warp.preset == "arc"


def test_the_sample_has_features() -> None:
    assert not warp_sample().mask.is_empty


def test_the_editor_knows_what_was_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    path = tmp_path / "a.weft"
    editor = editor_on(document(), path, Jobs.inline())
    assert editor.project_path == path
    assert editor.session.recent[0] == str(path.resolve())
    assert isinstance(editor.recovery, Recovery)
    assert editor.exporter is not None


@pytest.mark.gpu
def test_without_a_display_no_file_is_written_over(tmp_path: Path) -> None:
    picture = tmp_path / "moor.png"
    save(Image(np.full((20, 30, 3), 90, np.uint8)), picture)
    (tmp_path / "weft-sample.png").write_text("mine")
    (tmp_path / "moor-weft.png").write_text("mine")
    assert weft(picture, cwd=tmp_path).returncode == 0
    assert weft(cwd=tmp_path).returncode == 0
    assert (tmp_path / "weft-sample.png").read_text() == "mine"
    assert (tmp_path / "moor-weft.png").read_text() == "mine"
    assert load(tmp_path / "moor-weft-2.png").size_px == (30, 20)
    assert (tmp_path / "weft-sample-2.png").exists()


def test_too_little_opengl_is_said_in_one_line(tmp_path: Path) -> None:
    picture = tmp_path / "moor.png"
    save(Image(np.full((20, 30, 3), 90, np.uint8)), picture)
    env = surroundings(tmp_path) | {"MESA_GL_VERSION_OVERRIDE": "3.0", "LIBGL_ALWAYS_SOFTWARE": "1"}
    done = python("-m", "app", picture, cwd=tmp_path, env=env)
    assert done.returncode == 2
    assert done.stderr.startswith("weft: error: no window: it needs OpenGL 3.3")
    assert done.stderr.count("\n") == 1
