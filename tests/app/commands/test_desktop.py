"""`weft doctor` and `weft desktop`: what a machine has, and what a desktop is told."""

import configparser
import subprocess
import sys
import xml.etree.ElementTree as ET
from importlib import metadata
from pathlib import Path
from typing import NoReturn

import numpy as np
import platformdirs
import pytest

from app.cli import main
from app.commands import desktop, doctor
from app.render import gpu


@pytest.fixture
def data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(platformdirs, "user_data_path", lambda: tmp_path / "data")
    return tmp_path / "data"


def test_the_desktop_is_told_of_program_icon_and_files(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["desktop"]) == 0
    entry = configparser.ConfigParser(interpolation=None, delimiters="=")
    entry.optionxform = str  # type: ignore[assignment,method-assign]
    entry.read(data / "applications" / "weft.desktop")
    program, field = entry["Desktop Entry"]["Exec"].rsplit(" ", 1)
    assert (Path(program.strip('"')).name, field) == ("weft", "%f")
    assert "application/x-weft" in entry["Desktop Entry"]["MimeType"].split(";")
    kind = ET.parse(data / "mime" / "packages" / "weft.xml").getroot()[0]
    assert kind.get("type") == "application/x-weft"
    assert [child.get("pattern") for child in kind if child.get("pattern")] == ["*.weft"]
    assert ET.parse(data / "icons" / "hicolor" / "scalable" / "apps" / "weft.svg").getroot().tag.endswith("svg")
    assert len(capsys.readouterr().out.splitlines()) == 3
    assert main(["desktop", "--remove"]) == 0
    assert not list(data.glob("**/weft.*"))


def test_the_system_takes_the_file_type(data: Path) -> None:
    program = "/usr/bin/update-mime-database"
    if not Path(program).exists():
        pytest.skip("no update-mime-database")
    assert main(["desktop"]) == 0
    done = subprocess.run([program, str(data / "mime")], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "*.weft" in (data / "mime" / "globs2").read_text()


@pytest.mark.gpu
def test_doctor_says_versions_gpu_and_display(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "-o", str(tmp_path / "doctor.txt")]) == 0
    assert capsys.readouterr().out == ""
    lines = dict(line.split(": ", 1) for line in (tmp_path / "doctor.txt").read_text().splitlines() if ": " in line)
    assert lines["numpy"] == metadata.version("numpy") == np.__version__
    assert lines["GPU"].startswith(gpu.standalone().info["GL_RENDERER"])
    assert lines["driver"].startswith("OpenGL ")
    assert "ffv1" in lines["videos"]
    assert {"display", "system", "settings", "faults"} <= lines.keys()


def test_doctor_names_what_is_missing(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def refuse() -> NoReturn:
        raise OSError("no driver\nat all")

    monkeypatch.setattr(doctor, "_graphics", refuse)
    monkeypatch.setattr(doctor, "PACKAGES", ("numpy", "no-such-package"))
    assert main(["doctor"]) == 2
    said = capsys.readouterr()
    assert "OpenGL without a window: MISSING: no driver at all\n" in said.out
    assert "no-such-package: MISSING\n" in said.out
    assert said.err == "weft: error: missing: no-such-package, OpenGL without a window\n"


def test_a_name_with_spaces_is_quoted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.commands.desktop.shutil.which", lambda _: "/opt/my programs/weft")
    entry = desktop.contents(Path("weft"))["applications/weft.desktop"].decode()
    assert 'Exec="/opt/my programs/weft" %f\n' in entry
    assert sys.executable not in entry
