"""Stiff pins: what is around one keeps its shape and goes with it, beside what is painted."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.arrays import InputError, Points
from core.document import handles_file
from core.document.document import Document, Pin
from core.document.map_solver import MapInputs, settle_map
from core.document.project import load_project, save_project
from core.document.straight_lines import PictureLines
from core.grid import Grid
from core.imaging.image import Image
from core.progress import run
from core.rasters.raster import Raster
from core.selection.features import MOST

WIDTH, HEIGHT = 300, 200
DIAGONAL = float(np.hypot(WIDTH, HEIGHT))
PINS = (Pin((0.3, 0.5), (0.3, 0.5)), Pin((0.7, 0.5), (0.8, 0.3)), Pin((0.7, 0.8), (0.7, 0.8)))


def document(*stiff_px: float) -> Document:
    """Return a picture under three pins, stiff so far around."""
    pixels = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    pins = tuple(replace(pin, stiff=px / DIAGONAL) for pin, px in zip(PINS, stiff_px, strict=True))
    return Document.of(Image(pixels)).with_warp(cell_px=5.0).changed(pins=pins)


def strain(z: Points, rest: Points, place: tuple[float, float], radius: float) -> float:
    """Return how far nodes around a place are at most from the similarity that fits them best, in pixels."""
    inside = np.linalg.norm(rest - np.multiply(place, (WIDTH, HEIGHT)), axis=-1) < radius
    a, b = (points[inside] @ [1, 1j] for points in (rest, z))
    a, b = a - a.mean(), b - b.mean()
    return float(np.abs(b - a * (np.vdot(a, b) / np.vdot(a, a))).max())


def test_around_a_stiff_pin_the_picture_keeps_its_shape_and_the_pin_is_met() -> None:
    found = {px: run(settle_map(document(0, px, 0))) for px in (0.0, 30.0)}
    bent, kept = (strain(found[px].warped, found[px].grid.nodes, (0.7, 0.5), 28) for px in (0.0, 30.0))
    assert bent > 2
    assert kept < 1e-6
    assert max(report.worst_px for report in found[30.0].pin_reports) < 0.1
    assert not found[30.0].folded.any()
    assert [feature.id for feature in found[30.0].features] == [MOST + 1]


def test_what_is_painted_stays_as_it_is_and_a_pin_in_it_adds_nothing() -> None:
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    mask[80:120, 70:110] = 255
    painted = document(60, 30, 30).changed(mask=Raster.from_array(mask))
    inputs = MapInputs(Grid(WIDTH, HEIGHT, cell_px=5.0), PictureLines())
    labels = inputs.features(painted).labels
    alone = inputs.features(painted.changed(pins=())).labels
    assert np.array_equal(labels[alone > 0], alone[alone > 0])
    assert set(np.unique(labels)) == {0, 1, MOST + 2, MOST + 3}
    border = np.argwhere(labels == MOST + 2)[:, 0].max() * 5.0
    assert border == pytest.approx(0.65 * HEIGHT, abs=6), "each has what is nearer to it"


def test_the_features_are_the_same_object_while_a_stiff_pin_is_dragged() -> None:
    inputs = MapInputs(Grid(WIDTH, HEIGHT, cell_px=5.0), PictureLines())
    first = document(0, 30, 0)
    pins = (first.pins[0], replace(first.pins[1], to=(0.5, 0.2)), first.pins[2])
    assert inputs.features(first) is inputs.features(first.changed(pins=pins))
    assert inputs.features(first) is not inputs.features(document(0, 40, 0))
    assert not inputs.features(document(0, 0, 0)).labels.any()


def test_a_project_keeps_it_and_a_file_of_handles_says_it(tmp_path: Path) -> None:
    save_project(document(0, 30, 0), tmp_path / "stiff.weft")
    assert load_project(tmp_path / "stiff.weft").pins == document(0, 30, 0).pins
    data = {"pins": [{"at": [10, 10], "to": [20, 10], "stiff": 25}, {"at": [90, 10], "to": [90, 10]}]}
    (tmp_path / "handles.json").write_text(json.dumps(data), encoding="utf-8")
    assert handles_file.read(tmp_path / "handles.json", (WIDTH, HEIGHT)).stiff_px == (25, 0)


@pytest.mark.parametrize("radius", [-1, "far", float("nan"), None])
def test_a_radius_that_is_none_is_named(radius: object) -> None:
    with pytest.raises(InputError, match=r"pins\[0\]: stiff"):
        handles_file.from_data({"pins": [{"at": [10, 10], "to": [20, 10], "stiff": radius}]}, (WIDTH, HEIGHT))
