import os

import cv2
import numpy as np
import pytest
from scipy import sparse

from core.arrays import SingularSystemError
from core.linalg.cholmod import kernels
from core.linalg.factor import Entries, Factor


def matrix(seed: int, n: int = 60) -> sparse.csc_array:
    half = sparse.random_array((n, n), density=0.1, rng=np.random.default_rng(seed))
    return sparse.csc_array(half @ half.T + sparse.eye_array(n) * 0.5)


def test_solves_several_columns_at_once() -> None:
    A = matrix(0)
    b = np.random.default_rng(1).random((60, 2))
    assert np.abs(A @ Factor(A).solve(b) - b).max() < 1e-12


def test_the_two_halves_make_a_solve() -> None:
    A = matrix(2)
    factor = Factor(A)
    a, b = np.random.default_rng(3).random((2, 60))
    assert np.allclose(factor.backward(factor.forward(b)), factor.solve(b))
    assert np.isclose(factor.forward(a) @ factor.forward(b), a @ factor.solve(b))


def test_new_values_need_no_new_analysis() -> None:
    A = matrix(4)
    factor = Factor(A)
    lower = sparse.csc_array(sparse.tril(A))
    b = np.ones(60)
    assert np.allclose(factor.factorise(lower.data * 4).solve(b), np.linalg.solve(A.toarray() * 4, b))


def test_entries_at_one_place_are_added_up() -> None:
    A = sparse.coo_array(sparse.tril(matrix(3)))
    halves = Entries(np.tile(A.row, 2), np.tile(A.col, 2), np.tile(A.data / 2, 2), 60)
    b = np.arange(60.0)
    np.testing.assert_allclose(Factor(halves).solve(b), Factor(matrix(3)).solve(b))


def test_a_hermitian_system() -> None:
    A = sparse.csc_array(matrix(5) + 0.1j * sparse.triu(matrix(5), 1) - 0.1j * sparse.tril(matrix(5), -1))
    b = np.random.default_rng(6).random(60) + 1j
    factor = Factor(A)
    assert np.abs(A @ factor.solve(b) - b).max() < 1e-11
    assert np.allclose(factor.backward(factor.forward(b)), factor.solve(b))


def test_an_unknown_without_equation_is_named() -> None:
    A = np.eye(20)
    A[11, 11] = 0
    with pytest.raises(SingularSystemError) as fault:
        Factor(sparse.csc_array((A.ravel()[::21], (range(20), range(20)))))
    assert fault.value.nodes.tolist() == [11]


def test_tells_its_size() -> None:
    assert "60 unknowns" in repr(Factor(matrix(8)))


@pytest.mark.parametrize("newer", [True, False])
def test_kernels_suit_the_processor_while_the_solver_is_loaded(newer: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cv2, "checkHardwareSupport", lambda _feature: newer)
    monkeypatch.delenv("OPENBLAS_CORETYPE", raising=False)
    with kernels():
        assert os.environ.get("OPENBLAS_CORETYPE") == ("Haswell" if newer else None)
    assert "OPENBLAS_CORETYPE" not in os.environ


def test_kernels_that_the_user_has_named_stand(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENBLAS_CORETYPE", "Zen")
    with kernels():
        assert os.environ["OPENBLAS_CORETYPE"] == "Zen"
    assert os.environ["OPENBLAS_CORETYPE"] == "Zen"
