"""What of the pointer's way between two frames is looked at."""

import numpy as np

from app.ui.input import MOST_WAY, WAY_PX, spaced


def test_places_too_close_to_one_another_are_left_out() -> None:
    trail = [(float(x), 0.0) for x in range(1, 20)]
    kept = spaced(trail, (0.0, 0.0))
    assert np.diff([0.0, *(x for x, _ in kept)]).min() >= WAY_PX
    assert kept[-1][0] > 19 - WAY_PX


def test_a_turn_of_the_hand_is_kept() -> None:
    assert (0.0, 50.0) in spaced([(1.0, 1.0), (0.0, 50.0), (1.0, 3.0)], (0.0, 0.0))


def test_a_fast_hand_gives_no_more_places_than_a_frame_can_take() -> None:
    assert len(spaced([(10.0 * x, 0.0) for x in range(500)], None)) <= MOST_WAY
