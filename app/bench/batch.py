"""What a batch takes on one process, on two, on a cluster, as a job template and in shards: the `batch` list.

Every way makes the same frames of a moving warp with a mask; their bytes are compared with those of one process.
"""

import hashlib
import importlib.util
import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from core.arrays import WeftError
from core.imaging.images import Image, save

FRAMES, QUICK_FRAMES = 200, 12
SIZE = (480, 320)
WORKERS = 2
_SHARDS = 4
_START_S = 60.0
_WEFT = [sys.executable, "-m", "app"]
_RECIPE = """\
picture = "plates/shot.####.png"
mask = "mask.png"
chunk = {chunk}

[warp]
preset = "flag"

[keys]
bend = [{{frame = 1, value = -40, easing = "ease"}}, {{frame = {frames}, value = 60}}]
"""


@dataclass(frozen=True)
class Way:
    """One way to make the frames."""

    name: str
    workers: int
    make: Callable[[Path, Path], None]
    """Make the frames of the recipe into the folder."""
    needs: str | None = None
    """The package that it needs."""


def measure(frames: int = FRAMES) -> list[dict[str, Any]]:
    """Return one record for each way that the machine has.

    `seconds` is from the start of the first process to the end of the last, `speedup` that of the first way over it,
    `overhead_s` what the workers' time has beyond the frames themselves: starting, planning, handing out.
    `processor_s` is what all of it took of the processors, `overhead` the share of that above the first way's: it says
    the same of a machine that is busy otherwise, of which `load` tells, the processes that ran or waited to run in the
    last minute of the way, its own among them.
    """
    with tempfile.TemporaryDirectory(prefix="weft-bench-") as name:
        folder = Path(name)
        recipe, records = write_scene(folder, frames), list[dict[str, Any]]()
        for number, way in enumerate(WAYS):
            if way.needs is None or importlib.util.find_spec(way.needs) is not None:
                records.append(_measure(way, recipe, folder / str(number)))
                records[-1]["speedup"] = records[0]["seconds"] / records[-1]["seconds"]
                records[-1]["overhead"] = records[-1]["processor_s"] / records[0]["processor_s"] - 1
                records[-1]["same_bytes"] = digests(folder / str(number)) == digests(folder / "0")
        return records


def write_scene(folder: Path, frames: int, size: tuple[int, int] = SIZE) -> Path:
    """Write plates with a pattern that drifts, a mask of two discs and the recipe to `folder`; return the recipe."""
    width, height = size
    y, x = np.mgrid[0:height, 0:width]
    (folder / "plates").mkdir()
    for frame in range(1, frames + 1):
        colours = x * 255 / width, y * 255 / height, 128 + 60 * np.sin((x + frame) / 9) * np.cos(y / 7)
        save(Image(np.stack(colours, axis=-1).astype(np.uint8)), folder / "plates" / f"shot.{frame:04d}.png")
    discs = [np.hypot(x - share * width, y - height / 2) < height / 6 for share in (0.3, 0.7)]
    save(Image(np.where(discs[0] | discs[1], 255, 0).astype(np.uint8)[..., None]), folder / "mask.png")
    recipe = folder / "recipe.toml"
    recipe.write_text(_RECIPE.format(frames=frames, chunk=max(1, min(25, frames // 4))), encoding="utf-8")
    return recipe


def digests(folder: Path) -> dict[str, str]:
    """Return the digest of every frame in a folder, by its name."""
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in sorted(folder.glob("*.png"))}


def _measure(way: Way, recipe: Path, folder: Path) -> dict[str, Any]:
    started, processor = time.perf_counter(), _processor_s()
    way.make(recipe, folder)
    seconds, processor = time.perf_counter() - started, _processor_s() - processor
    rows = [row for record in folder.glob("*.batch/frame-*.json") for row in json.loads(record.read_text())["rows"]]
    drawing = sum(row["seconds"] for row in rows)
    return {
        "way": way.name,
        "workers": way.workers,
        "frames": len(rows),
        "seconds": seconds,
        "per_frame_ms": 1e3 * drawing / max(len(rows), 1),
        "overhead_s": way.workers * seconds - drawing,
        "processor_s": processor,
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
    }


def _processor_s() -> float:
    """Return the processor time of all processes that this one has begun and seen end."""
    times = os.times()
    return times.children_user + times.children_system


def _weft(recipe: Path, folder: Path, *words: str) -> str:
    """Run `weft batch` with these words, and return what it prints."""
    return _run([*_WEFT, "batch", str(recipe), "-o", str(folder / "f.####.png"), *words])


def _run(command: Sequence[str]) -> str:
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    environment = os.environ | {"PATH": path}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    if done.returncode:
        raise WeftError(f"{shlex.join(command)}: {done.stderr.strip() or done.stdout.strip()}")
    return done.stdout


def _with_jobs(recipe: Path, folder: Path, jobs: int) -> None:
    """Make the frames in so many processes of one run."""
    _weft(recipe, folder, "--jobs", str(jobs))


def _on_cluster(recipe: Path, folder: Path) -> None:
    """Begin a scheduler and its workers, and make the frames on them."""
    with cluster(WORKERS) as address:
        _weft(recipe, folder, "--cluster", address)


@contextmanager
def cluster(workers: int) -> Iterator[str]:
    """Yield the address of a Dask scheduler on this machine that has so many workers of one thread."""
    with tempfile.TemporaryDirectory(prefix="weft-dask-") as name:
        contact = Path(name) / "scheduler.json"
        file = ["--scheduler-file", str(contact), "--no-dashboard"]
        dask = [sys.executable, "-m", "dask"]
        commands = [[*dask, "scheduler", *file, "--host", "127.0.0.1", "--port", "0"]]
        commands += [[*dask, "worker", *file, "--nthreads", "1", "--local-directory", name] for _ in range(workers)]
        running = [subprocess.Popen(command, stdout=-3, stderr=-3) for command in commands]
        try:
            until = time.monotonic() + _START_S
            while not contact.is_file() or not contact.stat().st_size:
                if time.monotonic() > until:
                    raise WeftError("the Dask scheduler does not start")
                time.sleep(0.1)
            yield str(json.loads(contact.read_text())["address"])
        finally:
            for process in reversed(running):
                process.terminate()
            for process in running:
                process.wait()


def _by_template(recipe: Path, folder: Path) -> None:
    """Write a job template and have `openjd` run it."""
    template = recipe.with_name("job.json")
    _weft(recipe, folder, "--openjd", str(template))
    _run(["openjd", "run", str(template)])


def _in_shards(recipe: Path, folder: Path) -> None:
    """Have the commands of four shards printed, and run those of two shards at a time, one after another."""

    def run_shard(number: int) -> None:
        for line in _weft(recipe, folder, "--print-commands", "--shard", f"{number}/{_SHARDS}").splitlines():
            _run([*_WEFT, *shlex.split(line)[1:]])

    with ThreadPoolExecutor(WORKERS) as pool:
        list(pool.map(run_shard, range(1, _SHARDS + 1)))


WAYS = (
    Way("--jobs 1", 1, lambda recipe, folder: _with_jobs(recipe, folder, 1)),
    Way("--jobs 2", WORKERS, lambda recipe, folder: _with_jobs(recipe, folder, WORKERS)),
    Way("--cluster, 2 workers", WORKERS, _on_cluster, "distributed"),
    Way("openjd run", 1, _by_template, "openjd"),
    Way("--print-commands of 4 shards, two at a time", WORKERS, _in_shards),
)
"""The first is what the others are compared with."""
