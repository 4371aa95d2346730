"""Processes of a batch: what is done after a loss, and that nothing of them stays."""

import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import psutil
import pytest

from app.batch.pool import _again
from app.batch.records import Row
from tests.app.batch.scene import RECIPE, ROOT, bytes_of, chunks_of, write_scene


def test_a_chunk_is_tried_again_then_frame_by_frame_and_then_it_has_failed(tmp_path: Path) -> None:
    chunk, losses, rows = (
        chunks_of(write_scene(tmp_path), tmp_path / "f.#.png")[1],
        Counter[tuple[int, int, int]](),
        list[Row](),
    )
    (whole,) = _again(chunk, losses, rows.extend)
    assert (whole.items, whole.batch.resume) == (chunk.items, True)
    alone = _again(whole, losses, rows.extend)
    assert [[item.frame for item in part.items] for part in alone] == [[3], [4]]
    assert _again(alone[0], losses, rows.extend) == [alone[0]]
    assert not rows
    assert _again(alone[0], losses, rows.extend) == []
    assert [(row.frame, row.state) for row in rows] == [(3, "failed")]


@pytest.mark.gpu
@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="what a process maps is not to be seen here")
def test_no_process_holds_what_would_stay_when_all_are_killed_together(tmp_path: Path) -> None:
    recipe = write_scene(tmp_path, RECIPE.replace('shot.####.png"', 'shot.0001.png"\nframes = "1-40"'))
    words = ["batch", str(recipe), "-o", str(tmp_path / "out" / "f.####.png"), "--jobs", "2"]
    with subprocess.Popen([sys.executable, "-m", "app", *words], cwd=ROOT, start_new_session=True) as running:
        while not (tmp_path / "out").is_dir() or not bytes_of(tmp_path / "out"):
            time.sleep(0.02)
            assert running.poll() is None
        family = [psutil.Process(running.pid), *psutil.Process(running.pid).children(recursive=True)]
        maps = [Path(f"/proc/{process.pid}/maps").read_text() for process in family]
        os.killpg(running.pid, signal.SIGKILL)
    assert len(maps) >= 3
    assert not any("/dev/shm/" in text for text in maps)  # where named semaphores are
