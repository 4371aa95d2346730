from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import numpy as np
import pytest
from scipy import sparse

from core.arrays import SingularSystemError, WeftError
from core.linalg import factor as factors
from core.linalg.beside import process_of_thread
from core.linalg.factor import Factor

T = TypeVar("T")


@pytest.fixture(autouse=True)
def small_is_large(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(factors, "_LARGE", 10)


def beside(work: Callable[[], T]) -> T:
    """Return what `work` returns on another thread."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(work).result()


def matrix() -> sparse.csc_array:
    half = sparse.random_array((80, 80), density=0.1, rng=np.random.default_rng(0))
    return sparse.csc_array(half @ half.T + sparse.eye_array(80))


def test_a_large_factor_of_another_thread_is_in_another_process_and_has_the_same_bits() -> None:
    A, b = matrix(), np.random.default_rng(1).random((80, 2))
    lower = sparse.csc_array(sparse.tril(A))

    def work() -> list[Any]:
        factor, process = Factor(A), process_of_thread()
        assert process is not None
        asked = process._count
        found = [factor.solve(b), factor.forward(b), factor.backward(b), factor.indices]
        return [asked, *found, factor.factorise(2 * lower.data).solve(b)]

    asked, *found = beside(work)
    here = Factor(A)
    assert asked == 1
    assert process_of_thread() is None
    expected = [here.solve(b), here.forward(b), here.backward(b), here.indices]
    for one, other in zip(found, [*expected, here.factorise(2 * lower.data).solve(b)], strict=True):
        assert np.array_equal(one, other)


def test_a_singular_system_is_told_of_with_its_nodes() -> None:
    A = sparse.csc_array((np.where(np.arange(40) == 7, 0.0, 1.0), (range(40), range(40))))
    with pytest.raises(SingularSystemError) as caught:
        beside(lambda: Factor(A))
    assert caught.value.nodes.tolist() == [7]


def test_where_the_process_is_killed_the_next_factor_has_another_one() -> None:
    A, b = matrix(), np.ones(80)

    def work() -> tuple[bool, Any]:
        factor, process = Factor(A), process_of_thread()
        assert process is not None
        process._child.kill()
        process._child.wait()
        with pytest.raises(WeftError, match="ended"):
            factor.solve(b)
        return process_of_thread() is not process, Factor(A).solve(b)

    is_other, found = beside(work)
    assert is_other
    assert np.abs(A @ found - b).max() < 1e-12
