"""Chords that are struck faster than frames are drawn."""

import pytest
from imgui_bundle import imgui

from app.model.events import Key, KeyUp, Modifiers
from app.ui.canvas.input import Chords, awaits_more

CTRL = (imgui.Key.left_ctrl, imgui.Key.mod_ctrl)


def press(io: imgui.IO, *keys: imgui.Key, down: bool) -> None:
    for key in keys:
        io.add_key_event(key, down)


def events(chords: Chords) -> list[Key | KeyUp]:
    """Draw a frame; return what keys did."""
    imgui.new_frame()
    found = list(chords.events(chords.take()))
    imgui.end_frame()
    return found


def frame(chords: Chords) -> list[Key]:
    """Draw a frame; return the keys that went down."""
    return [event for event in events(chords) if isinstance(event, Key) and not event.repeated]


@pytest.mark.parametrize("first", [(*CTRL,), (imgui.Key.z,)], ids=["Ctrl", "Z"])
def test_each_of_several_chords_before_a_frame_is_the_chord(io: imgui.IO, first: tuple[imgui.Key, ...]) -> None:
    """Whichever key is let go `first`, though Dear ImGui may have Ctrl up by the time that it has Z down."""
    chords, last = Chords(), tuple(key for key in (*CTRL, imgui.Key.z) if key not in first)
    press(io, *CTRL, down=True)
    pressed = frame(chords)
    for _ in range(3):
        press(io, *CTRL, imgui.Key.z, down=True)
        chords.hear(Modifiers(ctrl=True))
        press(io, *first, *last, down=False)
    for _ in range(12):
        pressed += frame(chords)
        if not awaits_more():
            break
    assert pressed == [Key("z", Modifiers(ctrl=True))] * 3


def test_a_chord_that_came_to_nothing_says_nothing_of_the_next_key(io: imgui.IO) -> None:
    chords = Chords()
    chords.hear(Modifiers(ctrl=True))
    assert frame(chords) == []
    press(io, imgui.Key.z, down=True)
    assert frame(chords) == [Key("z")]


def test_a_key_that_stays_down_repeats_until_it_is_up(io: imgui.IO) -> None:
    chords, io.delta_time = Chords(), 0.5
    press(io, imgui.Key.z, down=True)
    assert events(chords) == [Key("z")]
    for _ in range(3):
        assert events(chords) == [Key("z", repeated=True)]
    press(io, imgui.Key.z, down=False)
    assert events(chords) == [KeyUp("z")]
    assert events(chords) == []
