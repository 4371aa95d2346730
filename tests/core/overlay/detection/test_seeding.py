"""Which of several seeds are tried, and which of several grown lattices is the pattern's."""

from dataclasses import replace

import numpy as np
import pytest

from core.arrays import Floats
from core.overlay.detection import seeding
from core.overlay.detection.alignment import PatchFrames
from core.overlay.detection.correlation import Proposal
from core.overlay.detection.lattice import LEAST_VERTICES, Lattice
from core.overlay.detection.seeding import (
    NEARLY,
    TRIAL_VERTICES,
    TURN,
    NoPatternError,
    bend_px,
    divides,
    finalists,
    flat_canvas,
    grow_proposals,
    holds,
    in_turn,
    is_grown,
    merit,
    part_of,
    rank,
)
from core.progress import Job, Progress, run

FINE = np.array([[15.0, 2.0], [-1.0, 12.0]])


def lattice(basis: Floats, columns: int, rows: int, score: float, *, uneven_px: float = 0.0) -> Lattice:
    keys = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), -1).reshape(-1, 2)
    points = 30 + keys @ basis.T
    points[:, 0] += uneven_px * np.where(keys.sum(1) % 2, 1.0, -1.0)
    frames = PatchFrames(points, np.tile(basis, (len(keys), 1, 1)), np.full(len(keys), score))
    return Lattice(keys, frames)


def keep(small: Lattice) -> Job[Lattice]:
    yield Progress(0.0, "")
    return small


def test_dots_in_a_row_are_no_pattern() -> None:
    y, x = np.indices((100, 260)).astype(np.float32)
    rows = {count: np.abs(y - 20) < 20 * (count - 1) + 9 for count in (1, 4)}
    for count, inside in rows.items():
        dots = inside * np.exp(-((((x + 10) % 20 - 10) ** 2) + (((y - 20 + 10) % 20) - 10) ** 2) / 18)
        canvas = flat_canvas(np.repeat(0.3 + 0.5 * dots[..., None], 3, 2), np.ones(dots.shape, bool))
        proposals = [Proposal(np.array([120.0, 20.0]), 20 * np.eye(2), 1.0)]
        if count == 1:
            with pytest.raises(NoPatternError):
                run(grow_proposals(canvas, proposals))
        else:
            assert len(run(grow_proposals(canvas, proposals))[0]) > LEAST_VERTICES


@pytest.mark.parametrize(("grown", "tried"), [(TRIAL_VERTICES, 1), (TRIAL_VERTICES - 1, 3)])
def test_what_a_small_lattice_has_grown_over_is_not_tried_again(
    grown: int, tried: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    small = lattice(FINE, 5, 5, 0.8)[np.arange(grown)]
    trials: list[Proposal] = []

    def try_out(_: object, proposal: Proposal) -> Lattice:
        trials.append(proposal)
        return small

    monkeypatch.setattr(seeding, "try_out", try_out)
    monkeypatch.setattr(seeding, "full_grown", lambda *_: keep(small))
    places = small.frames.points[[0, 7, 13]] + 2.0
    proposals = [Proposal(place, FINE @ np.array([[1, 1], [0, 1]]), 1.0) for place in places]
    run(grow_proposals(flat_canvas(np.zeros((9, 9, 3)), np.ones((9, 9), bool)), proposals))
    assert len(trials) == tried


@pytest.mark.parametrize(
    "beside", [Proposal(np.array([300.0, 30.0]), FINE, 1.0), Proposal(np.full(2, 40.0), 1.3 * FINE, 1.0)]
)
def test_other_texels_and_other_places_are_tried(beside: Proposal) -> None:
    assert holds(lattice(FINE, 5, 5, 0.8), replace(beside, point=np.full(2, 40.0), basis=FINE))
    assert not holds(lattice(FINE, 5, 5, 0.8), beside)


def test_every_size_has_its_turn_before_the_best_size_goes_on() -> None:
    sides = [20.0] * 5 + [21.0] * 2 + [60.0] * 2
    proposals = [Proposal(np.array([k, 0.0]), side * np.eye(2), 1 - 0.01 * k) for k, side in enumerate(sides)]
    order = [int(proposal.point[0]) for proposal in in_turn(proposals)]
    assert order == [*range(TURN), 7, 8, *range(TURN, 7)]


def test_of_a_lattice_and_one_of_several_of_its_texels_the_finer_one_is_taken() -> None:
    fine, coarse = lattice(FINE, 12, 12, 0.8), lattice(FINE @ np.diag([4, 1]), 3, 12, 0.82)
    assert merit(fine) < merit(coarse)
    assert rank([coarse, fine], LEAST_VERTICES)[0] is fine
    elsewhere = lattice(1.37 * FINE @ np.diag([2, 1]), 5, 7, 0.82)
    assert NEARLY * merit(elsewhere) < merit(fine) < merit(elsewhere)
    assert not divides(fine, elsewhere)
    assert rank([elsewhere, fine], LEAST_VERTICES)[0] is elsewhere


def test_a_finer_lattice_that_lies_unevenly_or_is_much_less_alike_is_not_taken() -> None:
    coarse = lattice(FINE @ np.diag([4, 1]), 3, 12, 0.82)
    uneven, unlike = lattice(FINE, 12, 12, 0.8, uneven_px=0.8), lattice(FINE, 12, 12, 0.75)
    assert bend_px(uneven) > 1 > bend_px(coarse)
    for other in (uneven, unlike):
        assert divides(other, coarse)
        assert rank([coarse, other], LEAST_VERTICES)[0] is coarse


def test_a_finer_lattice_of_a_part_of_the_cloth_is_not_taken() -> None:
    coarse = lattice(FINE @ np.diag([4, 1]), 6, 24, 0.8)
    whole, half = lattice(FINE, 24, 24, 0.9), lattice(FINE, 24, 12, 0.92)
    assert merit(coarse) > merit(half) > NEARLY * merit(coarse)
    assert divides(whole, coarse)
    assert not divides(half, coarse)
    assert rank([coarse, half], LEAST_VERTICES)[0] is coarse


def test_a_finer_lattice_may_lie_less_evenly_if_its_texels_are_clearly_more_alike() -> None:
    coarse = lattice(FINE @ np.diag([4, 1]), 3, 12, 0.82, uneven_px=1.0)
    for score, uneven_px, taken in ((0.85, 0.8, True), (0.83, 0.8, False), (0.85, 1.2, False)):
        fine = lattice(FINE, 12, 10, score, uneven_px=uneven_px)
        assert bend_px(fine) > bend_px(coarse)
        assert merit(fine) < merit(coarse)
        assert (rank([coarse, fine], LEAST_VERTICES)[0] is fine) is taken


def test_a_small_lattice_is_part_of_a_grown_one_if_it_lies_in_it_and_spans_its_texels_at_one_phase() -> None:
    grown = lattice(FINE, 12, 12, 0.8)

    def small(basis: Floats, place: tuple[float, float]) -> Lattice:
        found = lattice(basis, 4, 4, 0.8)
        return Lattice(found.keys, replace(found.frames, points=found.frames.points + np.array(place)))

    sheared = FINE @ np.array([[1.0, 1.0], [0.0, 1.0]])
    assert part_of(small(FINE, (37.0, 41.0)), grown)
    assert part_of(small(sheared, (37.0, 41.0)), grown)
    assert part_of(small(1.1 * FINE @ np.array([[0.0, 1.0], [1.0, 0.0]]), (30.0, 30.0)), grown)
    assert not part_of(small(FINE @ np.diag([2, 1]), (37.0, 41.0)), grown)
    assert not part_of(small(1.5 * FINE, (30.0, 30.0)), grown)
    assert not part_of(small(FINE, (170.0, 41.0)), grown)
    uneven = lattice(FINE, 6, 6, 0.8, uneven_px=0.25 * FINE[0, 0])
    assert not part_of(uneven, grown)


def test_a_part_of_a_lattice_that_ended_soon_is_grown_too() -> None:
    part, far, soon = lattice(FINE, 5, 5, 0.8), lattice(FINE, 12, 12, 0.8), lattice(FINE, 6, 6, 0.8)
    assert part_of(part, far)
    assert part_of(part, soon)
    assert is_grown(part, [soon, far])
    assert not is_grown(part, [soon])


def test_the_best_small_lattice_of_each_size_is_grown_before_others_of_that_size() -> None:
    scores = (0.9, 0.86, 0.84, 0.88, 0.6)
    small = [lattice(side * np.eye(2), 5, 5, score) for side, score in zip((20, 21, 40, 20, 80), scores, strict=True)]
    assert [round(each.frames.scores[0], 2) for each in finalists(small)] == [0.9, 0.84, 0.88, 0.86]
