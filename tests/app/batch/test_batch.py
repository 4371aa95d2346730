"""`weft batch`: every frame is what the warp command gives; the same bytes whoever makes it; nothing done twice."""

import csv
import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from app.batch.look import Look
from app.batch.work import do_chunk
from app.cli import main
from core import tracing
from core.document.document import Document
from core.document.keys import KeyFrame, Span
from core.document.project import save_project
from core.imaging.images import Image, load, save
from tests.app.batch.scene import (
    FRAMES,
    HEIGHT,
    RECIPE,
    WIDTH,
    bytes_of,
    chunks_of,
    make,
    plate,
    states,
    weft,
    write_scene,
)

pytestmark = pytest.mark.gpu


def test_a_frame_is_what_the_warp_command_gives_at_its_keys(tmp_path: Path) -> None:
    rows = make(write_scene(tmp_path), tmp_path / "out" / "f.####.png")
    assert [(row.frame, row.state) for row in rows] == [(frame, "done") for frame in range(1, FRAMES + 1)]
    share = 2 / 5
    bend = 50 * share * share * (3 - 2 * share)
    words = ["--mask", str(tmp_path / "mask.png"), "--preset", "arc", f"--bend={bend!r}", "--frame", "picture"]
    assert main(["warp", str(tmp_path / "plates" / "shot.0003.png"), *words, "-o", str(tmp_path / "one.png")]) == 0
    np.testing.assert_array_equal(load(rows[2].output).pixels, load(tmp_path / "one.png").pixels)
    assert load(rows[0].output).channels == 4  # as all others, though it leaves no gap


def test_one_process_two_processes_and_shards_give_the_same_bytes(tmp_path: Path) -> None:
    recipe = write_scene(tmp_path)
    make(recipe, tmp_path / "here" / "f.####.png")
    table = tmp_path / "t.json"
    done = weft(recipe, "-o", tmp_path / "two" / "f.####.png", "--jobs", 2, "--table", table, folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(f"{FRAMES} frames: {FRAMES} done in ")
    assert states(table) == ["done"] * FRAMES
    assert weft(recipe, "-o", tmp_path / "sh" / "f.####.png", "--shard", "2/2", folder=tmp_path).returncode == 0
    assert sorted(bytes_of(tmp_path / "sh")) == ["f.0003.png", "f.0004.png"]
    assert weft(recipe, "-o", tmp_path / "sh" / "f.####.png", "--shard", "1/2", folder=tmp_path).returncode == 0
    assert bytes_of(tmp_path / "here") == bytes_of(tmp_path / "two") == bytes_of(tmp_path / "sh")


def test_a_chunk_is_factored_once(tmp_path: Path) -> None:
    chunk = chunks_of(write_scene(tmp_path, RECIPE.replace("chunk = 2", "chunk = 6")), tmp_path / "f.####.png")[0]
    trace = tmp_path / "trace.json"
    tracing.start()
    try:
        do_chunk(chunk)
    finally:
        tracing.save(trace)
    names = [event["name"] for event in json.loads(trace.read_text())["traceEvents"]]
    assert (names.count("analyse"), names.count("setup"), names.count("rhs")) == (1, 1, FRAMES)
    assert len(list(tmp_path.glob("f.*.png"))) == FRAMES


def test_a_mask_of_labels_has_a_feature_for_each_and_says_so_once(tmp_path: Path) -> None:
    recipe = write_scene(tmp_path)
    labels = np.zeros((HEIGHT, WIDTH, 1), np.uint8)
    labels[14:30, 20:30], labels[14:30, 30:40] = 1, 2  # they touch: as one mask they were one feature
    save(Image(labels), tmp_path / "mask.png")
    done = weft(recipe, "-o", tmp_path / "out" / "f.####.png", folder=tmp_path)
    assert done.returncode == 0
    assert done.stderr == f"weft: note: {tmp_path / 'mask.png'}: The mask holds 2 labels, each of them a feature.\n"
    share = 2 / 5
    bend = 50 * share * share * (3 - 2 * share)
    words = ["--mask", str(tmp_path / "mask.png"), "--preset", "arc", f"--bend={bend!r}", "--frame", "picture"]
    assert main(["warp", str(tmp_path / "plates" / "shot.0003.png"), *words, "-o", str(tmp_path / "one.png")]) == 0
    np.testing.assert_array_equal(load(tmp_path / "out" / "f.0003.png").pixels, load(tmp_path / "one.png").pixels)
    save(Image(np.where(labels > 0, 255, 0).astype(np.uint8)), tmp_path / "mask.png")
    assert make(recipe, tmp_path / "plain" / "f.####.png")[2].state == "done"
    assert (load(tmp_path / "plain" / "f.0003.png").pixels != load(tmp_path / "one.png").pixels).any()


def test_masks_can_be_a_sequence_too(tmp_path: Path) -> None:
    recipe = write_scene(tmp_path, RECIPE.replace('"mask.png"', '"mask.#.png"'))
    mask = load(tmp_path / "mask.png")
    for frame in range(1, FRAMES):
        save(mask.with_pixels(np.roll(mask.pixels, frame, axis=1)), tmp_path / f"mask.{frame}.png")
    rows = make(recipe, tmp_path / "out" / "f.####.png")
    assert [row.state for row in rows] == ["done"] * 5 + ["failed"]
    assert rows[5].fault == f"{tmp_path / 'mask.6.png'}: no such file or directory"
    look = Look(chunks_of(recipe, tmp_path / "out" / "f.####.png")[0].batch)
    assert np.flatnonzero(look.at(3, Image(plate(3))).mask.array[22])[0] == np.flatnonzero(mask.pixels[22])[0] + 3


def test_a_broken_frame_and_one_of_another_size_are_a_line_each_and_the_rest_goes_on(tmp_path: Path) -> None:
    recipe = write_scene(tmp_path)
    broken, wide = tmp_path / "plates" / "shot.0002.png", tmp_path / "plates" / "shot.0005.png"
    broken.write_bytes(broken.read_bytes()[:-200])
    save(Image(plate(5, WIDTH + 2)), wide)
    table = tmp_path / "t.csv"
    done = weft(recipe, "-o", tmp_path / "out" / "f.####.png", "--table", table, folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        f"weft: error: frame 2: {broken}: the image is damaged or cut short",
        f"weft: error: frame 5: {wide}: has 66x48 pixels, the first frame 64x48",
        "weft: error: 2 of 6 frames failed",
    ]
    assert sorted(bytes_of(tmp_path / "out")) == [f"f.000{frame}.png" for frame in (1, 3, 4, 6)]
    with table.open() as text:
        assert [row["state"] for row in csv.DictReader(text)] == ["done", "failed", "done", "done", "failed", "done"]


@pytest.mark.parametrize("pictures", ["shot.####.png", ""])
def test_a_broken_first_frame_costs_itself_alone(tmp_path: Path, pictures: str) -> None:
    recipe, broken = write_scene(tmp_path), tmp_path / "plates" / "shot.0001.png"
    broken.write_bytes(broken.read_bytes()[:60])
    rows = make(recipe, tmp_path / "out", pictures=[str(tmp_path / "plates" / pictures)])
    assert [row.state for row in rows] == ["failed"] + ["done"] * (FRAMES - 1)
    assert rows[0].fault == f"{broken}: the image is damaged or cut short"


def test_pictures_of_any_size_can_be_a_list_or_a_folder(tmp_path: Path) -> None:
    write_scene(tmp_path)
    save(Image(plate(5, 90, 60)), tmp_path / "plates" / "shot.0005.png")
    save_project(Document.of(Image(plate(1))).with_warp(preset="arch", bend=40.0), tmp_path / "a.weft")
    rows = make(tmp_path / "a.weft", tmp_path / "out", pictures=[str(tmp_path / "plates")])
    assert [row.state for row in rows] == ["done"] * FRAMES
    assert load(tmp_path / "out" / "shot.0005.png").size_px == (90, 60)
    words = ["-o", str(tmp_path / "one.png"), "--frame", "picture", "--picture", rows[4].source]
    assert main(["render", str(tmp_path / "a.weft"), *words]) == 0
    assert (tmp_path / "one.png").read_bytes() == Path(rows[4].output).read_bytes()


def test_key_frames_of_a_project_move_its_own_picture(tmp_path: Path) -> None:
    still = Document.of(Image(plate(1))).with_warp(preset="arc")
    moving = replace(still, tracks={"bend": (KeyFrame(1, (0.0,)), KeyFrame(3, (60.0,)))})
    save_project(moving, tmp_path / "a.weft")
    done = weft(tmp_path / "a.weft", "--frames", "1-3", "-o", tmp_path / "f.#.png", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    save_project(still.with_warp(bend=30.0), tmp_path / "b.weft")
    assert main(["render", str(tmp_path / "b.weft"), "-o", str(tmp_path / "g.png"), "--frame", "picture"]) == 0
    assert (tmp_path / "g.png").read_bytes() == (tmp_path / "f.2.png").read_bytes()
    assert (tmp_path / "f.1.png").read_bytes() != (tmp_path / "f.2.png").read_bytes()


def test_a_project_brings_the_frames_and_the_rate_of_its_timeline(tmp_path: Path) -> None:
    moving = replace(Document.of(Image(plate(1))).with_warp(preset="arc"), span=Span(3, 5, 29.97))
    save_project(moving, tmp_path / "still.weft")
    save_project(replace(moving, tracks={"bend": (KeyFrame(3, (40.0,)), KeyFrame(5, (0.0,)))}), tmp_path / "a.weft")
    frames = [item.frame for chunk in chunks_of(tmp_path / "a.weft", tmp_path / "f.#.png") for item in chunk.items]
    assert frames == [3, 4, 5]
    assert chunks_of(tmp_path / "a.weft", tmp_path / "a.mov")[0].batch.rate == Fraction(30000, 1001)
    assert [item.frame for item in chunks_of(tmp_path / "still.weft", tmp_path / "f.#.png")[0].items] == [1]
    rows = make(tmp_path / "a.weft", tmp_path / "f.#.png")
    assert main(["render", str(tmp_path / "a.weft"), "-o", str(tmp_path / "g.png"), "--frame", "picture"]) == 0
    assert (tmp_path / "g.png").read_bytes() == Path(rows[0].output).read_bytes()


def test_st_maps_can_be_a_sequence(tmp_path: Path) -> None:
    recipe = write_scene(tmp_path, 'picture = "plates/shot.####.png"\nframes = "1-3"\nstmap = "st.#.exr"\nchunk = 2')
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    for frame in (1, 2, 3):
        shares = [(x + 0.5 + 4 * frame) / WIDTH, 1 - (y + 0.5) / HEIGHT, 0 * x]
        save(Image(np.stack(shares, axis=-1).astype(np.float32), linear=True), tmp_path / f"st.{frame}.exr")
    rows = make(recipe, tmp_path / "out" / "f.#.png")
    for row in rows:
        shown = load(row.output).pixels[:, 4:40, :3]
        np.testing.assert_allclose(shown, plate(row.frame)[:, 4 + 4 * row.frame : 40 + 4 * row.frame], atol=1)
