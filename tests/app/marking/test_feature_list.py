from pathlib import Path

import cv2
import numpy as np
import pytest

from app.editor.painting import with_layer
from app.files import document_io
from app.marking.applying import select
from app.marking.feature_list import feature_list, merge, remove, rows_of, say, split
from app.model.requests import SaveFile
from core.arrays import Bytes
from core.document.feature import Feature
from core.document.map import options_of
from core.document.project import load_project
from core.mapping.features.limits import Limits
from core.rasters.components import Components, Labels
from core.rasters.raster import Raster
from tests.app.driver import EditorDriver, document


def bars(*sides: tuple[int, int]) -> Raster:
    mask = np.zeros((150, 200), np.uint8)
    for left, right in sides:
        mask[50:110, left:right] = 255
    return Raster.from_array(mask)


def owners(drive: EditorDriver) -> Bytes:
    return feature_list(drive.editor).owners(drive.document, drive.editor.map.grid, 12)


def color_at(drive: EditorDriver, x: float, y: float) -> int:
    grid = drive.editor.map.grid
    return int(owners(drive)[round((y + 0.5) / grid.cell[1]), round((x + 0.5) / grid.cell[0])])


def test_a_feature_keeps_its_colour_whatever_is_painted_elsewhere() -> None:
    drive = EditorDriver(document().changed(mask=bars((80, 110), (150, 180))))
    before = color_at(drive, 95, 80), color_at(drive, 165, 80)
    assert len({*before, 0}) == 3
    assert color_at(drive, 20, 80) == 0
    drive.editor.edit("One more", drive.document.changed(mask=bars((5, 70), (80, 110), (150, 180))))
    drive.frame()
    assert (color_at(drive, 95, 80), color_at(drive, 165, 80)) == before
    assert color_at(drive, 25, 80) not in (0, *before)
    assert owners(drive) is owners(drive)


def test_a_feature_keeps_its_name_its_place_and_being_chosen_when_one_is_painted_left_of_it() -> None:
    drive = EditorDriver(document().changed(mask=bars((80, 110), (150, 180))))

    def listed() -> list[tuple[str, int]]:
        return [(row.name, row.box[0] // 10) for row in rows_of(drive.editor)]

    before = listed()
    assert before == [("Feature 1", 7), ("Feature 2", 14)]
    drive.editor.show(features=frozenset({rows_of(drive.editor)[1].id}))
    listed()
    drive.editor.edit("One more", drive.document.changed(mask=bars((5, 70), (80, 110), (150, 180))))
    drive.frame()
    assert listed() == [*before, ("Feature 3", 0)]
    assert drive.editor.session.features == {rows_of(drive.editor)[1].id}
    say(drive.editor, "Upright feature", drive.editor.session.features, upright=True)
    drive.frame()
    assert listed() == [*before, ("Feature 3", 0)]
    assert drive.document.features == (Feature(2, upright=True),)
    drive.editor.edit("Erase", drive.document.changed(mask=bars((5, 70), (150, 180))))
    drive.frame()
    assert listed() == [before[1], ("Feature 3", 0)]


def test_a_new_feature_comes_last_and_takes_no_name_of_another() -> None:
    drive = EditorDriver(document().changed(mask=bars((20, 50), (80, 110), (150, 180))))
    rows_of(drive.editor)
    drive.editor.edit("Erase", with_layer(drive.document, "mask", bars((80, 110), (150, 180))))
    drive.frame()
    before = [(row.name, row.box) for row in rows_of(drive.editor)]
    assert [name for name, _ in before] == ["Feature 2", "Feature 3"]
    drive.editor.show(part="new")
    select(drive.editor, "box", bars((20, 50)).array, "add")
    drive.frame()
    assert [(row.name, row.box) for row in rows_of(drive.editor)][:2] == before
    assert rows_of(drive.editor)[2].name == "Feature 4"


@pytest.mark.parametrize("named", [False, True])
def test_features_are_listed_alike_when_their_project_is_opened_again(tmp_path: Path, *, named: bool) -> None:
    drive = EditorDriver(document().changed(mask=bars((80, 110), (150, 180))))
    before = [row.name for row in rows_of(drive.editor)]
    if named:
        say(drive.editor, "Name feature", frozenset({rows_of(drive.editor)[1].id}), name="Right")
    drive.editor.edit("One more", with_layer(drive.document, "mask", bars((5, 70), (80, 110), (150, 180))))
    drive.frame()
    listed = [(row.name, row.box) for row in rows_of(drive.editor)]
    assert [name for name, _ in listed] == [before[0], "Right" if named else before[1], "Feature 3"]
    document_io.save_as(drive.editor)
    request = drive.editor.requests.pop()
    assert isinstance(request, SaveFile)
    request.then(tmp_path / "three.weft")
    drive.frame()
    assert drive.editor.history.is_saved
    again = EditorDriver(load_project(tmp_path / "three.weft"))
    assert [(row.name, row.box) for row in rows_of(again.editor)] == listed
    assert np.array_equal(again.document.mask.array, drive.document.mask.array)


def test_features_have_the_same_colours_when_a_project_is_opened_again() -> None:
    drive = EditorDriver(document().changed(mask=bars((80, 110))))
    before = [color_at(drive, 95, 80)]
    numbers = np.zeros((150, 200), np.uint8)
    numbers[50:110, 20:50] = 2  # painted as a new feature
    drive.editor.edit(
        "Paint", drive.document.changed(mask=bars((80, 110), (20, 50)), numbers=Raster.from_array(numbers))
    )
    drive.frame()
    before.append(color_at(drive, 35, 80))
    again = EditorDriver(drive.document)
    assert [color_at(again, 95, 80), color_at(again, 35, 80)] == before == [1, 2]


def test_another_picture_has_its_colours_whatever_was_open_before() -> None:
    drive = EditorDriver(document().changed(mask=bars((80, 110), (150, 180))))
    fresh = color_at(drive, 95, 80), color_at(drive, 165, 80)
    assert fresh == (1, 2)
    drive = EditorDriver(document().changed(mask=bars((5, 190))))
    owners(drive)
    drive.editor.edit("Erase", drive.document.changed(mask=bars((150, 180))))
    drive.frame()
    assert color_at(drive, 165, 80) == 1
    drive.editor.edit("Open", document().changed(mask=bars((80, 110), (150, 180))))
    drive.frame()
    assert (color_at(drive, 95, 80), color_at(drive, 165, 80)) == fresh


def test_a_frame_of_a_stroke_finds_its_features_once(monkeypatch: pytest.MonkeyPatch) -> None:
    drive = EditorDriver(document().changed(mask=bars((80, 110), (150, 180)))).tool("brush")
    owners(drive)
    found, seen = Components.labels, []

    def count(components: Components, raster: Raster) -> Labels:
        seen.append(raster)
        return found(components, raster)

    monkeypatch.setattr(Components, "labels", count)
    drive.press(20, 30)
    for x in (25, 30, 35):
        seen.clear()
        drive.move(x, 30)
        shown = owners(drive)
        assert len(seen) == 1
    monkeypatch.undo()
    mask = drive.document.mask.array > 127
    grid = drive.editor.map.grid
    assert np.array_equal(shown > 0, cv2.dilate(mask[np.ix_(*grid.pixels)].astype(np.uint8), np.ones((5, 5))) > 0)


def test_what_is_given_up_has_a_colour_of_its_own() -> None:
    drive = EditorDriver(document().changed(mask=bars((80, 110), (150, 180))))
    merge(drive.editor, "Give up feature", frozenset({2}), kept=False)
    drive.frame()
    assert drive.document.given_up == {2}
    assert color_at(drive, 165, 80) == 13
    assert [row.said.kept for row in rows_of(drive.editor)] == [True, False]


def test_what_is_said_of_features_goes_with_their_numbers() -> None:
    drive = EditorDriver(document().changed(mask=bars((20, 60), (120, 160))))
    merge(drive.editor, "Give up feature", frozenset({1}), kept=False)
    drive.editor.edit("Empty", with_layer(drive.document, "mask", Raster.filled(200, 150)))
    assert drive.document.features == ()
    stale = drive.document.changed(features=(Feature(1, kept=False),), mask=bars((20, 60)))
    assert stale.given_up == frozenset()
    drive.editor.edit("Paint", stale)
    drive.frame()
    assert drive.editor.map.features is not None
    assert len(drive.editor.map.features) == 1


def test_a_number_that_is_free_again_brings_nothing_back() -> None:
    drive = EditorDriver(document().changed(mask=bars((20, 60), (120, 160))))
    merge(drive.editor, "Name feature", frozenset({1}), name="Left", kept=False)
    drive.editor.edit("Clear", drive.document.changed(mask=bars((120, 160)), numbers=None))
    assert split(drive.editor, np.array([[140.0, 30.0], [140.0, 130.0]])) == 1
    assert [row.name for row in rows_of(drive.editor)] == ["Feature 2", "Feature 3"]
    assert all(row.said.kept for row in rows_of(drive.editor))


def test_removing_a_feature_is_undone_with_its_name() -> None:
    drive = EditorDriver(document().changed(mask=bars((20, 60), (120, 160))))
    merge(drive.editor, "Name feature", frozenset({2}), name="Right")
    kept = drive.document
    remove(drive.editor, frozenset({2}))
    assert [row.name for row in rows_of(drive.editor)] == ["Feature 1"]
    assert drive.undo().document is kept


def test_what_is_said_of_several_features_bends_each_of_them_and_is_one_undo_entry() -> None:
    drive = EditorDriver(document().changed(mask=bars((20, 60), (120, 160))).with_warp(preset="arc", bend=60))
    drive.editor.show(features=frozenset({1, 2}))
    say(drive.editor, "Upright feature", frozenset({1, 2}), upright=True, keep="rigid")
    drive.frame()
    assert drive.document.features == (Feature(1, keep="rigid", upright=True), Feature(2, keep="rigid", upright=True))
    result = drive.editor.map.result
    assert result is not None
    assert [(f.scale, f.angle_deg) for f in result.features] == [pytest.approx((1, 0), abs=1e-9)] * 2
    say(drive.editor, "Keep feature as", frozenset({2}), keep="similarity", upright=False)
    drive.frame()
    result = drive.editor.map.result
    assert result is not None
    assert abs(result.features[1].angle_deg) > 5
    assert result.features[0].angle_deg == pytest.approx(0, abs=1e-9)
    drive.undo().undo()
    assert not drive.document.features
    assert drive.document.numbers is None


def test_what_is_said_of_a_feature_survives_painting_on_it() -> None:
    drive = EditorDriver(document().changed(mask=bars((20, 60), (120, 160))))
    say(drive.editor, "Upright feature", frozenset({2}), upright=True)
    drive.editor.edit("Paint", with_layer(drive.document, "mask", bars((20, 60), (110, 170), (180, 195))))
    assert drive.document.features == (Feature(2, upright=True),)
    assert options_of(drive.document).single == ((2, Limits(turns=False)),)


def test_pieces_of_a_feature_are_kept_as_it_was() -> None:
    drive = EditorDriver(document().changed(mask=bars((20, 100), (120, 160))))
    merge(drive.editor, "Name feature", frozenset({1}), name="Left", keep="rigid", upright=True)
    for x in (60.0, 40.0):
        assert split(drive.editor, np.array([[x, 30.0], [x, 130.0]])) == 1
    names = ["Left", "Left 2", "Left 3"]
    said = tuple(Feature(n, name, True, "rigid", True) for n, name in zip((1, 3, 4), names, strict=True))
    assert drive.document.features == said
    assert [row.name for row in rows_of(drive.editor)] == ["Left", "Feature 2", "Left 2", "Left 3"]
    assert split(drive.editor, np.array([[140.0, 30.0], [140.0, 130.0]])) == 1
    assert len(drive.document.features) == 3
    drive.undo().undo()
    assert [feature.name for feature in drive.document.features] == names[:2]


def test_features_made_one_are_kept_as_the_largest_of_them() -> None:
    start = document().changed(mask=bars((5, 25), (40, 90), (110, 190)))
    drive = EditorDriver(start)
    merge(drive.editor, "Name feature", frozenset({1}), name="Left", keep="rigid")
    merge(drive.editor, "Keep", frozenset({256}), upright=True, weight=0.5)
    named = drive.document
    merge(drive.editor, "Make one feature", frozenset({1, 2}))
    assert drive.document.features == (Feature(1, "Left", upright=True, weight=0.5),)
    drive.editor.edit("Back", named)
    merge(drive.editor, "Make one feature", frozenset({1, 2, 256}))
    assert drive.document.features == (Feature(1, "Left"),)
    merge(drive.editor, "Give up feature", frozenset({1}), kept=False)
    merge(drive.editor, "Keep feature", frozenset({1}), kept=True)
    assert drive.document.features == (Feature(1, "Left"),)
    assert [row.name for row in rows_of(drive.editor)] == ["Left"]
