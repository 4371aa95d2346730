"""Frame numbers and numbered names."""

from pathlib import Path

import pytest

from app.batch.frames import frames_on_disk, is_numbered, numbered, parse_frames, unnumbered
from core.arrays import InputError


@pytest.mark.parametrize(
    ("text", "frames"),
    [("7", (7,)), ("1-4", (1, 2, 3, 4)), ("1-10x4", (1, 5, 9)), ("5, 1-2", (1, 2, 5)), ("-2-1", (-2, -1, 0, 1))],
)
def test_frames_are_ranges_steps_and_lists(text: str, frames: tuple[int, ...]) -> None:
    assert parse_frames(text) == frames


@pytest.mark.parametrize("text", ["", "a", "1-", "4-1", "1-5x0", "1;2", "1-99999999"])
def test_what_is_no_range_is_named(text: str) -> None:
    with pytest.raises(InputError, match=r"^frames '"):
        parse_frames(text)


@pytest.mark.parametrize(
    ("name", "seventh"),
    [("a.####.exr", "a.0007.exr"), ("a#.png", "a7.png"), ("a.%04d.exr", "a.0007.exr"), ("%d.png", "7.png")],
)
def test_a_name_takes_the_number_where_it_has_a_place_for_it(name: str, seventh: str) -> None:
    assert is_numbered(name)
    assert numbered(name, 7) == seventh
    assert not is_numbered(unnumbered(name))


def test_the_frames_on_disk_are_those_of_just_that_name(tmp_path: Path) -> None:
    for name in ("a.0003.png", "a.0001.png", "a.10000.png", "a.2.png", "b.0004.png", "a.0005.png.bak", "xa.0006.png"):
        (tmp_path / name).touch()
    assert frames_on_disk(tmp_path / "a.####.png") == (1, 3, 10000)
    assert frames_on_disk(tmp_path / "none" / "a.####.png") == ()
