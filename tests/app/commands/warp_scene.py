"""A picture and a mask for `weft warp`, and how it is run."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.cli import main
from core.arrays import Bytes

WIDTH, HEIGHT = 96, 64


def photograph(width: int = WIDTH, height: int = HEIGHT) -> Bytes:
    """Return a smooth picture whose colours say where a pixel comes from."""
    y, x = np.mgrid[0:height, 0:width]
    colors = x * 255 / width, y * 255 / height, 128 + 60 * np.sin(x / 9)
    return np.stack(colors, axis=-1).astype(np.uint8)


def disc(value: int = 255) -> Bytes:
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    inside: Bytes = np.where(np.hypot(x - 40, y - 30) < 15, value, 0).astype(np.uint8)
    return inside


def weft(*words: str) -> int:
    return main(["warp", *words])


def arrays(path: str) -> dict[str, Any]:
    with np.load(path, allow_pickle=False) as found:
        return dict(found)


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Run what must fail; return its one line, and see that no output was touched."""
    Path("out.png").write_bytes(b"before")
    assert weft(*words, "-o", "out.png") == 2
    said = capsys.readouterr().err
    assert said.startswith("weft: error: ")
    assert said.count("\n") == 1
    assert Path("out.png").read_bytes() == b"before"
    assert not [path for path in Path().iterdir() if path.name.startswith(".")]
    return said.removeprefix("weft: error: ").strip()
