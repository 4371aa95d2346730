"""Kill a batch again and again, and resume it: `python -m tests.fuzz.batch_kills [--frames N] [--seed S]`.

A batch in two processes is killed with all of them at a random moment and resumed, until it comes to its end by
itself. After every kill each picture that is there must be whole and what an undisturbed run makes; none that was there
with its record may be made again.
"""

import argparse
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

from app.bench.batch import digests, write_scene
from tests.fuzz.readers import scratch

SIZE = (160, 90)
LONGEST_S = 15.0


def begin(recipe: Path, folder: Path) -> "subprocess.Popen[bytes]":
    """Begin the batch, or go on with it, in a session of its own."""
    words = ["batch", str(recipe), "-o", str(folder / "f.####.png"), "--jobs", "2", "--resume"]
    return subprocess.Popen([sys.executable, "-m", "app", *words], start_new_session=True, stdout=subprocess.DEVNULL)


def finished(folder: Path) -> dict[str, int]:
    """Return when each picture that has its record was written, by its name."""
    frames = (int(record.stem[-7:]) for record in folder.glob("*.batch/frame-*.json"))
    pictures = [folder / f"f.{frame:04d}.png" for frame in frames]
    return {picture.name: picture.stat().st_mtime_ns for picture in pictures if picture.exists()}


def main(frames: int, seed: int) -> int:
    """Kill and resume until the batch is done; return how often it was killed."""
    chance, kills = random.Random(seed), 0
    with scratch() as name:
        folder = Path(name)
        recipe = write_scene(folder, frames, SIZE)
        assert begin(recipe, folder / "undisturbed").wait() == 0
        expected, broken, before = digests(folder / "undisturbed"), folder / "killed", dict[str, int]()
        while True:
            running = begin(recipe, broken)
            try:
                running.wait(chance.uniform(0.5, LONGEST_S))
            except subprocess.TimeoutExpired:
                os.killpg(running.pid, signal.SIGKILL)
                running.wait()
                time.sleep(0.2)  # its workers go with it
                kills += 1
            now, there = finished(broken), digests(broken) if broken.exists() else {}
            assert before.items() <= now.items(), "a frame was made twice"
            shown = {name: digest for name, digest in there.items() if not name.startswith(".")}
            assert shown.items() <= expected.items(), "a frame is not what it should be"
            before = now
            if running.returncode == 0:
                assert shown == expected
                return kills


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    sys.stdout.write(f"killed {main(options.frames, options.seed)} times; nothing lost, nothing made twice\n")
