"""What `weft warp` says of bad input, and that it leaves what was there."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from core.imaging.images import Image, load, save
from tests.app.commands.warp_scene import disc, refused, weft

pytestmark = pytest.mark.gpu


def test_what_cannot_be_read_is_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("text.png").write_text("no picture at all")
    Path("nothing.png").touch()
    Path("cut.png").write_bytes(Path("photo.png").read_bytes()[:200])
    for name, fault in {
        "none.png": "no such file or directory",
        "text.png": "not an image",
        "nothing.png": "the file is empty",
        "cut.png": "cut short",
        ".": "is a folder, not an image",
    }.items():
        assert refused(capsys, name).startswith(f"{name}: ")
        assert fault in refused(capsys, name)
    save(Image(disc()[:, 1:, None].copy()), "small.png")
    assert "small.png: the mask has 95x64 pixels, the image 96x64" in refused(
        capsys, "photo.png", "--mask", "small.png"
    )


def test_damaged_pictures_leave_one_line_each_and_nothing_at_exit(folder: Path) -> None:
    """The readers' own words do not reach the terminal, neither at once nor when the program ends."""
    for suffix in (".png", ".tif", ".exr", ".jpg", ".webp"):
        save(load("photo.png"), f"whole{suffix}")
        data = Path(f"whole{suffix}").read_bytes()
        Path(f"cut{suffix}").write_bytes(data[: len(data) // 2])
        Path(f"head{suffix}").write_bytes(data[:30])
        Path(f"text{suffix}").write_text("no picture at all")
    data = Path("photo.png").read_bytes()
    Path("crc.png").write_bytes(data[:-60] + bytes(30) + data[-30:])
    names = sorted(path.name for path in folder.iterdir() if path.stem in ("cut", "head", "text", "crc"))
    script = "import sys; from app.cli import main; [main(['warp', name, '-o', 'out.png']) for name in sys.argv[1:]]"
    done = subprocess.run(
        [sys.executable, "-c", script, *names],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])},
    )
    lines = done.stderr.splitlines()
    assert len(lines) == len(names) == 16
    for line, name in zip(lines, names, strict=True):
        assert line.startswith(f"weft: error: {name}: ")
        assert line.endswith("damaged or cut short")
    assert not Path("out.png").exists()


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (["--preset", "arcc"], "preset 'arcc': unknown; did you mean arc"),
        (["--preset", "arc", "--bend=120"], "bend 120: not from -100 to 100"),
        (["--preset", "arc", "--bend=nan"], "bend nan: not from -100 to 100"),
        (["--preset", "arc", "--set", "waves=2"], "preset arc: has no setting 'waves'"),
        (["--bend=50"], "choose one with --preset"),
        (["--cell", "0"], "grid cell of 0 px: must be positive"),
        (["--quality", "0"], "--quality 0: not from 1 to 100"),
        (["--size", "999999x10"], "output of 999999x10 pixels"),
        (["--weight", "inf"], "feature weight of inf: must be positive and at most 1e+06"),
        (["--falloff", "inf"], "falloff of inf cells: must not be negative, nor more than 1000"),
        (["--preset", "", "--bend=50"], "choose one with --preset"),
        (["--report", "out.png"], "out.png: two outputs go to the same file"),
        (["--map", "a", "--stmap", "a.exr", "--mesh", "a.obj", "--report", "a"], "a: two outputs go to the same file"),
        (["--report", "photo.png"], "photo.png: would be written over, but another option names it"),
        (["--mask", "mask.png", "--trace", "mask.png"], "mask.png: would be written over, but another option names it"),
        (["--map", "no/map.npz"], "no/map.npz: there is no folder"),
        (["--stmap", "st.png"], "st.png: an ST map is an .exr file"),
        (["--mesh", "mesh.ply"], "mesh.ply: a mesh is an .obj file"),
    ],
)
def test_what_cannot_be_is_named(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], fault: str
) -> None:
    assert fault in refused(capsys, "photo.png", *words)


@pytest.mark.parametrize(
    ("handles", "fault"),
    [
        ({"pins": [{"at": [200, 3], "to": [4, 4]}]}, "handles.json: pins[0]: lies outside the picture of 96x64 pixels"),
        ({"pins": [{"at": [20, 3], "to": [float("nan"), 4]}]}, "handles.json"),
    ],
)
def test_handles_that_cannot_be_are_named(
    folder: Path, capsys: pytest.CaptureFixture[str], handles: dict[str, Any], fault: str
) -> None:
    Path("handles.json").write_text(json.dumps(handles))
    assert fault in refused(capsys, "photo.png", "--handles", "handles.json")


def test_formats_that_cannot_be_written_are_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, fault in {"out.gif": "unknown picture format '.gif'", "no/out.png": "there is no folder"}.items():
        assert weft("photo.png", "-o", name) == 2
        assert f"weft: error: {name}: {fault}" in capsys.readouterr().err


def in_a_full_disk(command: str, **options: Any) -> "subprocess.CompletedProcess[str]":
    """Run `command` in a shell that may write files of 3 kB at most."""
    limited = f"ulimit -f 3; trap '' XFSZ; exec {command}"
    return subprocess.run(["bash", "-c", limited], capture_output=True, text=True, check=False, **options)


@pytest.mark.parametrize("suffix", [".png", ".tif", ".exr", ".jpg", ".webp"])
def test_a_file_that_may_not_grow_leaves_what_was_there(folder: Path, suffix: str) -> None:
    out = folder / f"out{suffix}"
    out.write_bytes(b"before")
    command = f"{sys.executable} -m app warp {folder}/photo.png -o {out}"
    done = in_a_full_disk(command, cwd=Path(__file__).parents[3])
    assert done.returncode == 2
    assert done.stderr == f"weft: error: {out}: file too large\n"
    assert out.read_bytes() == b"before"
    assert sorted(path.name for path in folder.iterdir()) == sorted(["mask.png", out.name, "photo.png"])


def test_a_full_disk_is_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("full.png").symlink_to("/dev/full")
    assert weft("photo.png", "-o", "full.png") == 2
    assert capsys.readouterr().err == "weft: error: full.png: no space left on device\n"
    assert Path("/dev/full").is_char_device()
