"""What is kept between a document and its map: the same objects while what they are made of is the same."""

from dataclasses import replace

import numpy as np
import pytest

import core.document.straight_lines
from core.arrays import Points
from core.document.document import Document, Pin
from core.document.map import grid_of, preset_of
from core.document.map_solver import MapInputs, MapSolver
from core.document.straight_lines import PictureLines
from core.imaging.image import Image
from core.rasters.raster import Raster
from core.selection.long_lines import find_lines
from core.warps.map_file import WarpMap

SIZE = 200, 150


def document() -> Document:
    pixels = np.full((*SIZE[::-1], 3), 200, np.uint8)
    pixels[70:] = 40
    mask = np.zeros(SIZE[::-1], np.uint8)
    mask[50:110, 60:95] = 255
    start = Document.of(Image(pixels)).changed(mask=Raster.from_array(mask))
    return start.with_warp(preset="arc", bend=40.0, cell_px=5.0, straight=True)


def test_inputs_are_the_same_objects_until_what_they_are_made_of_changes() -> None:
    start = document()
    inputs = MapInputs(grid_of(start), PictureLines())
    features, options, plain = inputs.features(start), inputs.options(start), inputs.plain(start)
    assert options.lines is not None
    dragged = start.changed(pins=(Pin((0.5, 0.5), (0.6, 0.5)),))
    assert inputs.features(dragged) is features
    assert inputs.options(dragged).lines is options.lines
    assert inputs.plain(dragged) is plain
    bent = start.with_warp(bend=41.0)
    assert np.array_equal(inputs.plain(bent), preset_of(bent)(grid_of(bent).nodes))
    assert inputs.plain(bent) is not plain
    cleared = bent.changed(mask=Raster.filled(*SIZE))
    assert inputs.features(cleared) is not features
    assert not len(inputs.features(cleared).ids)


def test_a_map_that_was_read_is_followed_once_while_the_preset_bends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    followed: list[int] = []
    follow = WarpMap._met

    def counted(warp_map: WarpMap, share: Points) -> Points:
        followed.append(len(share))
        return follow(warp_map, share)

    monkeypatch.setattr(WarpMap, "_met", counted)
    y, x = (np.mgrid[: SIZE[1], : SIZE[0]] + 0.5) / np.reshape(SIZE[::-1], (2, 1, 1))
    start = document().changed(warp_map=WarpMap(np.stack([x, y**1.1], axis=2).astype(np.float32)))
    inputs = MapInputs(grid_of(start), PictureLines())
    plains = [inputs.plain(start.with_warp(bend=bend)) for bend in (0.0, 20.0, 40.0)]
    assert len(followed) == 1
    for bend, plain in zip((0.0, 20.0, 40.0), plains, strict=True):
        assert np.array_equal(plain, preset_of(start.with_warp(bend=bend))(grid_of(start).nodes))


def test_solvers_look_for_the_lines_of_a_picture_once(monkeypatch: pytest.MonkeyPatch) -> None:
    looked: list[Image] = []

    def counted(image: Image) -> Points:
        looked.append(image)
        return find_lines(image)

    monkeypatch.setattr(core.document.straight_lines, "find_lines", counted)
    start, lines = document(), PictureLines()
    solvers = MapSolver(lines=lines), MapSolver(lines=lines)
    assert all(solver.is_heavy(start) for solver in solvers)
    assert not looked  # what would take more than a frame is not begun by asking
    for solver in solvers:
        solver.frame(start)
        solver.frame(start.with_warp(bend=30.0))
    assert len(looked) == 1
    assert not solvers[1].is_heavy(start)
    solvers[0].frame(replace(start, image=Image(start.image.pixels.copy())))
    assert len(looked) == 2


def test_a_mask_that_shares_nothing_with_the_last_one_is_no_work_for_a_frame() -> None:
    def marked(left: int, right: int) -> Document:
        mask = np.zeros((document().size_px[1], document().size_px[0]), np.uint8)
        mask[30:60, left:right] = 255
        return replace(bare, mask=Raster.from_array(mask))

    bare = replace(document(), curves=(), pins=()).with_warp(straight=False)
    solver = MapSolver()
    solver.frame(marked(20, 50))
    assert not solver.is_heavy(marked(20, 60))
    assert solver.is_heavy(marked(70, 90))
    assert not solver.is_heavy(marked(20, 50).with_warp(bend=40.0))
