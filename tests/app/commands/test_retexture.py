"""`weft retexture`: what it writes, and what it says of bad input."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.cli import main
from core.document.document import Document
from core.document.retexture import settings_of
from core.imaging.images import Image, load, save
from core.retexture.job import Settings
from core.retexture.synthesis.patches import PatchShape
from tests.core.retexture.retexture_scenes import HEIGHT, WIDTH, bent, data_of, stripes


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("retexture")
    save(Image(stripes()), folder / "image.png")
    (folder / "curves.json").write_text(json.dumps(data_of(bent())))
    return folder


def command(scene: Path, *options: str | Path) -> int:
    return main(["retexture", *map(str, (scene / "image.png", "--curves", scene / "curves.json", *options))])


def test_every_output_is_written(scene: Path, tmp_path: Path) -> None:
    out, plain, report = tmp_path / "out.png", tmp_path / "plain.tif", tmp_path / "report.json"
    assert command(scene, "-o", out, "--deformed", plain, "--report", report, "--seed", "3") == 0
    found = json.loads(report.read_text())
    assert found["size"] == [HEIGHT, WIDTH]
    assert found["seed"] == 3
    assert found["patches"] > 20
    assert found["candidates"] > 100 * found["patches"]
    assert set(found["seconds"]) == {"diffuse", "coordinates", "search", "seams", "blend", "total"}
    assert load(out).pixels.shape == load(plain).pixels.shape == (HEIGHT, WIDTH, 3)
    assert (load(out).pixels != load(plain).pixels).any()


def test_without_options_a_document_asks_for_the_same() -> None:
    image = Image(stripes())
    assert settings_of(Document.of(image)) == Settings(patch=PatchShape.for_picture(HEIGHT, WIDTH))


def test_same_seed_same_file(scene: Path, tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        assert command(scene, "-o", tmp_path / name, "--seed", "7") == 0
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_layers_are_carried_along(scene: Path, tmp_path: Path) -> None:
    height = np.arange(WIDTH, dtype=np.uint16)[None, :, None] * np.ones((HEIGHT, 1, 1), np.uint16) * 256
    save(Image(height), tmp_path / "height.png")
    save(Image(stripes()), tmp_path / "copy.png")
    outs = [tmp_path / name for name in ("out.png", "height-out.png", "copy-out.png")]
    also: list[str | Path] = [
        "--also",
        tmp_path / "height.png",
        "-o",
        outs[1],
        "--also",
        tmp_path / "copy.png",
        "-o",
        outs[2],
    ]
    assert command(scene, "-o", outs[0], *also) == 0
    result, layer, copy = (load(out).pixels for out in outs)
    assert layer.dtype == np.uint16
    assert layer.shape == (HEIGHT, WIDTH, 1)
    # The copy is resampled as numbers rather than as light: the same but for the transfer function.
    assert np.abs(result.astype(float) - copy).mean() < 3


def test_a_bench_of_options(scene: Path, tmp_path: Path) -> None:
    mask = np.full((HEIGHT, WIDTH, 1), 255, np.uint8)
    save(Image(mask), tmp_path / "mask.png")
    options = ["--patch", "31x17", "--search", "11x11", "--reach", "50", "--move-within", "120", "--mirror"]
    masks: list[str | Path] = ["--matte", tmp_path / "mask.png", "--source-mask", tmp_path / "mask.png"]
    assert command(scene, "-o", tmp_path / "out.png", *options, *masks) == 0


def test_where_the_regrow_picture_is_black_the_plain_deformation_stands(scene: Path, tmp_path: Path) -> None:
    save(Image(np.zeros((HEIGHT, WIDTH, 1), np.uint8)), tmp_path / "black.png")
    save(Image(np.full((HEIGHT, WIDTH, 1), 255, np.uint8)), tmp_path / "white.png")
    report = tmp_path / "report.json"
    for name, regrown in (("black.png", False), ("white.png", True)):
        masks: list[str | Path] = ["--regrow", tmp_path / name, "--report", report]
        plain = tmp_path / "plain.png"
        assert command(scene, "-o", tmp_path / "out.png", "--deformed", plain, *masks) == 0
        far = np.abs(load(tmp_path / "out.png").pixels.astype(int) - load(plain).pixels).max(axis=-1)
        assert bool((far > 0).any()) is regrown


LINE = [[5, 100], [60, 100], [150, 100], [210, 100]]


@pytest.mark.parametrize(
    ("curves", "words"),
    [
        ("{", "not a JSON file"),
        ("{}", 'no list "curves"'),
        ('{"curves": []}', "no curve has a target"),
        ({"curves": [{"source": LINE}]}, 'curve 1: has no "target"'),
        ({"curves": [{"source": [[1, 1]], "target": LINE}]}, "3k + 1 control points"),
        ('{"curves": [{"source": [[NaN, 1], [2, 2], [3, 3], [4, 4]], "target": [[1, 1]]}]}', "NaN"),
        ({"curves": [{"source": LINE, "target": [[x, y + 500] for x, y in LINE]}]}, "outside the picture"),
        ({"curves": [{"source": [[9, 9]] * 4, "target": LINE}]}, "coincide"),
        ({"curves": [{"source": [*LINE[:3], [10**400, 9]], "target": LINE}]}, "holds NaN or infinity"),
    ],
)
def test_bad_curves_touch_no_output(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], curves: Any, words: str
) -> None:
    path, out = tmp_path / "bad.json", tmp_path / "out.png"
    path.write_text(curves if isinstance(curves, str) else json.dumps(curves))
    out.write_bytes(b"kept")
    status = main(["retexture", str(scene / "image.png"), "--curves", str(path), "-o", str(out)])
    said = capsys.readouterr().err
    assert status == 2
    assert said.startswith("weft: error: ")
    assert "bad.json" in said
    assert words in said
    assert said.count("\n") == 1
    assert out.read_bytes() == b"kept"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["-o", "out.gif"], "out.gif: unknown picture format"),
        (["-o", "out.png", "--also", "layer.png"], "1 --also need 2 -o, not 1"),
        (["-o", "out.png", "-o", "more.png"], "0 --also need 1 -o, not 2"),
        (["-o", "out.png", "--deformed", "out.png"], "same file"),
        (["-o", "out.png", "--report", "out.png"], "out.png: two outputs go to the same file"),
        (["-o", "out.png", "--trace", "out.png"], "out.png: would be written over, but another option names it"),
        (["-o", "black.png", "--matte", "black.png"], "black.png: would be written over, but another option names it"),
        (["-o", "black.png", "--also", "black.png", "-o", "more.png"], "black.png: would be written over, but"),
        (["-o", "no/out.png"], "there is no folder"),
        (["-o", "out.png", "--report", "no/report.json"], "no/report.json: there is no folder"),
        (["-o", "out.png", "--matte", "black.png"], "black.png: the mask marks nothing"),
        (["-o", "out.png", "--regrow", "grey.png"], "grey.png: the mask marks nothing"),
        (["-o", "out.png", "--source-mask", "small.png"], "small.png: the mask has 9x9 pixels"),
        (["-o", "out.png", "--also", "small.png", "-o", "more.png"], "small.png: has 9x9 pixels"),
        (["-o", "out.png", "--patch", "7"], "ALONGxACROSS"),
        (["-o", "out.png", "--search", "999x1"], "--search takes up to"),
        (["-o", "out.png", "--reach", "nan"], "not a length in pixels"),
        (["-o", "out.png", "--seed", "-1"], "must not be negative"),
        ([], "-o"),
    ],
)
def test_bad_options_touch_no_output(
    scene: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    options: list[str],
    words: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    save(Image(np.zeros((HEIGHT, WIDTH, 1), np.uint8)), "black.png")
    save(Image(np.full((9, 9, 1), 255, np.uint8)), "small.png")
    save(Image(np.full((HEIGHT, WIDTH, 1), 127, np.uint8)), "grey.png")
    (tmp_path / "out.png").write_bytes(b"kept")
    assert command(scene, *options) == 2
    said = capsys.readouterr().err
    assert words in said
    assert "curves.json" not in said
    assert said.count("\n") == 1
    assert (tmp_path / "out.png").read_bytes() == b"kept"
    assert not (tmp_path / "more.png").exists()
    assert load("black.png").pixels.shape == (HEIGHT, WIDTH, 1)


def test_of_several_outputs_all_are_written_or_none(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    save(Image(np.zeros((HEIGHT, WIDTH, 1), np.uint8)), "layer.png")
    Path("small.png").write_bytes(b"kept")
    Path("full.png").symlink_to("/dev/full")
    options = ["--also", "layer.png", "-o", "small.png", "-o", "full.png", "--report", "report.json"]
    assert command(scene, *options) == 2
    assert capsys.readouterr().err == "weft: error: full.png: no space left on device\n"
    assert Path("small.png").read_bytes() == b"kept"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["full.png", "layer.png", "small.png"]


def test_a_picture_that_is_none_is_named(scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = [
        "retexture",
        str(tmp_path / "no.png"),
        "--curves",
        str(scene / "curves.json"),
        "-o",
        str(tmp_path / "o.png"),
    ]
    assert main(words) == 2
    assert "no.png: no such file" in capsys.readouterr().err


def test_a_curve_beside_an_edge_is_moved_onto_it_and_that_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pixels = np.full((HEIGHT, WIDTH, 3), 200, np.uint8)
    pixels[HEIGHT // 2 :] = 40
    save(Image(pixels), tmp_path / "image.png")
    y = HEIGHT / 2 + 6
    line = [[20.0, y], [WIDTH / 3, y], [WIDTH / 1.5, y], [WIDTH - 20.0, y]]
    curves = {"curves": [{"source": line, "target": [[x, y - 15] for x, _ in line]}]}
    (tmp_path / "curves.json").write_text(json.dumps(curves))
    asked = ["retexture", tmp_path / "image.png", "--curves", tmp_path / "curves.json", "-o"]
    assert main([*map(str, (*asked, tmp_path / "snapped.png"))]) == 0
    assert "curve 1: moved onto the edge beside it, by up to 7 px" in capsys.readouterr().err
    assert main([*map(str, (*asked, tmp_path / "drawn.png", "--no-snap"))]) == 0
    assert "moved onto" not in capsys.readouterr().err
    # The edge itself goes to where the curve went.
    snapped = load(tmp_path / "snapped.png").pixels[:, WIDTH // 2, 0]
    assert abs(int((snapped > 120).sum()) - (HEIGHT // 2 - 15)) <= 1


def test_long_edges_can_be_left_alone(scene: Path, tmp_path: Path) -> None:
    for name, options in (("with.png", []), ("without.png", ["--no-edges"])):
        assert command(scene, "-o", tmp_path / name, *options) == 0
        assert load(tmp_path / name).pixels.shape == (HEIGHT, WIDTH, 3)
