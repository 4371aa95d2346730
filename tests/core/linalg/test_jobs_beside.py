import math
import os
import pickle
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import pytest

from core.arrays import CurveError
from core.linalg import jobs_beside
from core.linalg.beside import Process
from core.linalg.jobs_beside import HERE, PlannedJob, ProcessPool, run_meanwhile, use_all_processors
from core.overlay.detection.seeding import NoPatternError
from core.progress import Job, Progress, Steps, in_one_step, run

T = TypeVar("T")
NUMBER, LONG = (in_one_step, "counting", os.getpid), (in_one_step, "waiting", time.sleep, 600)


@pytest.fixture
def pool(monkeypatch: pytest.MonkeyPatch) -> Iterator[ProcessPool]:
    """Return a pool on a machine with two processors."""
    monkeypatch.setattr(jobs_beside, "count_processors", lambda: 2)
    with use_all_processors(), ProcessPool() as pool:
        yield pool


def on_another_thread(work: Callable[[], T]) -> T:
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(work).result()


def begun(job: PlannedJob[T]) -> PlannedJob[T]:
    """Return a job that has said something."""
    while not job._steps:
        time.sleep(0.01)
    return job


def process_of(job: PlannedJob[Any]) -> Process:
    """Return the process in which a long job has begun."""
    process = begun(job)._process
    assert process is not None
    return process


def test_without_leave_all_jobs_are_done_here() -> None:
    assert run(HERE.begin(*NUMBER).result()) == os.getpid()
    assert on_another_thread(lambda: run(ProcessPool().run(*NUMBER))) == os.getpid()


def test_what_is_begun_is_done_in_another_process_and_what_the_main_thread_asks_for_first_in_this_one(
    pool: ProcessPool,
) -> None:
    other, planned = begun(pool.begin(*NUMBER)), pool.plan(*NUMBER)
    assert run(planned.result()) == os.getpid() != run(other.result())


def test_the_main_thread_does_what_waits_for_a_process(pool: ProcessPool) -> None:
    process = process_of(pool.begin(*LONG))
    assert run(pool.begin(*NUMBER).result()) == os.getpid()
    assert process.runs


@pytest.mark.usefixtures("pool")
def test_another_thread_does_none_of_them() -> None:
    def work() -> set[int]:
        with ProcessPool() as pool:
            return {run(pool.run(*NUMBER)), *(run(job.result()) for job in [pool.begin(*NUMBER) for _ in range(3)])}

    numbers = on_another_thread(work)
    assert os.getpid() not in numbers
    assert len(numbers) <= 2


def test_steps_and_faults_come_through(pool: ProcessPool) -> None:
    steps = pool.begin(*NUMBER).result()
    assert {step.note for step in steps} <= {"", "counting"}
    failing = begun(pool.begin(in_one_step, "", math.sqrt, -1.0))
    with pytest.raises(ValueError, match="math domain"):
        run(failing.result())


def test_a_job_that_is_stopped_ends_with_its_process_and_the_next_one_has_another(pool: ProcessPool) -> None:
    long = pool.begin(*LONG)
    process = process_of(long)
    long.stop()
    assert not process.runs
    assert run(begun(pool.begin(*NUMBER)).result()) != os.getpid()


def test_all_jobs_end_with_the_pool(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs_beside, "count_processors", lambda: 3)
    with use_all_processors(), ProcessPool() as pool:
        processes = [process_of(pool.begin(*LONG)) for _ in range(2)]
        waiting = pool.begin(*NUMBER)
    assert not any(process.runs for process in processes)
    assert waiting._turn is not None
    assert waiting._turn.cancelled()


def test_faults_are_the_same_in_another_process() -> None:
    other = pickle.loads(pickle.dumps(CurveError(3, "it ends")))  # noqa: S301
    assert (type(other), str(other), other.number) == (CurveError, "curve 3: it ends", 3)
    assert str(pickle.loads(pickle.dumps(NoPatternError("there")))) == str(NoPatternError("there"))  # noqa: S301


def test_who_waits_for_a_step_can_turn_away(pool: ProcessPool) -> None:
    job = pool.begin(*LONG)
    process_of(job)
    steps = job.result()
    assert [next(steps).note for _ in range(3)] == ["waiting"] * 3
    steps.close()


def take_two_steps() -> Job[int]:
    yield Progress(0.0, "one")
    yield Progress(0.5, "two")
    return os.getpid()


@pytest.mark.parametrize("is_to_go_on", [True, False])
def test_alone_the_other_job_begins_when_the_first_has_ended_and_is_not_enough(*, is_to_go_on: bool) -> None:
    notes: list[str] = []
    job = run_meanwhile(HERE.plan(*NUMBER), HERE.plan(take_two_steps), lambda _: is_to_go_on)
    first, other = run(job, lambda step: notes.append(step.note))
    assert first == os.getpid()
    assert (other is not None) == is_to_go_on
    assert notes == ["counting", *(["one", "two"] if is_to_go_on else [])]


def test_the_other_job_is_done_while_the_first_is_in_another_process(pool: ProcessPool) -> None:
    first = pool.begin(in_one_step, "waiting", time.sleep, 0.2)
    going = iter(steps := Steps(run_meanwhile(first, pool.plan(take_two_steps), lambda _: True)))
    assert [next(going).note for _ in range(2)] == ["one", "two"]
    assert not first.is_over
    assert "waiting" in {step.note for step in going}
    assert steps.result == (None, jobs_beside.End(os.getpid()))


def test_the_other_job_is_stopped_where_the_first_is_enough(pool: ProcessPool) -> None:
    asked: list[int] = []

    def is_to_go_on(number: int) -> bool:
        asked.append(number)
        return False

    def wait_for_ever() -> Job[None]:
        while True:
            time.sleep(0.01)
            yield Progress(0.0)

    first, other = run(run_meanwhile(pool.begin(*NUMBER), pool.plan(wait_for_ever), is_to_go_on))
    assert (asked, other) == ([first], None)
    assert first != os.getpid()


def test_a_job_that_another_process_does_is_stopped_there_where_the_first_is_enough(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(jobs_beside, "count_processors", lambda: 3)
    with use_all_processors(), ProcessPool() as pool:
        first, long = pool.begin(in_one_step, "waiting", time.sleep, 0.5), pool.begin(*LONG)
        process = process_of(long)
        assert run(run_meanwhile(first, long, lambda _: False)) == (None, None)
        assert not process.runs


@pytest.mark.parametrize("is_beside", [True, False])
def test_what_a_job_is_for_is_let_go_of_though_its_pool_stays(pool: ProcessPool, *, is_beside: bool) -> None:
    planned = (pool if is_beside else HERE).begin(in_one_step, "", math.sqrt, 4.0)
    assert run(planned.result()) == 2.0
    assert planned._arguments == ()
