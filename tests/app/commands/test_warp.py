"""`weft warp`, from files to files, and its answers to bad input."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest

from app.cli import main
from core.arrays import Bytes
from core.imaging.images import Attribute, Image, load, save

pytestmark = pytest.mark.gpu

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


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    save(Image(photograph()), "photo.png")
    save(Image(disc()[..., None]), "mask.png")
    return tmp_path


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


def test_no_warp_returns_the_picture(folder: Path) -> None:
    assert weft("photo.png", "-o", "out.png", "--map", "map.npz") == 0
    difference = load("out.png").pixels.astype(int) - photograph()
    assert np.abs(difference).max() <= 1
    found = arrays("map.npz")
    np.testing.assert_allclose(found["warped"], found["rest"], atol=1e-9)


def test_a_feature_keeps_its_shape(folder: Path) -> None:
    words = ("photo.png", "--mask", "mask.png", "--preset", "arc", "--bend=40", "-o", "out.png")
    also = ("--map", "map.npz", "--stmap", "st.exr", "--mesh", "mesh.obj")
    assert weft(*words, *also, "--report", "report.json") == 0
    report = json.loads(Path("report.json").read_text())
    assert report["features"][0]["residual"] < 1e-6
    assert report["folds"] == {"plain": 0, "warped": 0}
    assert set(report["seconds"]) == {"setup", "factor", "rhs", "solve", "unfold", "render"}
    found = arrays("map.npz")
    assert list(found["rest"].shape[:2]) == report["grid"]
    height, width = load("out.png").pixels.shape[:2]
    assert load("st.exr").pixels.shape[:2] == (height, width)
    vertices = np.loadtxt([line[2:] for line in Path("mesh.obj").read_text().splitlines() if line.startswith("v ")])
    np.testing.assert_allclose(vertices[:, 0], found["warped"][..., 0].ravel() + 0.5, atol=1e-5)
    np.testing.assert_allclose(height - vertices[:, 1], found["warped"][..., 1].ravel() + 0.5, atol=1e-5)


def test_an_outline_that_has_to_give_way_is_said(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    band = np.zeros((HEIGHT, WIDTH, 1), np.uint8)
    band[40:52] = 255
    save(Image(band), "band.png")
    words = ("photo.png", "--preset", "arc", "--bend=90", "--cell=3", "-o", "out.png", "--report", "report.json")
    for mask, gives_way in (("mask.png", False), ("band.png", True)):
        assert weft(*words, "--mask", mask) == 0
        report = json.loads(Path("report.json").read_text())
        assert report["folds"] == {"plain": 0, "warped": 0}
        assert ("outline_moved_px" in report) is gives_way
        said = capsys.readouterr().err
        assert said.startswith("weft: note: out.png: the outline gives way by up to ") is gives_way
        assert said.count("\n") == gives_way


def test_the_canvas_holds_the_whole_warp_or_the_frame(folder: Path) -> None:
    words = ("photo.png", "--preset", "arch", "--bend=100", "-o", "out.png", "--map", "map.npz")
    assert weft(*words) == 0
    found = arrays("map.npz")
    # The upper side rises by 3/4 of half the height: 24 rows, the lower side's corners stay.
    assert load("out.png").pixels.shape == (HEIGHT + 24, WIDTH, 4)
    np.testing.assert_allclose(found["warped"].min((0, 1)), [-0.5, -0.5], atol=0.05)
    np.testing.assert_array_equal(found["plain"], found["warped"])
    assert weft(*words, "--frame", "picture") == 0
    assert load("out.png").pixels.shape[:2] == (HEIGHT, WIDTH)
    np.testing.assert_allclose(arrays("map.npz")["warped"] + [0, 24], found["warped"], atol=1e-9)


def feature_report(*words: str) -> dict[str, Any]:
    assert weft("photo.png", "-o", "out.png", "--mask", "mask.png", "--report", "report.json", *words) == 0
    feature: dict[str, Any] = json.loads(Path("report.json").read_text())["features"][0]
    return feature


def test_what_is_kept_can_be_chosen(folder: Path) -> None:
    words = ("--preset", "arc", "--bend=40", "--size", "144x96")
    assert feature_report(*words)["scale"] > 1.3
    assert feature_report(*words, "--keep", "rigid")["scale"] == pytest.approx(1)
    assert feature_report(*words, "--keep", "none")["residual"] > 0.01
    assert 1e-6 < feature_report(*words, "--method", "per-quad")["residual"] < 0.1


def test_folds_go_unless_allowed(folder: Path) -> None:
    words = (
        "photo.png",
        "-o",
        "out.png",
        "--mask",
        "mask.png",
        "--preset",
        "twist",
        "--bend=100",
        "--report",
        "r.json",
    )
    assert weft(*words) == 0
    assert json.loads(Path("r.json").read_text())["folds"] == {"plain": 0, "warped": 0}
    assert json.loads(Path("r.json").read_text())["seconds"]["unfold"] > 0
    assert weft(*words, "--allow-folds") == 0
    assert json.loads(Path("r.json").read_text())["folds"]["warped"] > 0


def test_the_axis_can_be_turned(folder: Path) -> None:
    assert weft("photo.png", "-o", "out.png", "--preset", "arch", "--bend=100", "--vertical-axis") == 0
    assert load("out.png").pixels.shape[:2] == (HEIGHT, WIDTH + 36)


def test_another_size_stretches_all_but_the_feature(folder: Path) -> None:
    words = ("photo.png", "-o", "out.png", "--mask", "mask.png", "--size", "144x64", "--report", "report.json")
    assert weft(*words) == 0
    assert load("out.png").pixels.shape[:2] == (64, 144)
    feature = json.loads(Path("report.json").read_text())["features"][0]
    assert feature["residual"] < 1e-6
    assert abs(feature["angle_deg"]) < 1


def test_settings_of_a_preset_are_heard(folder: Path) -> None:
    words = ("photo.png", "-o", "out.png", "--preset", "stretch")
    assert weft(*words, "--set", "width=50", "--set", "height=200") == 0
    assert load("out.png").pixels.shape[:2] == (2 * HEIGHT, WIDTH // 2)


def test_handles_reach_their_targets(folder: Path) -> None:
    pins = [{"at": [30, 30], "to": [36, 34]}, {"at": [70, 40], "to": [66, 38]}]
    Path("handles.json").write_text(json.dumps({"pins": pins}))
    assert weft("photo.png", "-o", "out.png", "--handles", "handles.json", "--map", "map.npz", "--cell", "1") == 0
    found = arrays("map.npz")
    for pin in pins:
        nearest = np.argmin(((found["rest"] - pin["at"]) ** 2).sum(-1))
        np.testing.assert_allclose(found["plain"].reshape(-1, 2)[nearest], pin["to"], atol=1)
    np.testing.assert_allclose(found["plain"][0], found["rest"][0], atol=1e-9)


def test_the_outline_goes_where_it_is_told(folder: Path) -> None:
    sides = {
        "top": [[-0.5, -0.5], [31.5, -10.5], [63.5, -10.5], [95.5, -0.5]],
        "right": [[95.5, -0.5], [95.5, 20.5], [95.5, 42.5], [95.5, 63.5]],
        "bottom": [[95.5, 63.5], [63.5, 63.5], [31.5, 63.5], [-0.5, 63.5]],
        "left": [[-0.5, 63.5], [-0.5, 42.5], [-0.5, 20.5], [-0.5, -0.5]],
    }
    Path("handles.json").write_text(json.dumps({"outline": sides}))
    words = ("photo.png", "-o", "out.png", "--handles", "handles.json", "--map", "map.npz", "--frame", "picture")
    assert weft(*words) == 0
    top = arrays("map.npz")["warped"][0]
    assert top[:, 1].min() == pytest.approx(-8.0, abs=0.01)


@pytest.mark.parametrize(
    ("name", "pixels"), [("empty", disc(0)), ("full", disc(0) + 255), ("edge", np.roll(disc(), -40, 1))]
)
def test_every_mask_has_an_answer(folder: Path, name: str, pixels: Bytes) -> None:
    save(Image(np.ascontiguousarray(pixels)[..., None]), "other.png")
    words = ("photo.png", "-o", "out.png", "--mask", "other.png", "--preset", "flag", "--bend=30", "--report", "r.json")
    assert weft(*words) == 0
    features = json.loads(Path("r.json").read_text())["features"]
    assert (len(features) == 0) == (name == "empty")
    assert all(feature["residual"] < 1e-6 for feature in features)


def test_each_label_is_a_feature_and_what_touches_stays_two(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    labels = disc(1)
    labels[:, 40:][labels[:, 40:] > 0] = 2
    labels[5:15, 70:85] = 2
    save(Image(labels[..., None]), "labels.png")
    words = ("photo.png", "-o", "out.png", "--preset", "arc", "--bend=40", "--cell=4", "--report", "r.json")
    assert weft(*words, "--mask", "labels.png") == 0
    assert "labels.png: The mask holds 2 labels, each of them a feature." in capsys.readouterr().err
    report = json.loads(Path("r.json").read_text())
    assert [feature["id"] for feature in report["features"]] == [1, 2]
    assert max(feature["residual"] for feature in report["features"]) < 1e-6
    assert report["folds"]["warped"] == 0


def test_what_stands_out_is_kept_where_that_is_asked_for(folder: Path) -> None:
    pixels = np.full((HEIGHT, WIDTH, 3), 60, np.uint8)
    pixels[disc() > 0] = (220, 150, 60)
    save(Image(pixels), "disc.png")
    words = ("disc.png", "-o", "out.png", "--size", "48x64", "--report", "r.json")
    assert weft(*words, "--propose", "15") == 0
    report = json.loads(Path("r.json").read_text())
    assert len(report["features"]) == 1
    assert report["features"][0]["residual"] < 1e-6


def test_a_proposal_beside_a_mask_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "--propose" in refused(capsys, "photo.png", "--mask", "mask.png", "--propose", "20")
    assert "--propose" in refused(capsys, "photo.png", "--propose", "120")


@pytest.mark.parametrize("size", [(1, 1), (1, 5000), (5000, 1)])
def test_thin_pictures_are_warped(folder: Path, size: tuple[int, int]) -> None:
    save(Image(photograph(*size)), "thin.png")
    assert weft("thin.png", "-o", "out.png") == 0
    np.testing.assert_array_equal(load("out.png").pixels, photograph(*size))
    assert weft("thin.png", "-o", "out.png", "--preset", "arc-lower", "--bend=50") == 0


@pytest.mark.parametrize("suffix", [".tif", ".exr", ".webp", ".jpg"])
def test_every_format_is_written(folder: Path, suffix: str) -> None:
    assert weft("photo.png", "-o", f"out{suffix}", "--preset", "wave", "--bend=20") == 0
    assert load(f"out{suffix}").pixels.shape[:2] == (HEIGHT, WIDTH)


def test_depth_and_metadata_go_through(folder: Path) -> None:
    deep = photograph().astype(np.uint16) * 257
    save(Image(deep, metadata=(Attribute("Make", "string", "Weft"),)), "deep.png")
    assert weft("deep.png", "-o", "out.png") == 0
    found = load("out.png")
    assert found.pixels.dtype == np.uint16
    assert np.abs(found.pixels.astype(int) - deep).max() <= 2
    assert ("Make", "Weft") in [(entry.name, entry.value) for entry in found.metadata]


def test_the_same_words_give_the_same_bytes(folder: Path) -> None:
    words = ("photo.png", "--mask", "mask.png", "--preset", "twist", "--bend=60", "-o")
    assert weft(*words, "one.png") == weft(*words, "two.png") == 0
    assert Path("one.png").read_bytes() == Path("two.png").read_bytes()


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


def write_with(path: str, pixels: Any, **attributes: Any) -> None:
    """Write `pixels` with OpenImageIO itself; colons in names are written as double underscores."""
    kind = {"uint8": "uint8", "float32": "float"}[str(pixels.dtype)]
    spec = OpenImageIO.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    for name, value in attributes.items():
        spec.attribute(name.replace("__", ":"), value)
    buffer = OpenImageIO.ImageBuf(spec)
    buffer.set_pixels(spec.roi, pixels)
    assert buffer.write(path)


BEND = ("--preset", "rise", "--bend", "-40")


def test_numbers_that_are_none_do_not_spread(folder: Path) -> None:
    light = photograph().astype(np.float32) / 255
    light[20, 30] = np.nan
    write_with("light.exr", light)
    assert weft("light.exr", "-o", "out.exr", *BEND) == 0
    assert np.isfinite(load("out.exr").pixels).all()


def test_grey_palette_and_ink_become_pictures(folder: Path) -> None:
    save(Image(disc()[..., None]), "grey.png")
    write_with("palette.gif", photograph())
    write_with("ink.tif", np.concatenate([photograph(), disc(0)[..., None]], axis=2), tiff__ColorSpace="CMYK")
    for name, channels in {"grey.png": 2, "palette.gif": 4, "ink.tif": 4}.items():
        assert weft(name, "-o", "out.png", *BEND) == 0
        assert load("out.png").channels == channels


def test_orientation_is_resolved(folder: Path) -> None:
    write_with("turned.jpg", photograph(), Orientation=6)
    assert weft("turned.jpg", "-o", "out.png") == 0
    assert load("out.png").pixels.shape == (WIDTH, HEIGHT, 3)


def test_pins_are_reported_and_those_that_cannot_be_met_are_said(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ("photo.png", "-o", "out.png", "--handles", "handles.json", "--report", "report.json")
    pins = [{"at": [20, 30], "to": [24, 33]}, {"at": [70, 40], "to": [70, 40]}]
    for to, missed in (([24, 33], 0), ([5000, 33], 1)):
        pins[0]["to"] = to
        Path("handles.json").write_text(json.dumps({"pins": pins}))
        assert weft(*words) == 0
        found = json.loads(Path("report.json").read_text())
        assert found["folds"]["warped"] == 0
        assert [pin["to"] for pin in found["pins"]] == [to, [70, 40]]
        assert sum(pin["error_px"] > 0.1 for pin in found["pins"]) == missed
        assert np.hypot(*np.subtract(found["pins"][0]["reached"], to)) == pytest.approx(found["pins"][0]["error_px"])
        said = capsys.readouterr().err
        assert said.startswith("weft: note: out.png: 1 of 2 pins are not where they were dragged") is bool(missed)


def test_rings_are_met_and_reported(folder: Path) -> None:
    pins = [{"at": [48, 32], "to": [48, 32], "turn": 20, "scale": 1.2}, {"at": [20, 20], "to": [22, 20]}]
    Path("handles.json").write_text(json.dumps({"pins": pins}))
    words = ("photo.png", "-o", "out.png", "--handles", "handles.json", "--report", "report.json", "--cell", "1")
    assert weft(*words, "--keep", "none") == 0
    ringed, bare = json.loads(Path("report.json").read_text())["pins"]
    assert ringed["ring"]["turn_deg"] == pytest.approx(20)
    assert ringed["ring"]["reached_turn_deg"] == pytest.approx(20, abs=1e-3)
    assert ringed["ring"]["reached_scale"] == pytest.approx(1.2, abs=1e-4)
    assert ringed["ring"]["error_px"] < 0.01
    assert set(bare) == {"at", "to", "reached", "error_px"}
