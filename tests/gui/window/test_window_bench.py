"""The window's frames are measured in the real window."""

import threading
from typing import Any

import pytest
from imgui_bundle import hello_imgui

from app.bench.window import PARTS, _document, measure, open_window
from core.mapping.handles.plate import HandleField


def test_every_deed_is_played_and_measured_with_and_without_draw_calls() -> None:
    records = measure((4,), frames=4)
    assert [(r["draws"], r["deed"]) for r in records] == [
        (draws, deed) for draws in (True, False) for deed in ("drag", "brush", "zoom", "idle")
    ]
    for record in records:
        assert record["frames"] == 4
        assert record["ms"] > 0
        assert tuple(record["parts"]) == PARTS
    by_deed = {record["deed"]: record for record in records if not record["draws"]}
    assert by_deed["drag"]["parts"]["solve"] > by_deed["idle"]["parts"]["solve"]
    assert by_deed["zoom"]["parts"]["upload"] > 0
    assert by_deed["idle"]["parts"]["upload"] == 0


def test_what_the_next_frame_of_a_drag_needs_is_begun_once_the_picture_is_drawn(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    beside = []
    turn = HandleField.turn

    def watched(self: HandleField, *arguments: Any, **named: Any) -> Any:
        beside.append(threading.current_thread() is not threading.main_thread())
        return turn(self, *arguments, **named)

    with open_window(_document(4), draws=False) as hand:
        hand.rest()
        monkeypatch.setattr(HandleField, "turn", watched)
        for _ in hand.drag(8):
            hello_imgui.manual_render.render()
        hand.let_go()
    assert beside[-4:] == [True] * 4
