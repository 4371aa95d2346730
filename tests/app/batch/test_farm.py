"""A batch on a Dask cluster, as a job template and as commands: the same bytes as here, and what a loss costs."""

import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from app.bench.batch import cluster
from tests.app.batch.scene import RECIPE, ROOT, bytes_of, make, states, weft, write_scene

pytestmark = [pytest.mark.gpu, pytest.mark.slow]

LONG = RECIPE.replace('shot.####.png"', 'shot.0001.png"\nframes = "1-40"').replace("= 2", "= 4")


@pytest.fixture
def recipe(tmp_path: Path) -> Path:
    return write_scene(tmp_path)


def test_two_workers_of_a_cluster_give_the_same_bytes(tmp_path: Path, recipe: Path) -> None:
    make(recipe, tmp_path / "here" / "f.####.png")
    with cluster(2) as address:
        done = weft(recipe, "-o", tmp_path / "there" / "f.####.png", "--cluster", address, folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert bytes_of(tmp_path / "there") == bytes_of(tmp_path / "here")


def begin(recipe: Path, output: Path, address: str) -> "subprocess.Popen[str]":
    """Begin a batch on a cluster, and return when its first frame is there."""
    words = ["batch", str(recipe), "-o", str(output), "--cluster", address, "--table", str(recipe.with_name("t.json"))]
    running = subprocess.Popen([sys.executable, "-m", "app", *words], cwd=ROOT, stderr=subprocess.PIPE, text=True)
    while not list(output.parent.glob("f.*.png")):
        time.sleep(0.02)
        assert running.poll() is None
    return running


def processes(name: str) -> list[psutil.Process]:
    """Return the processes that this test has begun whose command line has `name`."""
    return [child for child in psutil.Process().children(recursive=True) if name in child.cmdline()]


def test_a_cluster_worker_that_is_killed_costs_nothing(tmp_path: Path) -> None:
    recipe, output = write_scene(tmp_path, LONG), tmp_path / "there" / "f.####.png"
    with cluster(2) as address:
        running = begin(recipe, output, address)
        for process in processes("worker")[:1]:
            for one in [process, *process.children(recursive=True)]:
                one.send_signal(signal.SIGKILL)
        records = output.parent.glob("*.batch/frame-*.json")
        whole = {path: path.stat().st_mtime_ns for path in records}
        said = running.communicate()[1]
    assert (running.returncode, said) == (0, "")
    assert whole
    assert all(path.stat().st_mtime_ns == time for path, time in whole.items()), "a frame was made twice"
    assert len(states(tmp_path / "t.json")) == 40
    assert len(bytes_of(output.parent)) == 40


def test_after_the_scheduler_is_killed_resume_finishes_and_does_nothing_twice(tmp_path: Path) -> None:
    recipe, output = write_scene(tmp_path, LONG), tmp_path / "there" / "f.####.png"
    with cluster(2) as address:
        running = begin(recipe, output, address)
        processes("scheduler")[0].kill()
        said = running.communicate()[1]
    assert running.returncode == 2
    assert said == f"weft: error: --cluster {address}: the scheduler is gone; go on with --resume\n"
    whole = {path: path.stat().st_mtime_ns for path in output.parent.glob("f.*.png")}
    done = weft(recipe, "-o", output, "--resume", "--table", tmp_path / "t.json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert states(tmp_path / "t.json").count("kept") >= len(whole) > 0
    assert all(path.stat().st_mtime_ns == time for path, time in whole.items())
    assert len(bytes_of(output.parent)) == 40


def test_who_waits_for_a_cluster_in_vain_is_told_in_one_line(tmp_path: Path, recipe: Path) -> None:
    """All wait at once: each waits for as long as a scheduler has to answer."""
    nobody = "tcp://127.0.0.1:1", "tcp://nowhere.invalid:8786", "http://127.0.0.1:1", "farm"
    said = dict.fromkeys(nobody, "no Dask scheduler answers there")
    with cluster(0) as idle:
        said[idle] = "has no workers"
        words = ["batch", recipe, "-o", tmp_path / "f.####.png", "--cluster"]
        asked = {
            address: subprocess.Popen(
                [sys.executable, "-m", "app", *map(str, words), address], cwd=ROOT, stderr=subprocess.PIPE, text=True
            )
            for address in said
        }
        found = {address: (running.communicate()[1], running.returncode) for address, running in asked.items()}
    assert found == {address: (f"weft: error: --cluster {address}: {fault}\n", 2) for address, fault in said.items()}


def test_openjd_runs_the_template(tmp_path: Path, recipe: Path) -> None:
    make(recipe, tmp_path / "here" / "f.####.png")
    template = tmp_path / "job.json"
    assert weft(recipe, "-o", tmp_path / "job" / "f.####.png", "--openjd", template, folder=tmp_path).returncode == 0
    bin_folder = str(Path(sys.executable).parent)
    environment = os.environ | {"PATH": f"{bin_folder}{os.pathsep}{os.environ['PATH']}"}
    command = [f"{bin_folder}/openjd", "run", str(template)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert bytes_of(tmp_path / "job") == bytes_of(tmp_path / "here")


def test_the_printed_commands_make_the_frames_and_nothing_twice(tmp_path: Path, recipe: Path) -> None:
    make(recipe, tmp_path / "here" / "f.####.png")
    words = [recipe, "-o", tmp_path / "c" / "f.####.png", "--frames", "1-6", "--print-commands"]
    lines = weft(*words, folder=tmp_path).stdout.splitlines()
    assert [shlex.split(line)[-3:] for line in lines] == [["--shard", f"{k}/3", "--resume"] for k in (1, 2, 3)]
    assert weft(*words, "--shard", "2/3", folder=tmp_path).stdout.splitlines() == lines[1:2]
    assert not (tmp_path / "c").exists() or not bytes_of(tmp_path / "c")
    for line in [*lines, lines[0]]:
        program, *rest = shlex.split(line)
        assert program == "weft"
        done = subprocess.run(
            [sys.executable, "-m", "app", *rest], cwd=ROOT, capture_output=True, text=True, check=True
        )
        assert done.stdout.startswith("2 frames:")
    assert done.stdout.startswith("2 frames: 0 done, 2 were done before")
    assert bytes_of(tmp_path / "c") == bytes_of(tmp_path / "here")


def test_a_template_refuses_what_it_would_take_for_a_reference(tmp_path: Path, recipe: Path) -> None:
    done = weft(recipe, "-o", tmp_path / "{{a}}.####.png", "--openjd", tmp_path / "job.json", folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.endswith(".####.png: a name with {{ cannot stand in a job template\n")
    assert not (tmp_path / "job.json").exists()
