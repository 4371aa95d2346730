"""`weft bench --only window` says what frames take, and what of it is whose."""

from typing import Any

import cv2
import numpy as np
import pytest

from app.bench.window import SIZE_PX, discs, split_frames, summarise
from app.cli import main


def span(name: str, start: float, ms: float, busy_ms: float, tid: int = 1, **args: object) -> dict[str, Any]:
    return {"name": name, "ts": 1e3 * start, "dur": 1e3 * ms, "tdur": 1e3 * busy_ms, "tid": tid, "args": args}


FRAME = [
    span("event", 1, 1, 0.5),
    span("update", 2, 5, 4),
    span("upload", 9, 1, 0.25, what="nodes"),
    span("place", 8, 3, 1),
    span("upload", 12, 1, 0.5, what="picture"),
    span("canvas", 8, 8, 3),
    span("update", 3, 1, 1, tid=2),
    span("frame", 0, 20, 10),
]


def test_a_frame_is_split_and_nothing_counts_twice() -> None:
    later = [{**event, "ts": event["ts"] + 1e5} for event in FRAME]
    frames = split_frames([*FRAME, *later])
    assert len(frames) == 2
    for frame in frames:
        assert (frame.ms, frame.busy_ms) == (20, 10)
        assert frame.parts == {"input": 0.5, "solve": 4, "place": 0.75, "upload": 0.75, "draw": 1.5, "imgui": 2.5}
        assert sum(frame.parts.values()) == frame.busy_ms


def test_frames_are_summed_up_by_median_and_95th_percentile() -> None:
    frames = split_frames([span("frame", 100 * i, i, i / 2) for i in range(101)])
    found = summarise(frames)
    assert (found["frames"], found["ms"], found["p95_ms"]) == (101, 50, 95)
    assert (found["busy_ms"], found["busy_p95_ms"]) == (25, 47.5)
    assert summarise([])["ms"] == 0


@pytest.mark.parametrize("count", [4, 200])
def test_discs_cover_an_eighth_and_do_not_touch(count: int) -> None:
    mask = discs(count)
    assert cv2.connectedComponents(mask)[0] - 1 == count
    assert np.count_nonzero(mask) == pytest.approx(SIZE_PX[0] * SIZE_PX[1] / 8, rel=0.05)


def test_without_a_display_it_says_what_it_needs(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert main(["bench", "--quick", "--only", "window"]) == 2
    assert "needs a display" in capsys.readouterr().err
