"""A short sequence with a mask, a recipe that bends it from frame to frame, and ways to make it."""

import hashlib
import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from app.batch.plan import Chunk, plan
from app.batch.recipe import read_recipe
from app.batch.records import Row
from app.batch.work import do_chunk
from core.arrays import Bytes
from core.imaging.images import Image, save

ROOT = Path(__file__).parents[3]
WIDTH, HEIGHT, FRAMES = 64, 48, 6
RECIPE = """\
picture = "plates/shot.####.png"
mask = "mask.png"
chunk = 2

[warp]
preset = "arc"

[keys]
bend = [{frame = 1, value = 0, easing = "ease"}, {frame = 6, value = 50}]
"""


def plate(frame: int, width: int = WIDTH, height: int = HEIGHT) -> Bytes:
    """Return a smooth picture whose colours say where a pixel comes from, and of which frame it is."""
    y, x = np.mgrid[0:height, 0:width]
    return np.stack([x * 255 / width, y * 255 / height, np.full_like(x, 20 * frame)], axis=-1).astype(np.uint8)


def write_scene(folder: Path, recipe: str = RECIPE, frames: int = FRAMES) -> Path:
    """Write plates, mask and recipe; return the recipe."""
    (folder / "plates").mkdir()
    for frame in range(1, frames + 1):
        save(Image(plate(frame)), folder / "plates" / f"shot.{frame:04d}.png")
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    disc = np.where(np.hypot(x - 30, y - 22) < 10, 255, 0).astype(np.uint8)
    save(Image(disc[..., None]), folder / "mask.png")
    return write_recipe(folder, recipe)


def write_recipe(folder: Path, text: str) -> Path:
    path = folder / "recipe.toml"
    path.write_text(text, encoding="utf-8")
    return path


def chunks_of(recipe: Path, output: Path, *, resume: bool = False, pictures: Sequence[str] = ()) -> list[Chunk]:
    return plan(read_recipe(recipe), output, resume=resume, pictures=pictures)


def make(recipe: Path, output: Path, *, resume: bool = False, pictures: Sequence[str] = ()) -> list[Row]:
    """Make all frames in this process; return what became of each."""
    chunks = chunks_of(recipe, output, resume=resume, pictures=pictures)
    return [row for chunk in chunks for row in do_chunk(chunk)]


def weft(*words: object, folder: Path) -> "subprocess.CompletedProcess[str]":
    """Run `weft batch` as a process of its own."""
    command = [sys.executable, "-m", "app", "batch", *map(str, words)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def bytes_of(folder: Path, ending: str = "png") -> dict[str, str]:
    """Return a digest of each picture of a folder; what a kill has left beside them is swept later."""
    files = sorted(folder.glob(f"[!.]*.{ending}"))
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in files}


def states(table: Path) -> list[str]:
    """Return what became of each frame, from a table."""
    return [row["state"] for row in json.loads(table.read_text())]
