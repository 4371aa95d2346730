"""The stories whose longest frames `weft bench --only stories` tells do what they say, in the real window."""

import numpy as np
import pytest

from app.bench.stories import STORIES, find_longest, measure
from app.bench.window import Frame, open_window
from core.document.document import Document


def ends_of(story: str) -> tuple[Document, Document, float]:
    """Return a story's first and last document, and the largest residual of its features."""
    document, steps = STORIES[story](4)
    with open_window(document) as hand:
        hand.rest()
        for _, deed in steps:
            deed(hand)
            hand.rest()
        result = hand.editor.map.result
        assert result is not None
        assert not result.folded.any()
        assert not result.missed_pins
        return document, hand.editor.document, max(feature.residual for feature in result.features)


@pytest.mark.parametrize("story", STORIES)
def test_a_story_is_told_to_its_end(story: str) -> None:
    first, last, residual = ends_of(story)
    assert first.mask.is_empty
    assert (last.mask.array > 127).mean() > 0.02
    assert residual < 1e-6
    width, height = last.canvas_px
    match story:
        case "people":
            assert width == pytest.approx(0.8 * height, rel=0.01)
        case "letters":
            assert (last.warp.preset, last.warp.bend) == ("flag", 60.0)
        case "wing":
            assert len(last.pins) == 2
            assert np.subtract(last.pins[1].to, last.pins[1].at)[1] < -0.1
        case "label":
            assert last.surface is not None
        case _:
            assert [feature.keep for feature in last.features] == ["rigid"]
            assert width == pytest.approx(0.7 * first.canvas_px[0], rel=0.01)


def test_every_step_is_told_with_its_longest_frame() -> None:
    records = measure(["rigid and similar"], frames=3)
    assert [record["step"] for record in records] == ["select", "rigid", "drag the frame", "export"]
    assert all(record["frames"] > 3 and record["longest_ms"] > 0 for record in records)


def test_frames_of_more_than_a_tenth_of_a_second_are_stalls() -> None:
    frames = [Frame(ms, ms / 2, {}) for ms in (20.0, 101.0, 350.0)]
    assert find_longest(frames) == {"frames": 3, "longest_ms": 350.0, "longest_busy_ms": 175.0, "stalls": 2}
