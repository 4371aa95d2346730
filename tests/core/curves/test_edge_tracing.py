"""The timeline: what a span says of the work in it."""

import threading
import time

import pytest

from core import tracing


@pytest.fixture(autouse=True)
def recording(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tracing, "_events", [])


def test_a_span_has_the_processor_time_of_its_own_thread() -> None:
    busy = threading.Thread(target=spin, args=(0.02,))
    with tracing.span("waiting", what="a thread"):
        busy.start()
        busy.join()
    (span,) = tracing.events()
    assert span["args"] == {"what": "a thread"}
    assert float(str(span["tdur"])) < 10_000 < float(str(span["dur"]))


def test_work_counts() -> None:
    with tracing.span("work"):
        spin(0.002)
    assert float(str(tracing.events()[0]["tdur"])) >= 2000


def spin(seconds: float) -> None:
    """Use up processor time."""
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass
