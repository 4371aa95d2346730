"""`weft decompose` and `weft overlay`, from file to file."""

import json
from pathlib import Path

import numpy as np
import pytest

from app.cli import main
from core.files.npy_file import write_npz
from core.imaging.images import Image, load, save
from core.overlay.storage.folder import read
from tests.core.overlay.overlay_scenes import stored


def failing(capsys: pytest.CaptureFixture[str], *words: object) -> str:
    """Run a command that must fail with status 2 and return its one line."""
    assert main([str(word) for word in words]) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("weft: error: ")
    return lines[0]


def copied(folder: Path, place: Path) -> Path:
    """Return a copy of a folder."""
    place.mkdir()
    for file in folder.iterdir():
        (place / file.name).write_bytes(file.read_bytes())
    return place


def test_folder_holds_the_parts(photo: Path, parts: Path) -> None:
    report = json.loads((parts / "report.json").read_text())
    image = load(photo).pixels
    assert report["image"] == list(image.shape[:2])
    assert report["lattice_vertices"] == len(json.loads((parts / "lattice.json").read_text())["vertices"])
    uv, detail = np.load(parts / "texture_coords.npz")["uv"], np.load(parts / "detail.npz")["detail"]
    shading = np.load(parts / "shading.npz")["shading"]
    inside = np.isfinite(uv).all(-1)
    assert report["coverage"] == pytest.approx(inside.mean())
    assert np.isfinite(shading[inside]).all()
    whole = load(parts / "reconstruction.png").pixels / 255 + detail - image / 255
    assert np.abs(whole[inside]).max() < 0.006
    assert (load(parts / "source.png").pixels == image).all()


def test_the_original_texel_gives_the_photo_back(photo: Path, parts: Path, tmp_path: Path) -> None:
    out = tmp_path / "back.png"
    assert main(["overlay", str(parts), "--texture", str(parts / "texel.png"), "-o", str(out)]) == 0
    assert np.abs(load(out).pixels.astype(int) - load(photo).pixels).max() <= 1


def test_a_new_texture_hides_the_old_pattern(photo: Path, parts: Path, tmp_path: Path) -> None:
    save(stored(np.full((8, 8, 3), 0.6)), tmp_path / "plain.png")
    out = tmp_path / "new.png"
    words = ["overlay", str(parts), "--texture", str(tmp_path / "plain.png"), "-o", str(out), "--shading", "0"]
    assert main(words) == 0
    assert load(photo).pixels[40:130, 40:150].std() > 40
    assert load(out).pixels[40:130, 40:150].std() < 6


def test_what_is_protected_stays_by_its_grey_levels(photo: Path, parts: Path, tmp_path: Path) -> None:
    new, mask, out = tmp_path / "new.png", tmp_path / "mask.png", tmp_path / "out.png"
    before = load(photo).pixels
    levels = np.zeros((*before.shape[:2], 1), np.uint8)
    levels[60:80, 60:80], levels[100:120, 100:120] = 255, 128
    save(Image(np.full((8, 8, 3), (250, 240, 20), np.uint8)), new)
    save(Image(levels), mask)
    pictures = []
    for extra in ((), ("--protect", str(mask))):
        assert main(["overlay", str(parts), "--texture", str(new), "-o", str(out), *extra]) == 0
        pictures.append(load(out).pixels.astype(int))
    plain, kept = pictures
    np.testing.assert_array_equal(kept[60:80, 60:80], before[60:80, 60:80])
    np.testing.assert_array_equal(kept[levels[..., 0] == 0], plain[levels[..., 0] == 0])
    half = slice(100, 120), slice(100, 120)
    assert np.abs(kept[half] - (plain[half] + before[half].astype(int)) / 2).mean() < 1.5
    assert np.abs(plain - before)[half].mean() > 10


def test_what_is_covered_by_hand_is_laid_by_its_grey_levels(photo: Path, parts: Path, tmp_path: Path) -> None:
    new, mask, out = tmp_path / "new.png", tmp_path / "mask.png", tmp_path / "out.png"
    before, holed = load(photo).pixels, copied(parts, tmp_path / "holed")
    known, hole = read(parts), (slice(60, 80), slice(60, 80))
    for name, key, layer in (("texture_coords", "uv", known.uv), ("shading", "shading", known.shading)):
        torn = layer.copy()
        torn[hole] = np.nan
        write_npz(holed / f"{name}.npz", **{key: torn})
    shares = known.coverage.copy()
    shares[hole] = 0
    np.savez(holed / "coverage.npz", coverage=shares)
    levels = np.zeros((*before.shape[:2], 1), np.uint8)
    levels[60:70, 60:80], levels[70:80, 60:80] = 255, 128
    save(Image(np.full((8, 8, 3), (250, 240, 20), np.uint8)), new)
    save(Image(levels), mask)
    pictures = []
    for folder, extra in ((parts, ()), (holed, ()), (holed, ("--cover", str(mask)))):
        words = ["overlay", str(folder), "--texture", str(new), "-o", str(out), "--detail", "0", *extra]
        assert main(words) == 0
        pictures.append(load(out).pixels.astype(int))
    whole, torn_out, covered = pictures
    np.testing.assert_array_equal(torn_out[hole], before[hole])
    assert np.abs(covered - whole)[60:70, 60:80].mean() < 8
    assert np.abs(covered - (whole + before) / 2)[70:80, 60:80].mean() < 8
    assert np.abs(whole - before)[hole].mean() > 30


def test_upright_copies_do_not_lean(parts: Path, tmp_path: Path) -> None:
    halves = np.zeros((8, 8, 3))
    halves[:, 4:] = 1.0
    save(stored(halves), tmp_path / "halves.png")
    leaning = copied(parts, tmp_path / "parts")
    report = json.loads((leaning / "report.json").read_text())
    side = float(np.linalg.norm(np.array(report["basis"])[:, 0]))
    across, down = np.array([side, 0.0]), np.array([0.5 * side, side])
    (leaning / "report.json").write_text(json.dumps({**report, "basis": np.stack([across, down], 1).tolist()}))
    y, x = np.mgrid[: load(parts / "source.png").height_px, : load(parts / "source.png").width_px]
    uv = np.stack([x - 0.5 * y, y], -1) / side
    uv[np.isnan(read(parts).uv)] = np.nan
    np.savez(leaning / "texture_coords.npz", uv=uv)
    edges = {}
    for way in ("", "--upright"):
        out = tmp_path / "out.png"
        words = ["overlay", str(leaning), "--texture", str(tmp_path / "halves.png"), "-o", str(out), "--detail", "0"]
        assert main([*words, "--shading", "0", *([way] if way else [])]) == 0
        shown = load(out).pixels[40:120, 40:140, 0].astype(float)
        edges[way] = np.abs(np.diff(shown, axis=0)).mean() / np.abs(np.diff(shown, axis=1)).mean()
    assert edges[""] > 0.3
    assert edges["--upright"] < 0.03


@pytest.mark.parametrize(
    "name", ["texture_coords.npz", "shading.npz", "detail.npz", "report.json", "source.png", "texel.png"]
)
def test_a_damaged_or_missing_part_is_named(
    name: str, parts: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = copied(parts, tmp_path / "parts")
    words = ("overlay", copy, "--texture", parts / "texel.png", "-o", tmp_path / "out.png")
    (copy / name).write_bytes(b"junk")
    assert name in failing(capsys, *words)
    (copy / name).unlink()
    assert name in failing(capsys, *words)
    assert not (tmp_path / "out.png").exists()


def test_folder_that_holds_no_more_than_the_contract_says_is_enough(photo: Path, parts: Path, tmp_path: Path) -> None:
    copy = copied(parts, tmp_path / "parts")
    (copy / "coverage.npz").unlink()
    report = json.loads((copy / "report.json").read_text())
    basis = np.array(report.pop("basis"))
    (copy / "report.json").write_text(json.dumps(report))
    assert np.abs(read(copy).basis - basis).max() < 0.1 * np.abs(basis).max()
    out = tmp_path / "back.png"
    assert main(["overlay", str(copy), "--texture", str(copy / "texel.png"), "-o", str(out)]) == 0
    assert np.abs(load(out).pixels.astype(int) - load(photo).pixels).max() <= 1
    assert np.array_equal(read(copy).coverage > 0, read(parts).coverage > 0)


@pytest.mark.parametrize("name", ["shading", "detail"])
def test_part_with_a_hole_in_the_cloth_is_named(
    name: str, parts: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = copied(parts, tmp_path / "parts")
    values = np.load(copy / f"{name}.npz")[name]
    values[80, 90] = np.nan
    np.savez(copy / f"{name}.npz", **{name: values})
    line = failing(capsys, "overlay", copy, "--texture", copy / "texel.png", "-o", tmp_path / "out.png")
    assert f"{name}.npz" in line
    assert "not finite" in line


def test_parts_without_cloth_are_named(parts: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copy = copied(parts, tmp_path / "parts")
    uv = np.load(copy / "texture_coords.npz")["uv"]
    np.savez(copy / "texture_coords.npz", uv=np.full_like(uv, np.nan))
    line = failing(capsys, "overlay", copy, "--texture", copy / "texel.png", "-o", tmp_path / "out.png")
    assert "texture_coords.npz: covers no pixel" in line


def test_parts_of_another_picture_are_refused(parts: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copy = copied(parts, tmp_path / "parts")
    np.savez(copy / "shading.npz", shading=np.ones((7, 9), np.float32))
    line = failing(capsys, "overlay", copy, "--texture", parts / "texel.png", "-o", tmp_path / "out.png")
    assert "shading.npz" in line
    assert "another picture" in line


@pytest.mark.parametrize(
    "words",
    [
        ["--repeat", "0,1"],
        ["--repeat", "a,b"],
        ["--repeat", "1e7"],
        ["--offset", "1,1e300"],
        ["--detail", "nan"],
        ["--shading", "-21"],
        ["--rotate", "x"],
    ],
)
def test_impossible_options_are_refused(
    words: list[str], parts: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    failing(capsys, "overlay", parts, "--texture", parts / "texel.png", "-o", tmp_path / "out.png", *words)
    assert not (tmp_path / "out.png").exists()


def test_the_parts_are_not_written_over(parts: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copy = copied(parts, tmp_path / "parts")
    line = failing(capsys, "overlay", copy, "--texture", copy / "texel.png", "-o", copy / "source.png")
    assert f"{copy / 'source.png'}: would be written over, but another option names it" in line
    assert (copy / "source.png").read_bytes() == (parts / "source.png").read_bytes()
    assert main(["overlay", str(copy), "--texture", str(copy / "texel.png"), "-o", str(copy / "out.png")]) == 0


def test_an_output_that_is_a_file_is_refused_at_once(
    photo: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("kept")
    assert "file" in failing(capsys, "decompose", photo, "-o", tmp_path / "file")
    assert (tmp_path / "file").read_text() == "kept"
    assert "nowhere" in failing(capsys, "decompose", photo, "-o", tmp_path / "nowhere" / "parts")
    stages = tmp_path / "nowhere" / "stages"
    assert "nowhere" in failing(capsys, "decompose", photo, "-o", tmp_path / "parts", "--stages", stages)
    picture = tmp_path / "nowhere" / "out.png"
    assert "nowhere" in failing(capsys, "overlay", tmp_path / "unread", "--texture", photo, "-o", picture)


def test_twice_the_size_shows_detail_of_the_texture_that_the_photo_has_no_pixels_for(
    parts: Path, tmp_path: Path
) -> None:
    rows, columns = np.indices((96, 96))
    save(stored(np.repeat((((rows // 2 + columns // 2) % 2) * 1.0)[..., None], 3, axis=2)), tmp_path / "fine.png")
    words = ["overlay", str(parts), "--texture", str(tmp_path / "fine.png"), "--shading", "0", "--detail", "0"]
    pictures = {}
    for scale in (0.5, 1, 2):
        out = tmp_path / f"{scale}.png"
        assert main([*words, "-o", str(out), "--scale", str(scale)]) == 0
        pictures[scale] = load(out).pixels.astype(float)
    height, width = pictures[1].shape[:2]
    assert pictures[2].shape[:2] == (2 * height, 2 * width)
    assert pictures[0.5].shape[:2] == (round(height / 2), round(width / 2))
    small, large = pictures[1][40:130, 40:150], pictures[2][80:260, 80:300]
    halved = large.reshape(90, 2, 110, 2, -1).mean(axis=(1, 3))
    assert large.std() > 1.3 * small.std(), "checks as fine as a pixel are grey in the small one"
    assert np.abs(halved - small).mean() < 12, "but both show the same place of the texture"


def test_a_scale_that_no_picture_has_is_refused(
    parts: Path, photo: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for scale in ("0", "nan", "65"):
        line = failing(capsys, "overlay", parts, "--texture", photo, "-o", tmp_path / "out.png", "--scale", scale)
        assert "--scale" in line
