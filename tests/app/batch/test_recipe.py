"""Recipes: what they mean, and what is said of those that mean nothing."""

from pathlib import Path

import numpy as np
import pytest

from app.batch.look import Look
from app.batch.recipe import read_recipe
from app.cli import main
from core.document.document import Document
from core.document.feature import Feature
from core.document.keys import KeyFrame
from core.document.project import save_project
from core.imaging.images import Image, save
from core.rasters.raster import Raster
from tests.app.batch.scene import HEIGHT, WIDTH, chunks_of, write_recipe, write_scene

FULL = """\
picture = ["plates/*.png"]
frames = "2-3"
mask = "mask.png"
chunk = 1

[warp]
preset = "wave"
bend = 5
size = [128, 48]
values = {waves = 2}

[[pins]]
at = [31.5, 23.5]
to = [63.5, 23.5]
keys = [{frame = 2, to = [63.5, 23.5]}, {frame = 4, to = [63.5, 33.5], easing = "hold"}]

[keys]
waves = [{frame = 1, value = 1}, {frame = 3, value = 2}]
size = [{frame = 1, value = [64, 48]}]

[output]
quality = 80
"""


def test_a_recipe_is_a_document_in_pixels_of_the_first_picture(tmp_path: Path) -> None:
    chunks = chunks_of(write_scene(tmp_path, FULL), tmp_path / "out")
    assert [[item.frame for item in chunk.items] for chunk in chunks] == [[2], [3]]
    base = Look(chunks[0].batch).base
    assert (base.size_px, base.canvas_px) == ((WIDTH, HEIGHT), (128, 48))
    assert (base.warp.preset, base.warp.bend, dict(base.warp.values)) == ("wave", 5.0, {"waves": 2.0})
    assert dict(base.tracks) == {
        "waves": (KeyFrame(1, (1.0,)), KeyFrame(3, (2.0,))),
        "size": (KeyFrame(1, (1.0, 1.0)),),
    }
    (pin,) = base.pins
    assert (pin.at, pin.to) == ((0.5, 0.5), (0.5, 0.5))
    assert pin.keys == (KeyFrame(2, (0.5, 0.5)), KeyFrame(4, (0.5, 34 / 48), "hold"))
    assert (base.mask.array > 127).sum() > 200


def test_a_recipe_changes_of_its_project_what_it_names(tmp_path: Path) -> None:
    own = Document.of(Image(np.zeros((20, 30, 3), np.uint8))).with_warp(preset="arc", bend=10.0, horizontal=4.0)
    save_project(own.changed(tracks={"bend": (KeyFrame(1, (1.0,)),)}), tmp_path / "a.weft")
    recipe = write_recipe(
        tmp_path, 'project = "a.weft"\n[warp]\nbend = 30\n[keys]\nvertical = [{frame = 1, value = 2}]'
    )
    base = Look(chunks_of(recipe, tmp_path / "f.####.png")[0].batch).base
    assert (base.warp.preset, base.warp.bend, base.warp.horizontal) == ("arc", 30.0, 4.0)
    assert base.tracks.keys() == {"bend", "vertical"}


def test_single_features_are_kept_as_the_recipe_says_and_others_as_its_project(tmp_path: Path) -> None:
    own = Document.of(Image(np.zeros((20, 30, 3), np.uint8)))
    marks = np.zeros((20, 30), np.uint8)
    marks[5:9, 4:10], marks[12:16, 15:25] = 3, 4
    mask = Raster.from_array(np.where(marks > 0, 255, 0).astype(np.uint8))
    said = Feature(3, "Left", keep="rigid"), Feature(4, "Right")
    save_project(own.changed(mask=mask, numbers=Raster.from_array(marks), features=said), tmp_path / "a.weft")
    recipe = write_recipe(tmp_path, 'project = "a.weft"\n[features]\n4 = "lines"\n[warp]\nstraight = true')
    base = Look(chunks_of(recipe, tmp_path / "f.####.png")[0].batch).base
    assert base.features == (said[0], Feature(4, keep="lines"))
    assert base.warp.straight


def test_of_masks_for_each_frame_those_that_have_a_feature_keep_it_as_the_recipe_says(tmp_path: Path) -> None:
    recipe = write_scene(tmp_path, 'picture = "plates/shot.####.png"\nmask = "m.#.png"\n[features]\n2 = "upright"\n')
    labels = np.zeros((HEIGHT, WIDTH, 1), np.uint8)
    labels[5:20, 5:20] = 1
    save(Image(labels.copy()), tmp_path / "m.1.png")
    labels[25:40, 25:40] = 2
    save(Image(labels), tmp_path / "m.2.png")
    look = Look(chunks_of(recipe, tmp_path / "f.####.png")[0].batch)
    assert [look.at(frame, None).features for frame in (1, 2)] == [(), (Feature(2, upright=True),)]


def test_a_project_is_a_recipe(tmp_path: Path) -> None:
    save_project(Document.of(Image(np.zeros((20, 30, 3), np.uint8))), tmp_path / "a.weft")
    assert read_recipe(tmp_path / "a.weft").project == tmp_path / "a.weft"


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("bend = 3", "unknown key 'bend'; known are project, picture, frames, mask"),
        ("[warp]\nbent = 3", "warp: unknown key 'bent'; known are preset, bend"),
        ("[[pins]]\nat = [1, 2]\ntoo = [1, 2]", "pins 1: unknown key 'too'; known are at, to, keys"),
        ("[keys]\nbend = [{frame = 1, valeu = 3}]", "keys.bend 1: unknown key 'valeu'; known are frame, value, easing"),
        ("[warp]\nbend = 'much'", "warp.bend: is not a finite number"),
        ("[keys]\nbend = [{frame = 1, value = 1, easing = 'soft'}]", "keys.bend.0.easing: is not one of linear, hold"),
        ("[keys]\nbend = [{value = 1}]", "keys.bend.0.frame: is missing"),
        ("[[pins]]\nat = [1, 2]", 'pins 1: has neither "to" nor "keys"'),
        ("[warp\nbend", "not a recipe in TOML: Expected ']'"),
        ("[features]\n1 = 'wobbly'", "features.1: 'wobbly' is no way to keep a feature"),
        ("[features]\nleft = 'rigid'", "features.left: 'left' is no number of a feature"),
        ("[features]\n1 = 2", "features.1: is not of type str"),
        ("mask = 'mask.png'\n[features]\n2 = 'rigid'", "feature 2: the mask has none of that number"),
        ("chunk = 0", "chunk: 0 is not from 1 to 100000"),
        ("[output]\nquality = 101", "output.quality: 101 is not from 1 to 100"),
        ("[output]\nrate = 'fast'", "output.rate: 'fast' is not a number or a fraction above 0"),
        ("[warp]\npreset = 'arcs'", "preset 'arcs': unknown; did you mean arc"),
        (
            "[keys]\nbend = [{frame = 2, value = 1}, {frame = 1, value = 1}]",
            "keys of bend: frame 1 comes after frame 2",
        ),
        ("[keys]\nbend = [{frame = 1, value = 900}]", "bend 900: not from -100 to 100"),
        ("[keys]\nhue = [{frame = 1, value = 1}]\n[warp]\npreset='arc'", "preset arc: has no setting 'hue'"),
    ],
)
def test_what_a_recipe_cannot_say_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, fault: str
) -> None:
    write_scene(tmp_path)
    recipe = write_recipe(tmp_path, f'picture = "plates/shot.####.png"\n{text}')
    assert main(["batch", str(recipe), "-o", str(tmp_path / "out.####.png")]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"weft: error: {recipe}: {fault}")
    assert said.count("\n") == 1
    assert not list(tmp_path.glob("out*"))


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (["none.toml", "-o", "o.####.png"], "none.toml: no such file"),
        (["none.weft", "-o", "o.####.png"], "none.weft: no such file"),
        (["recipe.toml", "-o", "o.png"], "o.png: frames 1 and 2 go to one file; put #### in its name"),
        (["recipe.toml", "-o", "o.####.bmp"], "unknown picture format '.bmp'"),
        (["recipe.toml", "-o", "plates/shot.####.png"], "plates/shot.0001.png: would be written over, but it is read"),
        (["recipe.toml", "none/*.png", "-o", "o"], "none/*.png: there is no such picture"),
        (["recipe.toml", "none.####.png", "-o", "o"], "none.####.png: there is no such frame"),
        (["recipe.toml", "none.mov", "-o", "o.mov"], "none.mov: no such file or directory"),
        (["recipe.toml", "mask.mov", "-o", "o.mov"], "mask.mov: not a video"),
        (["recipe.toml", "plates", "-o", "o.mov", "--frames", "9"], "plates: no picture is among the frames"),
        (["recipe.toml", "-o", "o.####.png", "--frames", "3-1"], "frames '3-1': 3-1 ends before it begins"),
        (["recipe.toml", "-o", "o.####.png", "--table", "t.txt"], "t.txt: a table is a .json or a .csv file"),
        (["recipe.toml", "-o", "o.####.png", "--shard", "5/4"], "argument --shard: '5/4': not K/N"),
        (["recipe.toml", "-o", "o.####.png", "--jobs", "0"], "--jobs 0: not from 1 to 1024"),
        (["small.toml", "-o", "o.####.png"], "small.png: the mask has 2x2 pixels, the image 64x48"),
        (["sized.toml", "-o", "o.mov"], "o.mov: frames of a video have one size"),
    ],
)
def test_what_cannot_be_begun_is_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    fault: str,
) -> None:
    write_scene(tmp_path)
    monkeypatch.chdir(tmp_path)

    save(Image(np.zeros((2, 2, 1), np.uint8)), "small.png")
    Path("mask.mov").write_text("no video at all")
    Path("small.toml").write_text('picture = "plates/shot.####.png"\nmask = "small.png"')
    Path("sized.toml").write_text('picture = "plates/shot.####.png"\n[keys]\nsize = [{frame = 1, value = [64, 48]}]')
    assert main(["batch", *words]) == 2
    said = capsys.readouterr().err
    assert fault in said
    assert said.count("\n") == 1
    assert not list(tmp_path.glob("o*"))
