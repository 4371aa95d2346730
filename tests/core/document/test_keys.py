"""Key frames: the values between them, and the document at a frame, also after it was saved."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.arrays import InputError
from core.document.animated import document_at, is_animated, pose, set_keys, with_track
from core.document.document import Document, Pin
from core.document.keys import (
    Easing,
    KeyFrame,
    Span,
    Track,
    value_at,
    with_easing,
    with_key,
    with_moved_keys,
    without_keys,
)
from core.document.project import load_project, save_project
from core.imaging.images import Image


def document(**tracks: Track) -> Document:
    still = Document.of(Image(np.zeros((20, 40, 3), np.uint8))).with_warp(preset="arc", bend=7.0)
    return still.changed(tracks=tracks)


@pytest.mark.parametrize(
    ("easing", "quarter", "middle"),
    [
        ("linear", 2.5, 5.0),
        ("hold", 0.0, 0.0),
        ("ease", 1.5625, 5.0),
        ("ease-in", 0.625, 2.5),
        ("ease-out", 4.375, 7.5),
    ],
)
def test_the_way_between_two_keys_is_that_of_the_first_ones_easing(
    easing: Easing, quarter: float, middle: float
) -> None:
    track = (KeyFrame(10, (0.0,), easing), KeyFrame(30, (10.0,), "hold"), KeyFrame(40, (0.0,)))
    assert [value_at(track, frame)[0] for frame in (1, 10, 15, 20, 30, 39, 40, 99)] == [
        0.0,
        0.0,
        quarter,
        middle,
        10.0,
        10.0,
        0.0,
        0.0,
    ]


def test_a_document_without_keys_is_itself_at_every_frame() -> None:
    assert document_at(document(), 5) is not None
    still = document()
    assert document_at(still, 5) is still
    assert not is_animated(document(bend=()))


def test_parameters_size_and_pins_follow_their_keys() -> None:
    moving = document(
        bend=(KeyFrame(1, (0.0,)), KeyFrame(3, (20.0,))), size=(KeyFrame(1, (1.0, 1.0)), KeyFrame(3, (2.0, 1.0)))
    )
    moving = replace(
        moving,
        pins=(
            Pin((0.5, 0.5), (0.5, 0.5), keys=(KeyFrame(1, (0.5, 0.5)), KeyFrame(3, (0.5, 0.7)))),
            Pin((0, 0), (0, 0)),
        ),
    )
    middle = document_at(moving, 2)
    assert (middle.warp.bend, middle.canvas_px) == (10.0, (60, 20))
    assert [pin.to for pin in middle.pins] == [(0.5, 0.6), (0, 0)]
    assert not is_animated(middle)


def test_a_parameter_of_the_presets_own_can_have_keys() -> None:
    moving = document(waves=(KeyFrame(1, (0.0,)), KeyFrame(3, (1.0,)))).with_warp(preset="wave")
    assert document_at(moving, 2).warp.values["waves"] == 0.5


def test_keys_are_saved_with_the_project(tmp_path: Path) -> None:
    moving = document(bend=(KeyFrame(1, (0.0,), "ease"), KeyFrame(3, (20.0,))))
    moving = replace(moving, pins=(Pin((0.5, 0.5), (0.5, 0.5), keys=(KeyFrame(1, (0.25, 0.5), "hold"),)),))
    save_project(moving, tmp_path / "a.weft")
    back = load_project(tmp_path / "a.weft")
    assert dict(back.tracks) == dict(moving.tracks)
    assert back.pins == moving.pins


@pytest.mark.parametrize(
    ("tracks", "fault"),
    [
        ({"bend": (KeyFrame(3, (0.0,)), KeyFrame(3, (1.0,)))}, "keys of bend: frame 3 comes after frame 3"),
        ({"bend": (KeyFrame(1, (0.0, 1.0)),)}, "keys of bend: frame 1 has 2 numbers, not 1"),
        ({"size": (KeyFrame(1, (0.0, 1.0)),)}, "keys of size: 0 x 1 times the picture's size is out of all bounds"),
        ({"bend": (KeyFrame(1, (float("nan"),)),)}, "keys of bend: frame 1 has a value that is not a finite number"),
    ],
)
def test_keys_that_cannot_be_are_named(tracks: dict[str, Track], fault: str) -> None:
    with pytest.raises(InputError, match=f"^{fault}$"):
        document_at(document(**tracks), 2)


def test_a_new_key_is_eased_as_the_way_it_lies_on() -> None:
    track = with_key((), 5, (1.0,))
    assert track == (KeyFrame(5, (1.0,), "ease"),)
    track = with_easing(with_key(track, 9, (2.0,)), (5,), "hold")
    track = with_key(with_key(track, 7, (3.0,)), 1, (0.0,))
    assert [(key.frame, key.easing) for key in track] == [(1, "hold"), (5, "hold"), (7, "hold"), (9, "ease")]
    assert with_key(track, 7, (4.0,))[2] == KeyFrame(7, (4.0,), "hold")


def test_keys_are_moved_past_others_and_onto_them() -> None:
    track = tuple(KeyFrame(frame, (float(frame),)) for frame in (1, 5, 9))
    assert [key.value[0] for key in with_moved_keys(track, (1,), 6)] == [5, 1, 9]
    assert [(key.frame, key.value[0]) for key in with_moved_keys(track, (1, 5), 4)] == [(5, 1), (9, 5)]
    assert without_keys(track, (1, 9)) == track[1:2]


def test_values_are_those_at_a_frame_and_a_changed_one_becomes_a_key() -> None:
    moving = document(
        bend=(KeyFrame(1, (0.0,)), KeyFrame(11, (20.0,))), size=(KeyFrame(1, (1.0, 1.0)), KeyFrame(11, (3.0, 1.0)))
    )
    middle = pose(moving, 6)
    assert (middle.warp.bend, middle.warp.aspect) == (10, (2, 1))
    assert middle.tracks == moving.tracks
    assert pose(middle, 6) is middle
    assert set_keys(middle, 6) is middle
    changed = set_keys(middle.with_warp(bend=15.0), 6)
    assert [key.value for key in changed.tracks["bend"]] == [(0,), (15,), (20,)]
    assert changed.tracks["size"] == moving.tracks["size"]


def test_a_track_without_keys_goes() -> None:
    moving = document(bend=(KeyFrame(1, (0.0,)),))
    assert with_track(moving, "bend", ()).tracks == {}


def test_a_project_with_keys_out_of_order_is_damaged(tmp_path: Path) -> None:
    save_project(document(bend=(KeyFrame(3, (0.0,)), KeyFrame(2, (1.0,)))), tmp_path / "a.weft")
    with pytest.raises(InputError, match=r"a.weft: damaged project: keys of bend: frame 2 comes after frame 3$"):
        load_project(tmp_path / "a.weft")


def test_the_timelines_frames_are_saved_with_the_project(tmp_path: Path) -> None:
    save_project(document().changed(span=Span(-5, 40, 29.97)), tmp_path / "a.weft")
    assert load_project(tmp_path / "a.weft").span == Span(-5, 40, 29.97)
    for first, last, rate in ((2, 1, 24), (1, 10**8, 24), (1, 2, 0)):
        with pytest.raises(InputError, match=r"^timeline: "):
            Span(first, last, rate)
