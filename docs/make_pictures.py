"""Draw the README's pictures anew, with this version: `make pictures`. Needs a display, or xvfb-run."""

import tempfile
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from app.cli import main as run
from app.editor.editor import Editor
from app.model.jobs import Jobs
from app.tools.all import TOOLS
from app.tours.samples import warp_sample
from core.imaging.images import Image, load, save
from tests.gui.window_driver import WindowDriver, drive

HERE = Path(__file__).parent
ASSETS = HERE.parent / "assets"
WIDTH_PX, EDITOR_WIDTH_PX = 560, 1280
THUMBNAIL_FRAMES = 300
"""After so many frames all pictures of warps are drawn."""


def main() -> None:
    """Draw them all."""
    show_editor()
    with tempfile.TemporaryDirectory() as folder:
        draw(Path(folder))


def draw(folder: Path) -> None:
    """Draw the pairs of before and after."""
    arch = "warp", ASSETS / "balloons.png", "--preset", "arch", "--bend", "50"
    fox, curves = ASSETS / "fox_tail.png", ASSETS / "fox_tail_curves.json"
    cloth, parts = ASSETS / "folded_print.png", folder / "parts"
    weft(*arch, "-o", folder / "plain.png")
    weft(*arch, "-o", folder / "kept.png", "--mask", ASSETS / "balloons_mask.png")
    weft(
        "retexture",
        fox,
        "--curves",
        curves,
        "-o",
        folder / "fox_retextured.png",
        "--deformed",
        folder / "fox_deformed.png",
    )
    weft("decompose", cloth, "-o", parts)
    weft(
        "overlay", parts, "--texture", ASSETS / "balloons.png", "--repeat", "0.2,0.25", "-o", folder / "cloth_after.png"
    )
    save(load(cloth), folder / "cloth_before.png")
    for path in folder.glob("*.png"):
        save(shrunk(load(path), WIDTH_PX), HERE / f"{path.stem}.jpg", quality=88)


def show_editor() -> None:
    """Draw the window, the sample under an arch in it."""
    document = warp_sample()
    bent = document.changed(warp=replace(document.warp, preset="arch", bend=50.0))
    editor = Editor(document, TOOLS, jobs=Jobs())

    def script(window: WindowDriver) -> None:
        window.wait(THUMBNAIL_FRAMES)
        editor.edit("Arch", bent)
        window.wait(20)
        window.shell.workspace.table.run("view.fit", editor)
        with tempfile.TemporaryDirectory() as folder:
            pixels = window.screenshot(Path(folder) / "window.png")
        save(shrunk(Image(pixels.copy()), EDITOR_WIDTH_PX), HERE / "editor.jpg", quality=90)

    drive(editor, script)


def shrunk(picture: Image, width_px: int) -> Image:
    """Return an 8-bit picture at another width."""
    size = width_px, round(width_px * picture.height_px / picture.width_px)
    return Image(np.asarray(cv2.resize(picture.pixels, size, interpolation=cv2.INTER_AREA), np.uint8))


def weft(*words: str | Path) -> None:
    """Run a command of the program."""
    status = run([str(word) for word in words])
    if status:
        raise SystemExit(status)


if __name__ == "__main__":
    main()
