"""A map that fits into a frame is worked out while the panels are laid out, and shown in the same frame."""

import threading

import numpy as np
import pytest

from app.bench.window import open_window
from app.ui.panels.warp import WarpPanel
from core.document.document import Document, Pin
from core.document.map_solver import MapSolver
from core.mapping.result import Warped
from tests.app.driver import document

AT_MOST_S = 20.0


def pinned() -> Document:
    start = document(600, 400, cell_px=20.0)
    return start.changed(pins=tuple(Pin(place, place) for place in ((0.2, 0.45), (0.8, 0.6))))


def test_the_panels_are_laid_out_meanwhile(monkeypatch: pytest.MonkeyPatch) -> None:
    laid_out, frame, draw = threading.Event(), MapSolver.frame, WarpPanel.draw
    in_time: list[bool] = []

    def wait(solver: MapSolver, asked: Document) -> Warped:
        in_time.append(laid_out.wait(AT_MOST_S))
        return frame(solver, asked)

    def lay_out(panel: WarpPanel) -> None:
        draw(panel)
        laid_out.set()

    monkeypatch.setattr(WarpPanel, "draw", lay_out)
    with open_window(pinned()) as hand:
        hand.rest()
        monkeypatch.setattr(MapSolver, "frame", wait)
        for _ in hand.drag(5):
            laid_out.clear()
            hand.draw()
    assert len(in_time) >= 4
    assert all(in_time)


def test_every_frame_of_a_drag_shows_where_the_hand_is() -> None:
    with open_window(pinned()) as hand:
        hand.rest()
        events = hand.drag(5)
        next(events)
        for _ in events:
            hand.draw()
            scene, answer = hand.shell._scene, hand.editor.answer
            assert answer.document is hand.editor.document
            assert scene is not None
            assert np.array_equal(scene.warped, answer.warped)
            assert not hand.editor.live.is_coming
