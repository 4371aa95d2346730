"""Standard output that is full or closed, and what libraries would print: one line, and nothing else."""

import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest

from core.arrays import InputError
from core.imaging.images import Image, load, save

ROOT = Path(__file__).parents[3]
FULL = pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no full device")


def shell(command: str) -> subprocess.CompletedProcess[str]:
    """Run `command`, in which WEFT stands for the program."""
    text = command.replace("WEFT", f"{sys.executable} -m app")
    return subprocess.run(["sh", "-c", text], cwd=ROOT, capture_output=True, text=True, check=False)


@FULL
@pytest.mark.parametrize("words", ["presets", "presets --json", "--version", "--help", "warp --help"])
def test_a_full_output_is_said_in_one_line(words: str) -> None:
    done = shell(f"WEFT {words} >/dev/full")
    assert (done.returncode, done.stderr) == (2, "weft: error: standard output: no space left on device\n")


@pytest.mark.parametrize("words", ["presets", "--version"])
def test_a_closed_output_is_said_in_one_line(words: str) -> None:
    done = shell(f"WEFT {words} >&-")
    assert (done.returncode, done.stderr) == (2, "weft: error: standard output: is closed\n")


def test_who_says_nothing_needs_no_streams(tmp_path: Path) -> None:
    save(Image(np.full((20, 30, 3), 90, np.uint8)), tmp_path / "a.png")
    done = shell(f"WEFT warp {tmp_path}/a.png -o {tmp_path}/b.png >&- 2>&- <&-")
    assert done.returncode == 0
    assert load(tmp_path / "b.png").size_px == (30, 20)
    assert shell(f"WEFT warp {tmp_path}/none.png -o {tmp_path}/b.png >&- 2>&- <&-").returncode == 2


def test_a_reader_that_has_had_enough_is_no_fault() -> None:
    assert shell("WEFT presets | head -1").stderr == ""


def test_what_libpng_says_does_not_reach_the_terminal(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.png"
    save(Image(np.zeros((20, 30, 3), np.uint8)), path)
    good = path.read_bytes()
    body = b"IDAT" + zlib.compress(bytes(100))
    short = len(body[4:]).to_bytes(4, "big") + body + zlib.crc32(body).to_bytes(4, "big")
    path.write_bytes(good[: good.index(b"IDAT") - 4] + short + good[-12:])
    with pytest.raises(InputError, match="damaged or cut short"):
        load(path)
    assert capfd.readouterr() == ("", "")
