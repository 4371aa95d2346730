"""`weft render` exports what a project holds."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.cli import main
from core.document.document import CurvePair, Document, WarpSettings
from core.document.project import save_project
from core.imaging.images import Image, load, save

pytestmark = pytest.mark.gpu


def document() -> Document:
    y, x = np.mgrid[0:40, 0:60]
    picture = Image(np.stack([x * 4, y * 6, 0 * x + 90], axis=-1).astype(np.uint8))
    return replace(Document.of(picture), warp=WarpSettings(preset="arch", bend=100))


def test_a_project_gives_what_the_warp_command_gives(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    save(document().image, "photo.png")
    save_project(document(), Path("a.weft"))
    for frame in ("picture", "warp"):
        assert main(["render", "a.weft", "-o", "one.png", "--frame", frame]) == 0
        assert main(["warp", "photo.png", "-o", "two.png", "--preset", "arch", "--bend=100", "--frame", frame]) == 0
        assert load("one.png").pixels.shape[:2] == ((40, 60) if frame == "picture" else (55, 60))
        np.testing.assert_array_equal(load("one.png").pixels, load("two.png").pixels)


def test_the_scale_multiplies_the_pixels(tmp_path: Path) -> None:
    save_project(document(), tmp_path / "a.weft")
    assert main(["render", str(tmp_path / "a.weft"), "-o", str(tmp_path / "a.png"), "--scale", "2"]) == 0
    assert load(tmp_path / "a.png").pixels.shape[:2] == (110, 120)


def test_the_depth_can_be_chosen(tmp_path: Path) -> None:
    save_project(document(), tmp_path / "a.weft")
    for bits, depth in {"16": np.uint16, "32": np.float32}.items():
        assert main(["render", str(tmp_path / "a.weft"), "-o", str(tmp_path / "a.tif"), "--bits", bits]) == 0
        assert load(tmp_path / "a.tif").pixels.dtype == depth


def test_another_picture_of_another_size_gets_the_same_warp(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    other = Image(np.repeat(np.repeat(document().image.pixels[:, ::-1], 2, axis=0), 2, axis=1))
    save(other, "other.png")
    save_project(document(), Path("a.weft"))
    save_project(document().with_image(other), Path("b.weft"))
    assert main(["render", "a.weft", "-o", "one.png", "--picture", "other.png"]) == 0
    assert main(["render", "b.weft", "-o", "two.png"]) == 0
    assert load("one.png").pixels.shape[:2] == (110, 120)
    np.testing.assert_array_equal(load("one.png").pixels, load("two.png").pixels)


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (["none.weft", "-o", "a.png"], "none.weft: no such file"),
        (["photo.png", "-o", "a.png"], "photo.png: not a Weft project"),
        (["a.weft", "-o", "a.png", "--picture", "none.png"], "none.png: no such file"),
        (["a.weft", "-o", "a.png", "--trace", "a.png"], "a.png: would be written over, but another option names it"),
        (["a.weft", "-o", "b.png", "--trace", "a.weft"], "a.weft: would be written over, but another option names it"),
        (["wild.weft", "-o", "a.png"], "wild.weft: bend 900: not from -100 to 100"),
        (["seed.weft", "-o", "a.png"], "seed.weft: retexture: seed -4: must not be negative"),
        (["wide.weft", "-o", "a.png"], "wide.weft: retexture: patches and searches take sides of 1 to 501 pixels"),
        (["huge.weft", "-o", "a.png"], "huge.weft: retexture: variety 1e+300: not from 0 to 100"),
        (["a.weft", "-o", "a.bmp"], "a.bmp: unknown picture format '.bmp'"),
        (["a.weft", "-o", "a.png", "--scale", "0"], "--scale 0: not above 0"),
        (["a.weft", "-o", "a.jpg", "--quality", "101"], "--quality 101: not from 1 to 100"),
    ],
)
def test_what_cannot_be_is_named(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    fault: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    save_project(document(), Path("a.weft"))
    save_project(document().with_warp(bend=900.0), Path("wild.weft"))
    flat, high = (np.array([[0.1, 0.5], [0.3, y], [0.6, y], [0.9, 0.5]]) for y in (0.5, 0.3))
    moved = document().changed(mode="retexture", feature_curves=(CurvePair(flat, high),))
    save_project(moved.with_retexture(seed=-4), Path("seed.weft"))
    save_project(moved.with_retexture(along_px=10**12), Path("wide.weft"))
    save_project(moved.with_retexture(variety=1e300), Path("huge.weft"))
    save(document().image, "photo.png")
    assert main(["render", *words]) == 2
    assert f"weft: error: {fault}" in capsys.readouterr().err
    assert not list(Path().glob("a.[pjb]*"))
