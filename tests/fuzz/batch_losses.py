"""Lose a part of a batch in its middle: `python -m tests.fuzz.batch_losses [--frames N] [--small FOLDER]`.

Lost are a worker of `--jobs 2`, a worker of a Dask cluster, its scheduler, and the room on the disk, where FOLDER is on
a file system that holds less than the frames, such as a tmpfs of 8 MB. Whatever the run itself does not finish,
`--resume` must; no frame that was done may be made again, and all must be what an undisturbed run makes.
"""

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import psutil

from app.bench.batch import cluster, digests, write_scene
from tests.fuzz.batch_kills import finished
from tests.fuzz.readers import scratch

Loss = Callable[[], object]


def begin(recipe: Path, output: Path, *words: str) -> "subprocess.Popen[str]":
    """Begin the batch."""
    command = [sys.executable, "-m", "app", "batch", str(recipe), "-o", str(output / "f.####.png"), *words]
    return subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def kill(*names: str) -> None:
    """Kill the first process below this one whose command line has all the names, and those below it."""
    below = psutil.Process().children(recursive=True)
    for process in [child for child in below if all(name in " ".join(child.cmdline()) for name in names)][:1]:
        for one in [*process.children(recursive=True), process]:
            one.kill()


def lose(recipe: Path, output: Path, frames: int, words: tuple[str, ...], loss: Loss) -> tuple[int, str, int, int]:
    """Begin, lose something once a quarter is there, and resume; return status, fault and frames there, before, after.

    What was done before the loss must not be made again.
    """
    running = begin(recipe, output, *words)
    while len(finished(output)) < frames // 4 and running.poll() is None:
        time.sleep(0.05)
    before = finished(output)
    loss()
    _, fault = running.communicate()
    there = finished(output)
    if running.returncode:
        again = begin(recipe, output, "--resume")
        assert again.wait() == 0, again.communicate()[1]
    assert before.items() <= there.items() <= finished(output).items(), "a frame was made twice"
    return running.returncode, fault.strip(), len(before), len(there)


@contextmanager
def room_below(folder: Path, least: int) -> Iterator[Loss]:
    """Yield what fills the file system of `folder` but for `least` bytes; on leaving it is empty again."""
    ballast = folder / "ballast"

    def fill() -> None:
        free = os.statvfs(folder).f_bavail * os.statvfs(folder).f_frsize
        ballast.write_bytes(bytes(max(free - least, 0)))

    yield fill
    ballast.unlink(missing_ok=True)


def main(frames: int, small: Path | None) -> None:
    """Lose one after another, and say what became of it."""
    with scratch() as name:
        folder = Path(name)
        recipe = write_scene(folder, frames)
        assert begin(recipe, folder / "undisturbed", "--jobs", "2").wait() == 0
        expected = digests(folder / "undisturbed")

        def tell(what: str, output: Path, found: tuple[int, str, int, int]) -> None:
            shown = {name: digest for name, digest in digests(output).items() if not name.startswith(".")}
            assert shown == expected, f"{what}: a frame is not what it should be"
            status, fault, before, there = found
            sys.stdout.write(f"{what}: at {before} of {frames} frames; status {status}, {there} then there; {fault}\n")
            sys.stdout.flush()

        found = lose(recipe, folder / "1", frames, ("--jobs", "2"), partial(kill, "spawn_main"))
        tell("a worker of --jobs 2 killed", folder / "1", found)
        for number, role in enumerate(("worker", "scheduler"), 2):
            output = folder / str(number)
            with cluster(2) as address:
                found = lose(recipe, output, frames, ("--cluster", address), partial(kill, "dask", role))
            tell(f"a cluster's {role} killed", output, found)
        if small is not None:
            output = small / "frames"
            with room_below(small, 100_000) as fill:
                running = begin(recipe, output, "--jobs", "2")
                while len(finished(output)) < frames // 4 and running.poll() is None:
                    time.sleep(0.05)
                before = finished(output)
                fill()
                fault = running.communicate()[1].strip()
                there = finished(output)
            assert begin(recipe, output, "--resume", "--jobs", "2").wait() == 0
            assert before.items() <= there.items() <= finished(output).items(), "a frame was made twice"
            tell("the disk full", output, (running.returncode, fault, len(before), len(there)))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--small", type=Path)
    options = parser.parse_args()
    main(options.frames, options.small)
