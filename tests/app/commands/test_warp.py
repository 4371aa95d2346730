"""`weft warp`, from files to files, and its answers to bad input."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core.arrays import Bytes
from core.imaging.images import Image, load, save
from tests.app.commands.warp_scene import HEIGHT, WIDTH, arrays, disc, photograph, refused, weft

pytestmark = pytest.mark.gpu


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


def test_pins_are_reported_where_the_result_has_them(folder: Path) -> None:
    Path("handles.json").write_text(json.dumps({"pins": [{"at": [60, 40], "to": [62, 20]}]}))
    words = ("photo.png", "--preset", "arch", "--bend=100", "--handles", "handles.json", "--cell=1")
    assert weft(*words, "-o", "out.png", "--map", "map.npz", "--report", "r.json") == 0
    pin = json.loads(Path("r.json").read_text())["pins"][0]
    found = arrays("map.npz")
    nearest = np.argmin(((found["rest"] - [60, 40]) ** 2).sum(-1))
    np.testing.assert_allclose(found["warped"].reshape(-1, 2)[nearest], pin["reached"], atol=1.5)
    np.testing.assert_allclose(pin["to"], pin["reached"], atol=0.1)
    assert pin["reached"][1] - 20 > 20  # the canvas begins above the picture


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
        assert said.startswith("weft: note: out.png: pins that are missed: 1 of 2, by up to ") is bool(missed)


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
