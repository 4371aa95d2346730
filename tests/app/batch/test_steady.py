"""Steadiness in time: what stands still is the same bytes in every frame, what moves slowly moves slowly."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from app.batch.look import Look
from app.batch.plan import plan
from app.batch.recipe import read_recipe
from app.batch.steady import SteadySolver
from app.batch.work import do_chunk
from core.arrays import Floats
from core.document import retexture as document_retexture
from core.document.document import CurvePair, Document
from core.document.map_solver import MapSolver
from core.document.overlay_settings import Cloth, Search
from core.document.project import save_project
from core.imaging.images import Image, load, save
from core.progress import run
from core.rasters.raster import Raster
from tests.app.batch.scene import HEIGHT, RECIPE, WIDTH, bytes_of, chunks_of, make, write_recipe, write_scene
from tests.core.overlay.overlay_scenes import make_scene, motif, stored

pytestmark = pytest.mark.gpu
FRAMES = 4
BENDS = np.linspace(60, 67, 15)


def retexture_project() -> Document:
    """Return noise that a curve pulls upwards, so that texture is regrown below it."""
    noise = np.random.default_rng(1).integers(60, 200, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    flat, high = (np.array([[0.1, 0.6], [0.3, y], [0.6, y], [0.9, 0.6]]) for y in (0.6, 0.4))
    return Document.of(Image(noise)).changed(mode="retexture", feature_curves=(CurvePair(flat, high),))


def frames_of(folder: Path, name: str, pictures: str | None = None) -> Floats:
    """Make the frames of a project, each in a chunk of its own, and return them (N, H, W, C)."""
    source = "" if pictures is None else f'picture = "{pictures}"\n'
    recipe = write_recipe(folder, f'project = "a.weft"\nframes = "1-{FRAMES}"\nchunk = 1\n{source}')
    rows = [row for chunk in plan(read_recipe(recipe), folder / name / "f.#.png") for row in do_chunk(chunk)]
    assert [row.state for row in rows] == ["done"] * FRAMES
    return np.stack([load(row.output).pixels.astype(float) for row in rows])


def fading(image: Image, folder: Path) -> None:
    """Write frames of a picture that becomes brighter by a level a frame."""
    for frame in range(FRAMES):
        save(image.with_pixels(image.pixels + np.uint8(frame)), folder / f"p.{frame + 1}.png")


def test_what_moves_steadily_moves_steadily_in_the_frames(tmp_path: Path) -> None:
    """A still picture under a slow warp: no pixel jumps forth and back from frame to frame."""
    text = RECIPE.replace('"plates/shot.####.png"', '"plates/shot.0001.png"\nframes = "1-6"').replace(
        ', easing = "ease"', ""
    )
    rows = make(write_scene(tmp_path, text), tmp_path / "out" / "f.####.png")
    shown = np.stack([load(row.output).pixels.astype(float) for row in rows])
    covered = (shown[..., 3] == 255).all(axis=0)
    assert covered.mean() > 0.7
    inside = cv2.erode(covered.astype(np.uint8), np.ones((5, 5))) > 0
    moves, jumps = (np.abs(np.diff(shown[:, inside, :3], order, axis=0)).max() for order in (1, 2))
    assert moves > 6
    assert jumps <= 4  # one level from the next is a quarter of a pixel


def test_a_still_warp_of_a_still_picture_is_the_same_bytes_in_every_frame(tmp_path: Path) -> None:
    text = RECIPE.replace('shot.####.png"', 'shot.0001.png"\nframes = "1-3"').partition("[keys]")[0] + "bend = 30"
    make(write_scene(tmp_path, text), tmp_path / "out" / "f.####.png")
    assert len(bytes_of(tmp_path / "out")) == 3
    assert len(set(bytes_of(tmp_path / "out").values())) == 1


def test_texture_is_regrown_from_the_same_places_in_every_frame(tmp_path: Path) -> None:
    project = retexture_project()
    noise = project.image
    save_project(project, tmp_path / "a.weft")
    other = noise.with_pixels(255 - noise.pixels[::-1])
    save(noise, tmp_path / "p.1.png")
    save(other, tmp_path / "p.2.png")
    rows = make(tmp_path / "a.weft", tmp_path / "o.#.png", pictures=[str(tmp_path / "p.#.png")])
    first = run(document_retexture.found(project))
    for row, picture in zip(rows, (noise, other), strict=True):
        np.testing.assert_array_equal(load(row.output).pixels, first.apply(picture.pixels))
    alone = run(document_retexture.found(project.with_image(other))).apply(other.pixels)
    assert np.abs(alone.astype(int) - load(rows[1].output).pixels).max() > 100


def test_regrown_texture_stands_still_and_follows_a_fade(tmp_path: Path) -> None:
    project = retexture_project()
    save_project(project, tmp_path / "a.weft")
    shown = frames_of(tmp_path, "still")
    assert (np.abs(shown[0] - project.image.pixels) > 20).any()
    assert len(set(bytes_of(tmp_path / "still").values())) == 1
    fading(project.image, tmp_path)
    change = np.diff(frames_of(tmp_path, "fading", "p.#.png"), axis=0)
    assert change.min() >= 0
    assert change.max() <= 2
    assert change.mean() == pytest.approx(1, abs=0.05)


def test_a_new_texture_stands_still_on_the_cloth_and_follows_a_fade(tmp_path: Path) -> None:
    """The pattern is looked for in each chunk, each time with the same result."""
    texture = Image(np.random.default_rng(2).integers(60, 200, (40, 50, 3), dtype=np.uint8))
    photo = stored(make_scene(motif(), size=(130, 150)).photo)
    project = Document.of(photo).changed(mode="overlay", cloth=Cloth(search=Search(), texture=texture))
    save_project(project, tmp_path / "a.weft")
    shown = frames_of(tmp_path, "still")
    assert np.abs(shown[0] - photo.pixels).mean() > 5
    assert len(set(bytes_of(tmp_path / "still").values())) == 1
    fading(texture, tmp_path)
    change = np.diff(frames_of(tmp_path, "fading", "p.#.png"), axis=0)
    assert 0.3 < change.mean() < 1.5
    assert np.abs(change).max() <= 3


def swirled(frame: int) -> Document:
    """Return three discs in a swirl that is stronger from frame to frame, and folds around them but for what we do."""
    height, width = 160, 240
    y, x = np.mgrid[0:height, 0:width]
    discs = ((0.3, 0.45, 0.11), (0.62, 0.6, 0.13), (0.8, 0.25, 0.08))
    inside = [np.hypot(x - u * width, y - v * height) < r * height for u, v, r in discs]
    mask = Raster.from_array(np.where(np.any(inside, axis=0), 255, 0).astype(np.uint8))
    image = Image(np.zeros((height, width, 3), np.uint8))
    return Document.of(image).changed(mask=mask).with_warp(preset="swirl", bend=float(BENDS[frame]))


def test_of_several_maps_without_folds_each_frame_has_the_one_next_to_the_last() -> None:
    documents = [swirled(0)]
    documents += [documents[0].with_warp(bend=float(bend)) for bend in BENDS[1:]]
    ways = MapSolver(), SteadySolver(range(len(BENDS)))
    anew = np.stack([run(ways[0].settle(document)).warped for document in documents])
    steady = np.stack([ways[1].settle(frame, documents.__getitem__).warped for frame in range(len(BENDS))])
    assert all(ways[0].folds(document) for document in documents)
    jumps = [float(np.abs(np.diff(maps, axis=0)).max()) for maps in (anew, steady)]
    assert jumps[1] < 3 < 6 < jumps[0]
    alone = SteadySolver(range(len(BENDS)))
    for frame in (5, 6, 2):
        np.testing.assert_array_equal(alone.settle(frame, documents.__getitem__).warped, steady[frame])


def test_a_moving_map_without_folds_is_the_same_bytes_however_the_frames_are_cut(tmp_path: Path) -> None:
    text = RECIPE.replace('shot.####.png"', 'shot.0001.png"\nframes = "1-6"').replace('"arc"', '"swirl"')
    text = text.replace("value = 0", "value = 75").replace("value = 50", "value = 85")
    recipe = write_scene(tmp_path, text)
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    discs = (np.hypot(x - 20, y - 22) < 11) | (np.hypot(x - 44, y - 26) < 11)
    save(Image(np.where(discs, 255, 0).astype(np.uint8)[..., None]), tmp_path / "mask.png")
    (chunk, *_) = chunks_of(recipe, tmp_path / "two" / "f.#.png")
    assert all(MapSolver().folds(Look(chunk.batch).at(frame, None)) for frame in (2, 5))
    assert [row.state for row in make(recipe, tmp_path / "two" / "f.#.png")] == ["done"] * 6
    (tmp_path / "two" / "f.4.png").unlink()
    before = bytes_of(tmp_path / "two")
    assert [row.state for row in make(recipe, tmp_path / "two" / "f.#.png", resume=True)].count("done") == 1
    write_recipe(tmp_path, text.replace("chunk = 2", "chunk = 6"))
    make(recipe, tmp_path / "six" / "f.#.png")
    assert before.items() < bytes_of(tmp_path / "two").items()
    assert bytes_of(tmp_path / "two") == bytes_of(tmp_path / "six")
