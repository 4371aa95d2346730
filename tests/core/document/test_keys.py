"""Key frames: the values between them, and the document at a frame, also after it was saved."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.arrays import InputError
from core.document.animated import document_at, is_animated
from core.document.document import Document, Pin
from core.document.keys import Easing, Key, Track, value_at
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
    track = (Key(10, (0.0,), easing), Key(30, (10.0,), "hold"), Key(40, (0.0,)))
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
    moving = document(bend=(Key(1, (0.0,)), Key(3, (20.0,))), size=(Key(1, (1.0, 1.0)), Key(3, (2.0, 1.0))))
    moving = replace(
        moving, pins=(Pin((0.5, 0.5), (0.5, 0.5), keys=(Key(1, (0.5, 0.5)), Key(3, (0.5, 0.7)))), Pin((0, 0), (0, 0)))
    )
    middle = document_at(moving, 2)
    assert (middle.warp.bend, middle.canvas_px) == (10.0, (60, 20))
    assert [pin.to for pin in middle.pins] == [(0.5, 0.6), (0, 0)]
    assert not is_animated(middle)


def test_a_parameter_of_the_presets_own_can_have_keys() -> None:
    moving = document(waves=(Key(1, (0.0,)), Key(3, (1.0,)))).with_warp(preset="wave")
    assert document_at(moving, 2).warp.values["waves"] == 0.5


def test_keys_are_saved_with_the_project(tmp_path: Path) -> None:
    moving = document(bend=(Key(1, (0.0,), "ease"), Key(3, (20.0,))))
    moving = replace(moving, pins=(Pin((0.5, 0.5), (0.5, 0.5), keys=(Key(1, (0.25, 0.5), "hold"),)),))
    save_project(moving, tmp_path / "a.weft")
    back = load_project(tmp_path / "a.weft")
    assert dict(back.tracks) == dict(moving.tracks)
    assert back.pins == moving.pins


@pytest.mark.parametrize(
    ("tracks", "fault"),
    [
        ({"bend": (Key(3, (0.0,)), Key(3, (1.0,)))}, "keys of bend: frame 3 comes after frame 3"),
        ({"bend": (Key(1, (0.0, 1.0)),)}, "keys of bend: frame 1 has 2 numbers, not 1"),
        ({"size": (Key(1, (0.0, 1.0)),)}, "keys of size: 0 x 1 times the picture's size is out of all bounds"),
        ({"bend": (Key(1, (float("nan"),)),)}, "keys of bend: frame 1 has a value that is not a finite number"),
    ],
)
def test_keys_that_cannot_be_are_named(tracks: dict[str, Track], fault: str) -> None:
    with pytest.raises(InputError, match=f"^{fault}$"):
        document_at(document(**tracks), 2)
