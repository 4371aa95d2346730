"""The wheel: it holds every file that the program needs, and runs where there is nothing of the source tree."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from app.cli import main
from core.document.document import Document
from core.document.project import save_project
from core.imaging.images import load

pytestmark = [pytest.mark.gpu, pytest.mark.slow]
ROOT = Path(__file__).parents[3]
FOLDERS = ("app", "core", "shaders", "assets")
BUILD = "import sys; from setuptools.build_meta import build_wheel; build_wheel(sys.argv[1])"
CALL = "import sys; from importlib.metadata import distribution; from pathlib import Path; import app, core, shaders; \
place = Path(sys.argv.pop(1)); assert all(place in Path(room.__file__).parents for room in (app, core, shaders)); \
(weft,) = distribution('weft').entry_points.select(name='weft'); sys.exit(weft.load()())"


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the wheel from a copy of the tree, which stays as it is."""
    tree, place = tmp_path_factory.mktemp("tree"), tmp_path_factory.mktemp("dist")
    for name in FOLDERS:
        shutil.copytree(ROOT / name, tree / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, tree)
    subprocess.run([sys.executable, "-c", BUILD, str(place)], cwd=tree, capture_output=True, check=True)
    (found,) = place.glob("weft-*.whl")
    return found


def test_it_holds_every_file_of_the_program(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        held = set(archive.namelist())
    files = [path for name in FOLDERS for path in (ROOT / name).rglob("*") if path.is_file()]
    wanted = {path.relative_to(ROOT).as_posix() for path in files if "__pycache__" not in path.parts}
    assert {"shaders/mesh.vert", "assets/balloons.png", "app/py.typed"} <= wanted
    assert wanted - held == set()


def test_it_runs_outside_the_tree(wheel: Path, tmp_path: Path) -> None:
    site, here = tmp_path / "site", tmp_path / "here"
    here.mkdir()
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    picture = load(site / "assets" / "balloons.png")
    save_project(Document.of(picture).with_warp(preset="arc", bend=40.0), here / "a.weft")

    def weft(*words: str) -> str:
        command = [sys.executable, "-c", CALL, str(site), *words]
        environment = os.environ | {"PYTHONPATH": str(site)}
        done = subprocess.run(command, cwd=here, env=environment, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")
        return done.stdout

    assert weft("doctor").startswith("Weft ")
    weft("render", "a.weft", "-o", "a.png")
    assert main(["render", str(here / "a.weft"), "-o", str(here / "b.png")]) == 0
    assert (here / "a.png").read_bytes() == (here / "b.png").read_bytes()
    assert weft("batch", "a.weft", "--frames", "1-2", "-o", "f.#.png").startswith("2 frames: 2 done")
