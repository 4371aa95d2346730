"""BLAS and OpenCV are held to one thread while anyone needs it, and let go between the steps of a job."""

import threading
from collections.abc import Iterator

import cv2
import pytest
from threadpoolctl import ThreadpoolController, threadpool_info, threadpool_limits

from core.linalg.blas import on_one_thread, one_thread
from core.progress import Job, Progress


@pytest.fixture(autouse=True)
def _two_threads() -> Iterator[None]:
    before = cv2.getNumThreads()
    cv2.setNumThreads(2)
    with threadpool_limits(2, user_api="blas"):
        yield
    cv2.setNumThreads(before)


def threads() -> int:
    """Return how many threads the libraries of BLAS use at most; some are built for one."""
    return max(int(library["num_threads"]) for library in threadpool_info() if library["user_api"] == "blas")


def test_it_is_held_until_the_last_one_lets_go() -> None:
    first, second = one_thread(), one_thread()
    assert threads() == 2
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert threads() == 1
    second.__exit__(None, None, None)
    assert threads() == 2


def test_any_thread_holds_it_and_any_lets_go() -> None:
    seen: list[int] = []

    def hold() -> None:
        with one_thread():
            seen.append(threads())

    with one_thread():
        pass
    other = threading.Thread(target=hold)
    other.start()
    other.join()
    assert seen == [1]
    assert threads() == 2
    hold()
    assert seen == [1, 1]
    assert threads() == 2


def test_what_has_one_thread_is_left_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    one_thread()
    monkeypatch.setattr(ThreadpoolController, "limit", None)
    with threadpool_limits(1, user_api="blas"), one_thread():
        assert threads() == 1


def test_it_is_let_go_after_a_fault() -> None:
    with pytest.raises(ZeroDivisionError), one_thread():
        _ = 1 / 0
    assert threads() == 2


def test_a_job_holds_it_in_its_steps_alone() -> None:
    def steps() -> Job[tuple[int, int]]:
        yield Progress(0.5, "working")
        return threads(), cv2.getNumThreads()

    job = on_one_thread(steps())
    next(job)
    assert (threads(), cv2.getNumThreads()) == (2, 2)
    with pytest.raises(StopIteration) as end:
        next(job)
    assert end.value.value == (1, 1)
    assert (threads(), cv2.getNumThreads()) == (2, 2)
