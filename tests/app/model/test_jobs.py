from collections.abc import Callable
from queue import SimpleQueue

import pytest

from app.model.jobs import InlineExecutor, Jobs, Task
from core.notices import notice
from core.progress import Job, Progress
from tests.app.driver import Later


def counting(to: int, note: Callable[[int], None] = lambda i: None) -> Job[int]:
    for i in range(to):
        note(i)
        yield Progress(i / to)
    return to


def task(steps: Callable[[], Job[int]], got: list[object], *, edits: bool = False) -> Task[int]:
    return Task("count", steps, got.append, got.append, edits=edits)


def test_a_result_waits_for_drain() -> None:
    jobs, got = Jobs.inline(), []  # type: tuple[Jobs, list[object]]
    jobs.start(task(lambda: counting(3), got))
    assert got == []
    assert len(jobs.long_jobs) == 1
    assert jobs.drain() == 1
    assert got == [3]
    assert jobs.is_idle


def test_in_a_slot_the_latest_wins_and_the_others_are_dropped() -> None:
    hand, got = Later(), []  # type: tuple[Later, list[object]]
    jobs = Jobs(live=hand, long=InlineExecutor())
    for n in (1, 2, 3):
        jobs.submit("unfold", task(lambda n=n: counting(n), got))  # type: ignore[misc]
    hand.run()
    jobs.drain()
    assert got == [3]
    assert jobs.is_idle


def test_a_submission_stops_the_running_generator_at_its_next_yield() -> None:
    hand, got, seen = Later(), [], []  # type: tuple[Later, list[object], list[int]]
    jobs = Jobs(live=hand, long=InlineExecutor())

    def note(i: int) -> None:
        seen.append(i)
        if i == 1:
            jobs.submit("slot", task(lambda: counting(5), got))

    jobs.submit("slot", task(lambda: counting(100, note), got))
    hand.run()
    jobs.drain()
    assert seen == [0, 1]
    assert got == [5]


def test_a_cancelled_job_delivers_nothing_and_closes_its_generator() -> None:
    hand, got, closed = Later(), [], []  # type: tuple[Later, list[object], list[bool]]
    jobs = Jobs(live=InlineExecutor(), long=hand)

    def steps() -> Job[int]:
        try:
            yield Progress(0.0)
            jobs.cancel_all()
            yield Progress(0.5)
            pytest.fail("ran on after it was cancelled")
        finally:
            closed.append(True)
        return 1

    ticket = jobs.start(task(steps, got))
    hand.run()
    jobs.drain()
    assert (got, closed, ticket.state) == ([], [True], "cancelled")


def test_an_exception_travels_with_the_result() -> None:
    jobs, got = Jobs.inline(), []  # type: tuple[Jobs, list[object]]

    def steps() -> Job[int]:
        yield Progress(0.1)
        raise ValueError("no good")

    ticket = jobs.start(task(steps, got))
    jobs.drain()
    assert [str(fault) for fault in got] == ["no good"]
    assert ticket.state == "failed"


def test_edits_wait_while_they_are_held() -> None:
    jobs, got = Jobs.inline(), []  # type: tuple[Jobs, list[object]]
    jobs.start(task(lambda: counting(1), got, edits=True))
    jobs.start(task(lambda: counting(2), got))
    jobs.drain(hold_edits=True)
    assert got == [2]
    jobs.drain()
    assert got == [2, 1]


def test_threads_wake_the_ui_and_end() -> None:
    woken: SimpleQueue[bool] = SimpleQueue()
    jobs, got = Jobs(wake=lambda: woken.put(True)), []  # type: tuple[Jobs, list[object]]
    jobs.start(task(lambda: counting(4), got))
    jobs.submit("slot", task(lambda: counting(7), got))
    while not jobs.is_idle:
        woken.get(timeout=10)
        jobs.drain()
    jobs.close()
    assert sorted(map(str, got)) == ["4", "7"]


def test_a_quiet_task_asks_for_frames_for_its_previews_and_its_end_only() -> None:
    def steps() -> Job[int]:
        for preview in (None, None, "first", None):
            yield Progress(0.0, preview=preview)
        return 1

    for quiet, frames in ((False, 5), (True, 2)):
        woken: list[int] = []
        jobs = Jobs(live=Later(), long=InlineExecutor())
        jobs.wake = lambda jobs=jobs, woken=woken: woken.append(jobs.drain())  # type: ignore[misc]
        jobs.start(Task("work", steps, lambda _: None, lambda _: None, quiet=quiet))
        assert len(woken) == frames


def test_what_a_job_says_of_its_work_can_be_taken_once() -> None:
    def steps() -> Job[int]:
        notice("left something out")
        yield Progress(0.5)
        notice("left something out")
        return 1

    jobs, got = Jobs.inline(), []  # type: tuple[Jobs, list[object]]
    jobs.start(task(steps, got))
    jobs.drain()
    assert jobs.take_notices() == ["left something out"]
    assert jobs.take_notices() == []


def test_a_result_that_cannot_be_taken_costs_no_other() -> None:
    jobs, got, failed = Jobs.inline(), [], []  # type: tuple[Jobs, list[object], list[object]]

    def refuse(_: int) -> None:
        raise ZeroDivisionError("no")

    jobs.start(Task("bad", lambda: counting(1), refuse, failed.append))
    jobs.start(task(lambda: counting(2), got, edits=True))
    jobs.start(task(lambda: counting(3), got))
    jobs.drain(hold_edits=True)
    assert [str(fault) for fault in failed] == ["no"]
    assert got == [3]
    jobs.drain()
    assert got == [3, 2]
    assert jobs.is_idle
