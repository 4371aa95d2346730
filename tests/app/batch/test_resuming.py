"""What is done of a batch is kept, wherever it ends."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from app.batch.work import DiskFullError
from core.files import atomic as files_module
from core.files import litter
from core.imaging.images import Image, save
from tests.app.batch.scene import (
    FRAMES,
    RECIPE,
    ROOT,
    bytes_of,
    make,
    plate,
    states,
    write_recipe,
    write_scene,
)

pytestmark = pytest.mark.gpu


KILLED = """
import sys
from pathlib import Path
from tests.app.batch.scene import make
from tests.killing import kill_before_move

kill_before_move(int(sys.argv[1]))
make(Path(sys.argv[2]) / "recipe.toml", Path(sys.argv[2]) / "out" / "f.####.png")
"""


def test_what_is_done_is_kept_unless_its_recipe_or_its_picture_changes(tmp_path: Path) -> None:
    recipe, output = write_scene(tmp_path), tmp_path / "out" / "f.####.png"
    make(recipe, output)
    assert [row.state for row in make(recipe, output, resume=True)] == ["kept"] * FRAMES
    save(Image(plate(9)), tmp_path / "plates" / "shot.0002.png")
    (tmp_path / "out" / "f.0004.png").unlink()
    again = make(recipe, output, resume=True)
    assert [row.state for row in again] == ["kept", "done", "kept", "done", "kept", "kept"]
    write_recipe(tmp_path, RECIPE.replace("value = 50", "value = 40"))
    assert [row.state for row in make(recipe, output, resume=True)] == ["done"] * FRAMES
    assert [row.state for row in make(recipe, output)] == ["done"] * FRAMES


@pytest.mark.parametrize("moves", [0, 1, 5])
def test_killed_between_any_two_files_it_goes_on_where_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moves: int
) -> None:
    monkeypatch.setattr(litter, "YOUNG_S", -1.0)
    recipe, output = write_scene(tmp_path), tmp_path / "out" / "f.####.png"
    done = subprocess.run([sys.executable, "-c", KILLED, str(moves), str(tmp_path)], cwd=ROOT, check=False)
    assert done.returncode == -signal.SIGKILL
    whole = {path: path.stat().st_mtime_ns for path in output.parent.glob("f*.png")}
    assert len(whole) == (moves + 1) // 2
    rows = make(recipe, output, resume=True)
    finished = moves // 2 + 1  # all that was whole
    assert [row.state for row in rows] == ["kept"] * finished + ["done"] * (FRAMES - finished)
    assert all(path.stat().st_mtime_ns == time for path, time in whole.items())
    make(recipe, tmp_path / "anew" / "f.####.png")
    assert bytes_of(output.parent) == bytes_of(tmp_path / "anew")
    assert not list(output.parent.glob(".weft-*"))


def test_a_full_disk_ends_the_run_and_resume_finishes_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    recipe, output = write_scene(tmp_path), tmp_path / "out" / "f.####.png"
    flush, room = files_module._flush, 5

    def flush_while_there_is_room(place: Path) -> None:
        nonlocal room
        room -= 1
        if room < 0:
            raise OSError(28, os.strerror(28))
        flush(place)

    with monkeypatch.context() as full:
        full.setattr(files_module, "_flush", flush_while_there_is_room)
        with pytest.raises(DiskFullError, match="no space left on device"):
            make(recipe, output)
    assert sorted(bytes_of(output.parent)) == ["f.0001.png", "f.0002.png"]
    assert [row.state for row in make(recipe, output, resume=True)] == ["kept"] * 2 + ["done"] * 4


def test_a_worker_that_is_killed_costs_nothing(tmp_path: Path) -> None:
    recipe = write_scene(
        tmp_path, RECIPE.replace('shot.####.png"', 'shot.0001.png"\nframes = "1-24"').replace("= 2", "= 8")
    )
    table = tmp_path / "t.json"
    words = [str(recipe), "-o", str(tmp_path / "out" / "f.####.png"), "--jobs", "2", "--table", str(table)]
    with subprocess.Popen([sys.executable, "-m", "app", "batch", *words], cwd=ROOT, stderr=subprocess.PIPE) as running:
        while not list((tmp_path / "out").glob("f.*.png")):
            time.sleep(0.02)
            assert running.poll() is None
        workers = [
            child for child in psutil.Process(running.pid).children() if "spawn_main" in " ".join(child.cmdline())
        ]
        workers[0].kill()
        assert running.communicate()[1] == b""
    assert running.returncode == 0
    assert len(states(table)) == 24
    assert set(states(table)) <= {"done", "kept"}
    make(recipe, tmp_path / "here" / "f.####.png")
    assert bytes_of(tmp_path / "out") == bytes_of(tmp_path / "here")
