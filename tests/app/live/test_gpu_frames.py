"""Frames on large grids come from the solver that is found for them, final answers never do."""

import logging
import threading
from typing import Any

import numpy as np
import pytest

import app.live.warp
from app.live.gpu_frames import MakeSolver
from app.live.warp import LiveWarp
from app.model.jobs import Jobs
from core.arrays import Floats
from core.document.document import Document, Pin
from core.document.map_solver import MapSolver, settle_map
from core.linalg.multifrontal import GridFactor
from core.mapping.handles.plate import HandleField
from core.progress import run
from core.rasters.raster import Raster
from tests.app.driver import Clock, document


class Counted(GridFactor):
    """A factor that tells how often it was solved with."""

    solves = 0

    def backward(self, y: Floats) -> Floats:
        Counted.solves += 1
        return super().backward(y)


class Broken(GridFactor):
    """A driver that takes no system."""

    def factorise(self, values: Floats) -> GridFactor:
        raise RuntimeError("out of memory")


@pytest.fixture(autouse=True)
def all_grids_are_large(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(app.live.warp, "INLINE_NODES", 0)
    monkeypatch.setattr(Counted, "solves", 0)


def masked() -> Document:
    mask = np.zeros((150, 200), np.uint8)
    mask[40:90, 60:120] = 255
    return document().changed(mask=Raster.from_array(mask)).with_warp(preset="arc", bend=30)


def live_with(make: MakeSolver | None) -> tuple[LiveWarp, Clock, Jobs]:
    jobs, clock = Jobs.inline(), Clock()
    return LiveWarp(jobs, clock=clock, gpu=lambda: make), clock, jobs


def frame(live: LiveWarp, jobs: Jobs, shown: Document) -> None:
    live.update(shown)
    jobs.drain()


def test_what_moves_is_answered_by_the_solver_that_is_found() -> None:
    live, _, jobs = live_with(Counted)
    frame(live, jobs, masked())
    assert live.answer is not None
    assert Counted.solves == 1
    assert np.array_equal(live.answer.warped, MapSolver().frame(masked()).warped)


def test_what_rests_is_answered_by_the_processor() -> None:
    live, clock, jobs = live_with(Counted)
    shown = masked()
    frame(live, jobs, shown)
    clock.now += app.live.warp.REST_S
    frame(live, jobs, shown)
    assert live.answer is not None
    assert live.is_settled
    assert Counted.solves == 1
    assert np.array_equal(live.answer.warped, run(settle_map(shown)).warped)


def test_handles_move_the_picture_as_it_has_settled() -> None:
    live, clock, jobs = live_with(Counted)
    shown = masked().with_warp(bend=90, keep="rigid")
    frame(live, jobs, shown)
    clock.now += app.live.warp.REST_S
    frame(live, jobs, shown)
    settled = live.answer
    assert settled is not None
    frame(live, jobs, shown.changed(pins=(Pin((0.8, 0.8), (0.82, 0.83)),)))
    answer = live.answer
    assert answer is not None
    assert answer.result is not None
    assert settled.result is not None
    assert answer.result.reference is settled.result.reference


@pytest.mark.parametrize("make", [Counted, None])
def test_the_live_thread_takes_the_rotation_of_the_next_frame_once_it_has_given_this_one(
    make: MakeSolver | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    live, _, jobs = live_with(make)
    are_beside: list[bool] = []
    turn = HandleField.turn

    def noted(self: HandleField, *arguments: Any, **named: Any) -> Any:
        are_beside.append(threading.current_thread().name.startswith("rotation"))
        return turn(self, *arguments, **named)

    monkeypatch.setattr(HandleField, "turn", noted)
    for x in range(6):
        frame(live, jobs, masked().changed(pins=(Pin((0.8, 0.8), (0.82 + 0.01 * x, 0.83)),)))
    # The first frame has none before it, and the second one begins to go on from it.
    assert are_beside[:6] == [False] * 2 + [True] * 4


def test_a_solver_that_fails_is_not_asked_again(caplog: pytest.LogCaptureFixture) -> None:
    live, _, jobs = live_with(Broken)
    with caplog.at_level(logging.CRITICAL, "weft"):
        frame(live, jobs, masked())
        frame(live, jobs, masked().with_warp(bend=31))
    assert live.answer is not None
    assert live.fault is None
    assert np.array_equal(live.answer.warped, MapSolver().frame(masked().with_warp(bend=31)).warped)


def test_small_grids_are_answered_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(app.live.warp, "INLINE_NODES", 60_000)
    live, _, jobs = live_with(Counted)
    frame(live, jobs, masked())
    frame(live, jobs, masked().with_warp(bend=31))
    assert not Counted.solves
