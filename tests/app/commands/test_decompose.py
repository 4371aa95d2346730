"""`weft decompose`, from a photo to its parts, and its answers to bad input."""

import errno
import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from app.cli import main
from core.imaging.images import Image, load, save
from core.overlay.composition import finite
from core.overlay.storage.folder import read
from tests.app.commands.test_overlay import failing
from tests.core.overlay.overlay_scenes import make_scene, motif, stored


def test_the_whole_cloth_is_taken_in(photo: Path, tmp_path: Path) -> None:
    cloth = load(photo).pixels
    height, width = cloth.shape[:2]
    ground = np.random.default_rng(2).normal((60, 75, 90), 3, (height + 60, width + 60, 3))
    ground[30:-30, 30:-30] = cloth
    save(Image(np.clip(ground, 0, 255).astype(np.uint8)), tmp_path / "table.png")
    known = np.zeros(ground.shape[:2])
    known[40 : 40 + height // 2, 40:-40] = 1.0
    save(stored(known[..., None]), tmp_path / "known.png")
    words = ["decompose", str(tmp_path / "table.png"), "--region", str(tmp_path / "known.png"), "-o"]
    assert main([*words, str(tmp_path / "part")]) == 0
    assert main([*words, str(tmp_path / "whole"), "--whole-cloth"]) == 0
    part, whole = (finite(read(tmp_path / name).uv) for name in ("part", "whole"))
    assert part.sum() < 0.6 * height * width
    assert whole[30:-30, 30:-30].mean() > 0.9
    whole[30:-30, 30:-30] = False
    assert whole.sum() < 0.03 * height * width


def test_a_missing_photo_is_named_and_nothing_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = failing(capsys, "decompose", tmp_path / "none.png", "-o", tmp_path / "parts")
    assert "none.png" in line
    assert list(tmp_path.iterdir()) == []


def test_a_picture_without_repeats_is_refused_and_leaves_the_folder(
    parts: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save(stored(np.random.default_rng(0).random((90, 110, 3))), tmp_path / "noise.png")
    before = {file.name: file.read_bytes() for file in parts.iterdir()}
    line = failing(capsys, "decompose", tmp_path / "noise.png", "-o", parts)
    assert line == f"weft: error: no repeating texture found in {tmp_path / 'noise.png'}"
    assert {file.name: file.read_bytes() for file in parts.iterdir()} == before


def test_an_empty_or_wrong_mask_is_named(photo: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    size = load(photo).pixels.shape[:2]
    save(stored(np.zeros((*size, 1))), tmp_path / "empty.png")
    save(stored(np.ones((5, 5, 1))), tmp_path / "small.png")
    for name in ("empty.png", "small.png"):
        line = failing(capsys, "decompose", photo, "-o", tmp_path / "parts", "--region", tmp_path / name)
        assert name in line
    assert not (tmp_path / "parts").exists()


def test_a_corrected_lattice_gives_the_same_texel(photo: Path, parts: Path, tmp_path: Path) -> None:
    lattice = json.loads((parts / "lattice.json").read_text())
    lattice["vertices"].pop(7)
    lattice["vertices"][4]["at"][0] += 1.5
    (tmp_path / "lattice.json").write_text(json.dumps(lattice))
    again = tmp_path / "again"
    assert main(["decompose", str(photo), "-o", str(again), "--lattice", str(tmp_path / "lattice.json")]) == 0
    old, new = (json.loads((place / "report.json").read_text()) for place in (parts, again))
    assert new["texel_size"] == pytest.approx(old["texel_size"], rel=0.06)
    assert new["coverage"] > 0.9


@pytest.mark.parametrize(
    "text",
    ["{", "[]", '{"vertices": [{"lattice": [0, 0]}]}', '{"vertices": [{"lattice": [0.5, 0], "at": [1, 2]}]}',
     '{"vertices": []}', '{"vertices": [{"lattice": [0, 0], "at": [1, NaN]}]}', "[" * 100_000,
     '{"vertices": [{"lattice": [0, Infinity], "at": [1, 2]}]}', '{"vertices": [{"lattice": [0, 1e9], "at": [1, 2]}]}',
     '{"vertices": [{"lattice": [0, 0], "at": [1, 1' + "0" * 400 + "]}]}"],
)  # fmt: skip
def test_a_broken_lattice_is_named(text: str, photo: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "lattice.json").write_text(text)
    line = failing(capsys, "decompose", photo, "-o", tmp_path / "parts", "--lattice", tmp_path / "lattice.json")
    assert "lattice.json" in line
    assert not (tmp_path / "parts").exists()


def test_a_doubled_vertex_is_named(
    photo: Path, parts: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lattice = json.loads((parts / "lattice.json").read_text())
    lattice["vertices"].append(lattice["vertices"][0])
    (tmp_path / "lattice.json").write_text(json.dumps(lattice))
    line = failing(capsys, "decompose", photo, "-o", tmp_path / "parts", "--lattice", tmp_path / "lattice.json")
    assert "twice" in line


@pytest.mark.parametrize(
    ("moved", "fault"),
    [
        (lambda _x, _y: [5, 5], "on one spot or in one line"),
        (lambda x, _y: [x, 5], "on one spot or in one line"),
        (lambda x, y: [x + 5000, y], "none of its vertices lies in the picture"),
    ],
)
def test_a_lattice_that_cannot_be_the_cloths_is_named(
    moved: Callable[[float, float], list[float]],
    fault: str,
    photo: Path,
    parts: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    lattice = json.loads((parts / "lattice.json").read_text())
    for vertex in lattice["vertices"]:
        vertex["at"] = moved(*vertex["at"])
    (tmp_path / "lattice.json").write_text(json.dumps(lattice))
    line = failing(capsys, "decompose", photo, "-o", tmp_path / "parts", "--lattice", tmp_path / "lattice.json")
    assert "lattice.json" in line
    assert fault in line


@pytest.mark.parametrize("contrast", [0.0, 0.02, 1.0])
def test_a_lattice_on_a_photo_without_its_pattern_is_refused(
    contrast: float, photo: Path, parts: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    noise = np.random.default_rng(3).random((*load(photo).pixels.shape[:2], 3))
    save(stored(0.5 + contrast * (noise - 0.5)), tmp_path / "plain.png")
    words = ["-o", tmp_path / "parts", "--lattice", parts / "lattice.json"]
    line = failing(capsys, "decompose", tmp_path / "plain.png", *words)
    assert line.endswith(f"no repeating texture found in {tmp_path / 'plain.png'} along {parts / 'lattice.json'}")
    assert not (tmp_path / "parts").exists()


def test_a_lattice_beside_the_region_is_refused(
    photo: Path, parts: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lattice = json.loads((parts / "lattice.json").read_text())
    lattice["vertices"] = [vertex for vertex in lattice["vertices"] if min(vertex["at"]) > 60]
    (tmp_path / "lattice.json").write_text(json.dumps(lattice))
    corner = np.zeros((*load(photo).pixels.shape[:2], 1))
    corner[:10, :10] = 1.0
    save(stored(corner), tmp_path / "corner.png")
    words = ["--lattice", tmp_path / "lattice.json", "--region", tmp_path / "corner.png"]
    assert "no repeating texture found" in failing(capsys, "decompose", photo, "-o", tmp_path / "parts", *words)


def test_a_stage_that_cannot_be_written_is_named(
    photo: Path, parts: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("app.commands.decompose.write_picture", full)
    words = ["--lattice", parts / "lattice.json", "--stages", tmp_path / "stages"]
    line = failing(capsys, "decompose", photo, "-o", tmp_path / "parts", *words)
    assert f"{tmp_path / 'stages'}: no space left on device" in line
    assert not list(tmp_path.iterdir())


def test_an_interrupted_search_leaves_no_stages(photo: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("app.commands.decompose.run_shown", interrupted)
    with pytest.raises(KeyboardInterrupt):
        main(["decompose", str(photo), "-o", str(tmp_path / "parts"), "--stages", str(tmp_path / "stages")])
    assert not list(tmp_path.iterdir())


def test_stages_tell_why_nothing_was_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    noise = np.random.default_rng(1).integers(0, 256, (120, 150, 3), np.uint8)
    save(Image(noise), tmp_path / "noise.png")
    line = failing(capsys, "decompose", tmp_path / "noise.png", "-o", tmp_path / "no", "--stages", tmp_path / "stages")
    assert line == f"weft: error: no repeating texture found in {tmp_path / 'noise.png'}"
    assert load(tmp_path / "stages" / "00-keypoints.png").size_px == (300, 240)
    assert not (tmp_path / "no").exists()


def test_stages_are_written_as_pictures(photo: Path, tmp_path: Path) -> None:
    words = ["decompose", str(photo), "-o", str(tmp_path / "parts"), "--stages", str(tmp_path / "stages")]
    assert main(words) == 0
    names = [path.name for path in sorted((tmp_path / "stages").iterdir())]
    assert names == ["00-keypoints.png", "01-seeds.png", "02-lattice.png", "03-mesh.png", "03-texel.png"]
    seeds = load(tmp_path / "stages" / "01-seeds.png").pixels.astype(int)
    for colour in ((0, 255, 64), (255, 64, 0)):
        assert (np.abs(seeds - colour).max(-1) < 40).sum() > 20
    lattice = load(next(path for path in (tmp_path / "stages").iterdir() if "lattice" in path.name)).pixels
    assert (lattice[..., 1].astype(int) - lattice[..., 2] > 120).sum() > 300


def test_transparent_pixels_are_no_cloth_and_stay(tmp_path: Path) -> None:
    pixels = stored(make_scene(motif()).photo).pixels
    alpha = np.full((*pixels.shape[:2], 1), 255, np.uint8)
    alpha[60:110, 70:120] = 0
    save(Image(np.concatenate([pixels, alpha], -1)), tmp_path / "hole.png")
    save(stored(np.full((8, 8, 3), 0.6)), tmp_path / "plain.png")
    assert main(["decompose", str(tmp_path / "hole.png"), "-o", str(tmp_path / "parts")]) == 0
    assert np.isnan(np.load(tmp_path / "parts" / "texture_coords.npz")["uv"][60:110, 70:120]).all()
    out = tmp_path / "out.png"
    assert main(["overlay", str(tmp_path / "parts"), "--texture", str(tmp_path / "plain.png"), "-o", str(out)]) == 0
    assert (load(out).pixels[..., 3:] == alpha).all()
