"""BLAS is held to one thread while a job works, and let go between its steps."""

from typing import Any

from threadpoolctl import threadpool_info, threadpool_limits

from core.blas import on_one_thread
from core.progress import Job, Progress, run


def threads() -> int:
    found: list[dict[str, Any]] = threadpool_info()
    return max(int(library["num_threads"]) for library in found if "numpy" in library["filepath"])


def test_a_job_has_one_thread_and_who_waits_for_it_as_many_as_before() -> None:
    def job() -> Job[int]:
        yield Progress(0.5, f"{threads()}")
        return threads()

    seen: list[tuple[str, int]] = []
    with threadpool_limits(2, "blas"):
        assert run(on_one_thread(job()), lambda step: seen.append((step.note, threads()))) == 1
        assert threads() == 2
    assert seen == [("1", 2)]
