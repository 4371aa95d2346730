"""Kill the program while it writes, and look at what is left: `python -m tests.fuzz.kills [--count N] [--seed S]`.

Children write a project, a picture, a set of files or a folder of parts over an older one, again and again, and are
killed at a random moment. After each kill the next program comes to the folder. What was there must be whole: the older
or the newer one, of sets and folders all of the one or all of the other, and nothing beside it.
"""

import argparse
import os
import random
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import OpenImageIO

from core.arrays import InputError
from core.document.document import Document
from core.document.project import load_project, save_project
from core.files import litter
from core.files.atomic import AtomicFiles, atomic_folder
from core.files.journal import tidy
from core.imaging.images import Image, load, save
from tests.fuzz.readers import scratch

SIZE = (160, 120)
LONGEST_S = 0.03
MEMBERS = ("a.png", "b.txt", "c.bin")


def picture(number: int) -> Image:
    """Return a picture of one grey level, `number` modulo 256."""
    return Image(np.full((SIZE[1], SIZE[0], 3), number % 256, np.uint8))


def write_project(folder: Path, number: int) -> None:
    save_project(Document.of(picture(number)).with_warp(bend=float(number % 100)), folder / "a.weft")


def read_project(folder: Path) -> set[int]:
    document = load_project(folder / "a.weft")
    return {int(document.image.pixels.flat[0]) % 100, int(document.warp.bend)}


def write_picture(folder: Path, number: int) -> None:
    save(picture(number), folder / "a.tif")


def read_picture(folder: Path) -> set[int]:
    return set(np.unique(load(folder / "a.tif").pixels).tolist())


def _write_members(number: int, place: Callable[[str], Path]) -> None:
    save(picture(number), place("a.png"))
    place("b.txt").write_text(str(number % 256))
    place("c.bin").write_bytes(bytes([number % 256]) * 5000)


def read_members(folder: Path) -> set[int]:
    content = (folder / "c.bin").read_bytes()
    assert len(content) == 5000
    return {int(load(folder / "a.png").pixels.flat[0]), int((folder / "b.txt").read_text()), *content}


def write_set(folder: Path, number: int) -> None:
    with AtomicFiles() as files:
        for name in MEMBERS:
            with files.place(folder / name) as place:
                if name == "a.png":
                    save(picture(number), place)
                elif name == "b.txt":
                    place.write_text(str(number % 256))
                else:
                    place.write_bytes(bytes([number % 256]) * 5000)


def write_folder(folder: Path, number: int) -> None:
    with atomic_folder(folder / "parts") as parts:
        _write_members(number, lambda name: parts / name)


def read_folder(folder: Path) -> set[int]:
    return read_members(folder / "parts")


KINDS: dict[str, tuple[Callable[[Path, int], None], Callable[[Path], set[int]]]] = {
    "project": (write_project, read_project),
    "picture": (write_picture, read_picture),
    "set": (write_set, read_members),
    "folder": (write_folder, read_folder),
}


def kill_once(kind: str, folder: Path, draw: random.Random) -> None:
    """Let a child write into `folder` until it is killed; raise `AssertionError` for what is not whole then."""
    write, read = KINDS[kind]
    first = draw.randrange(100)
    child = os.fork()
    if child == 0:
        number = first
        while True:
            number = (number + 1) % 100
            write(folder, number)
    time.sleep(draw.random() * LONGEST_S)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    tidy(folder)
    assert len(read(folder)) == 1, f"{kind}: of several runs: {read(folder)}"
    left = [file.name for file in folder.iterdir() if file.name.startswith(".")]
    assert not left, f"{kind}: left behind: {left}"


def run(count: int, seed: int) -> int:
    """Kill `count` children and return how many of the kills did harm."""
    OpenImageIO.attribute("threads", 1)
    cv2.setNumThreads(0)
    litter.YOUNG_S = 0.0
    harm = 0
    with scratch() as name:
        draw = random.Random(seed)
        for kind in KINDS:
            folder = Path(name) / kind
            folder.mkdir()
            KINDS[kind][0](folder, 7)
            for _ in range(count // len(KINDS)):
                try:
                    kill_once(kind, folder, draw)
                except (AssertionError, InputError, OSError, ValueError) as fault:
                    harm += 1
                    sys.stdout.write(f"HARM {kind}: {fault}\n")
            sys.stdout.write(f"{kind:8s} {count // len(KINDS)} kills\n")
            sys.stdout.flush()
    return harm


def main() -> int:
    """Run from the command line; return 1 where a kill did harm."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    return 1 if run(arguments.count, arguments.seed) else 0


if __name__ == "__main__":
    sys.exit(main())
