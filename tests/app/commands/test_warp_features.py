"""`weft warp --feature`: features of one mask, each kept in its own way."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core.imaging.images import Image, save
from tests.app.commands.warp_scene import HEIGHT, WIDTH, arrays, refused, weft

pytestmark = pytest.mark.gpu
WORDS = ("photo.png", "--mask", "two.png", "--preset", "arc", "--bend=60", "-o", "out.png", "--report", "report.json")


@pytest.fixture
def two(folder: Path) -> None:
    mask = np.zeros((HEIGHT, WIDTH, 1), np.uint8)
    mask[15:35, 10:30] = mask[30:50, 60:85] = 255
    save(Image(mask), "two.png")
    save(Image(np.where(mask > 0, 1 + (np.arange(WIDTH) > 50)[None, :, None], 0).astype(np.uint8)), "labels.png")


def warp(*words: str) -> dict[int, Any]:
    assert weft(*WORDS, *words) == 0
    report = json.loads(Path("report.json").read_text())
    assert max(feature["residual"] for feature in report["features"]) < 1e-6
    return {feature["id"]: feature for feature in report["features"]}


@pytest.mark.usefixtures("two")
@pytest.mark.parametrize("mask", ["two.png", "labels.png"])
def test_each_feature_is_kept_as_it_says(mask: str) -> None:
    plain = warp("--mask", mask)
    assert plain[1]["scale"] < 0.95
    assert abs(plain[1]["angle_deg"]) > 5
    found = warp("--mask", mask, "--feature", "1=rigid,upright", "--feature", "2=most:0.6")
    assert (found[1]["scale"], found[1]["angle_deg"]) == pytest.approx((1, 0), abs=1e-9)
    assert found[2]["scale"] == pytest.approx(0.6, abs=1e-9)
    assert warp("--mask", mask, "--keep", "rigid", "--feature=2=similarity")[2]["scale"] < 0.95
    assert set(warp("--mask", mask, "--feature", "1=none")) == {2}
    assert set(warp("--mask", mask, "--feature", "1=weight:0")) == {2}


@pytest.mark.usefixtures("two")
def test_a_soft_feature_keeps_some_of_its_shape() -> None:
    left = []
    for weight in ("0.2", "0.8", "1"):
        assert weft(*WORDS, "--feature", f"1=weight:{weight}") == 0
        features = json.loads(Path("report.json").read_text())["features"]
        left.append(features[0]["residual"])
        assert features[1]["residual"] < 1e-6
    assert left[0] > 2 * left[1] > 1e-3
    assert left[2] < 1e-6


@pytest.mark.usefixtures("two")
def test_what_cannot_be_said_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("photo.png", "--mask", "two.png")
    assert "feature 3: the mask has none of that number" in refused(capsys, *words, "--feature", "3=rigid")
    for said, fault in (
        ("1=line", "'line' is no way"),
        ("1=wobbly", "'wobbly' is no way"),
        ("x=rigid", "'x' is no number of a feature"),
        ("1=least:2,most:1", "size of"),
        ("1=weight:2", "protection of"),
    ):
        assert fault in refused(capsys, *words, "--feature", said)


def bend_of(row_px: float, columns: slice = slice(None)) -> float:
    """Return how far what was a row of the picture is from straight in map.npz, in pixels."""
    found = arrays("map.npz")
    row = np.abs(found["rest"][:, 0, 1] - row_px).argmin()
    line = found["warped"][row, columns]
    return float(np.abs(line[:, 1] - np.polyval(np.polyfit(line[:, 0], line[:, 1], 1), line[:, 0])).max())


def test_a_feature_of_which_only_lines_are_kept_bends_between_them(folder: Path) -> None:
    pixels = np.full((HEIGHT, WIDTH, 3), 200, np.uint8)
    pixels[20:44, 10:90] = 60
    save(Image(pixels), "sill.png")
    mask = np.zeros((HEIGHT, WIDTH, 1), np.uint8)
    mask[30:52, 10:90] = 255
    save(Image(mask), "wall.png")
    words = ("sill.png", "--mask", "wall.png", "--preset", "arch", "--bend=30", "--cell=2")
    files = "-o", "out.png", "--map", "map.npz", "--report", "report.json"
    bends = []
    for how in ("none", "lines"):
        assert weft(*words, *files, "--feature", f"1={how}") == 0
        assert json.loads(Path("report.json").read_text())["features"] == []
        rest = arrays("map.npz")["rest"][0, :, 0]
        inside = slice(int((rest < 14).sum()), int((rest < 86).sum()))
        bends.append([bend_of(43.5, inside), bend_of(19.5, inside)])
    assert bends[1][0] < 0.3 * bends[0][0]
    assert bends[1][1] > 0.4 * bends[0][1]


def test_a_horizon_stays_straight(folder: Path) -> None:
    pixels = np.full((HEIGHT, WIDTH, 3), 200, np.uint8)
    pixels[56:] = 60
    save(Image(pixels), "sea.png")
    words = ("sea.png", "--mask", "mask.png", "--size", "58x64", "--cell=2", "-o", "out.png", "--map", "map.npz")
    bends = []
    for straight in ((), ("--straight",)):
        assert weft(*words, *straight) == 0
        bends.append(bend_of(55.5))
    assert bends[0] > 0.5
    assert bends[1] < 0.4 * bends[0]
