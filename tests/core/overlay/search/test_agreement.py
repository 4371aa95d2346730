"""Finds that lie alike confirm one another, whatever their steps are."""

from dataclasses import replace

import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.registration.cloth import Fit, FittedCloth
from core.overlay.registration.evidence import Evidence
from core.overlay.search.agreement import agreement
from core.overlay.search.finding import Find, confirm

TURN = np.array([[1.0, 0.5], [-0.5, 2.0]])


def moved(fit: Fit, uv: Floats) -> Fit:
    return replace(fit, pieces=(replace(fit.pieces[0], uv=uv), *fit.pieces[1:]))


def bent(fit: Fit) -> Fit:
    uv = fit.pieces[0].uv
    return moved(fit, uv + 0.4 * np.sin(9 * uv[..., ::-1]))


def half(fit: Fit) -> Fit:
    cells = fit.pieces[0].cells.copy()
    cells[:, cells.shape[1] // 2 :] = False
    return replace(fit, pieces=(replace(fit.pieces[0], cells=cells),))


def test_coordinates_agree_but_for_an_affine_map(followed: tuple[FittedCloth, Fit]) -> None:
    cloth, fit = followed
    assert agreement((cloth, fit), (cloth, fit)) == 1
    assert agreement((cloth, fit), (cloth, moved(fit, fit.pieces[0].uv @ TURN.T + 0.3))) == 1
    assert agreement((cloth, fit), (cloth, bent(fit))) < 0.5


def test_the_smaller_one_has_to_lie_as_the_larger_one(followed: tuple[FittedCloth, Fit]) -> None:
    cloth, fit = followed
    for both in (((cloth, fit), (cloth, half(fit))), ((cloth, half(fit)), (cloth, fit))):
        assert agreement(*both) == pytest.approx(1, abs=0.05)
    assert agreement((cloth, fit), (cloth, bent(half(fit)))) < 0.5


@pytest.mark.parametrize(
    ("share", "covers", "wrong", "confirmed"),
    [(0.3, 1.0, False, True), (0.01, 1.0, False, False), (0.3, 0.5, False, False), (0.3, 1.0, True, False)],
)
def test_finds_that_explain_something_of_most_of_the_cloth_and_agree_leave_no_doubt(
    followed: tuple[FittedCloth, Fit], share: float, covers: float, *, wrong: bool, confirmed: bool
) -> None:
    cloth, fit = followed
    known = Find(cloth, fit, Evidence(1.0, 0.3))
    other = bent(fit) if wrong else fit
    new = Find(cloth, half(other) if covers < 1 else other, Evidence(1.0, share))
    assert not known.is_clear
    assert [find.is_clear for find in confirm([known], new)] == [confirmed, confirmed]
    assert [find.confirmed for find in confirm([known, known], new)] == [confirmed] * 3
