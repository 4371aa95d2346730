"""The command line finds its commands and answers mistakes in one line."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.__main__ import main
from app.cli import parse
from core.files.atomic import atomic_file
from core.warps.presets import PRESETS


def test_presets_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["presets"]) == 0
    listed = capsys.readouterr().out
    assert all(f"  {name}\n" in listed for name in PRESETS)
    assert "--set waves=1" in listed


def test_presets_are_listed_for_scripts(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["presets", "--json"]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)}
    assert list(rows) == list(PRESETS)
    bend = rows["arc"]["parameters"][0]
    assert (bend["name"], bend["low"], bend["high"], bend["default"]) == ("bend", -100, 100, 0)
    assert rows["swirl"]["settings"] == ["center-x", "center-y", "radius"]


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (["presets", "--jso"], "unrecognized arguments: --jso"),
        (["warp", "a.png"], "the following arguments are required: -o/--output"),
        (["warp", "a.png", "-o"], "argument -o/--output: expected one argument"),
        (["warp", "a.png", "-o", "b.png", "--bend", "much"], "argument --bend: invalid float value: 'much'"),
        (["warp", "a.png", "-o", "b.png", "--keep", "all"], "argument --keep: invalid choice: 'all'"),
        (["warp", "a.png", "-o", "b.png", "--size", "10x"], "argument --size: '10x': not WIDTHxHEIGHT"),
        (["warp", "a.png", "-o", "b.png", "--set", "waves"], "argument --set: 'waves': not KEY=NUMBER"),
    ],
)
def test_mistakes_are_answered_in_one_line(words: list[str], fault: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == 2
    said = capsys.readouterr()
    assert said.err.startswith(f"weft: error: {fault}")
    assert said.err.count("\n") == 1
    assert not said.out


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["--version"])
    assert left.value.code == 0
    assert capsys.readouterr().out.startswith("weft ")


def test_an_interrupt_is_130(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted(_arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("app.commands.presets.run", interrupted)
    assert main(["presets"]) == 130
    assert capsys.readouterr().err == "weft: interrupted\n"


@pytest.fixture
def heeded() -> Iterator[None]:
    """Heed the signals that whoever runs the tests may have ignored, as `nohup` does."""
    before = [signal.signal(signal.SIGINT, signal.default_int_handler)]
    before += [signal.signal(number, signal.SIG_DFL) for number in (signal.SIGTERM, signal.SIGHUP)]
    yield
    for number, handler in zip((signal.SIGINT, signal.SIGTERM, signal.SIGHUP), before, strict=True):
        signal.signal(number, handler)


SWALLOWED = "import os, signal\ntry:\n    os.kill(os.getpid(), signal.SIGINT)\nexcept BaseException:\n    pass"


@pytest.mark.usefixtures("heeded")
@pytest.mark.parametrize(
    "place", ["def f():\n    raise KeyboardInterrupt\nf()", "exec('raise KeyboardInterrupt')", SWALLOWED]
)
def test_an_interrupt_while_loading_is_130(place: str, tmp_path: Path) -> None:
    (tmp_path / "numpy.py").write_text(place)
    done = subprocess.run(
        [sys.executable, "-m", "app", "presets"],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "weft: interrupted\n")


@pytest.mark.usefixtures("heeded")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_a_signal_leaves_nothing_half_done(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    number = signal.Signals[name]
    before = signal.getsignal(number)

    def working(_arguments: object) -> None:
        with atomic_file(tmp_path / "out.png") as place:
            place.write_text("half")
            signal.raise_signal(number)

    monkeypatch.setattr("app.commands.presets.run", working)
    assert main(["presets"]) == 128 + number
    assert not list(tmp_path.iterdir())
    assert signal.getsignal(number) is before


def test_a_reader_that_leaves_is_no_fault() -> None:
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-m", "app", "presets"], stdout=write, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(write)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_timeline_is_written_even_of_a_fault(tmp_path: Path) -> None:
    trace = tmp_path / "trace.json"
    words = ["warp", str(tmp_path / "none.png"), "-o", str(tmp_path / "out.png"), "--trace", str(trace)]
    assert main(words) == 2
    assert "traceEvents" in json.loads(trace.read_text())


def test_a_timeline_that_cannot_be_written_is_refused_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ran: list[object] = []
    monkeypatch.setattr("app.commands.presets.run", ran.append)
    assert main(["presets", "--trace", str(tmp_path / "no" / "trace.json")]) == 2
    assert not ran
    assert capsys.readouterr().err == (
        f"weft: error: {tmp_path / 'no' / 'trace.json'}: there is no folder {tmp_path / 'no'}\n"
    )


@pytest.mark.parametrize("value", ["-5", "-.5", "-1e1", "-0.5,0.25"])
def test_negative_values_are_no_options(value: str) -> None:
    _, options = parse(["overlay", "folder", "--texture", "t.png", "-o", "o.png", "--offset", value])
    assert options.offset == (float(value.split(",", maxsplit=1)[0]), float(value.rsplit(",", maxsplit=1)[-1]))
