"""What of the pointer's way between two frames is looked at."""

import numpy as np
import pytest
from imgui_bundle import imgui

from app.model.events import Move, Press
from app.ui.canvas.input import MOST_WAY, WAY_PX, WAY_S, Area, Pointer, space_out


def test_places_too_close_to_one_another_are_left_out() -> None:
    trail = [(float(x), 0.0) for x in range(1, 20)]
    kept = space_out(trail, (0.0, 0.0))
    assert np.diff([0.0, *(x for x, _ in kept)]).min() >= WAY_PX
    assert kept[-1][0] > 19 - WAY_PX


def test_a_turn_of_the_hand_is_kept() -> None:
    assert (0.0, 50.0) in space_out([(1.0, 1.0), (0.0, 50.0), (1.0, 3.0)], (0.0, 0.0))


def test_a_fast_hand_gives_no_more_places_than_a_frame_can_take() -> None:
    assert len(space_out([(10.0 * x, 0.0) for x in range(500)], None)) <= MOST_WAY


@pytest.mark.parametrize(("place_s", "most"), [(WAY_S / 1000, MOST_WAY), (WAY_S / 4, 4), (WAY_S * 3, 1)])
def test_places_that_take_long_are_fewer(io: imgui.IO, place_s: float, most: int) -> None:
    now = 0.0
    pointer, area = Pointer(lambda: now), Area(0, 0, 2000, 100)
    moves: list[Move] = []
    for number in range(12):
        x = 10.0 + 100 * number
        io.add_mouse_pos_event(x, 50)
        io.add_mouse_button_event(0, number > 0)
        pointer.trail = [(x - 100 + step, 50.0) for step in range(101)]
        imgui.new_frame()
        moves = []
        for event in pointer.events(area):
            assert not isinstance(event, Press) or number == 1
            moves += [event] if isinstance(event, Move) else []
            now += place_s
        imgui.end_frame()
    assert most / 2 <= len(moves) - 1 <= most
    assert moves[-1].pos == (x, 50.0)
