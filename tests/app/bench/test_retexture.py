"""The retexture table of `weft bench` has the records that it promises."""

import pytest

from app.bench.retexture import HIGHER, PAPER, Case, arch, measure


def test_a_record_holds_both_times_and_the_papers() -> None:
    (record,) = measure((Case("small", (120, 100), (21, 13), 88.0),), runs=1)
    assert record["name"] == "small"
    assert record["size"] == [100, 120]
    assert record["paper_s"] == 88
    assert 0 < record["first_s"] < record["total_s"]
    assert record["drag_ms"] > 0


@pytest.mark.parametrize(("case", "growth"), [(PAPER[0], 1.25), (HIGHER, 1.5)])
def test_the_curve_grows_by_a_quarter_or_by_half(case: Case, growth: float) -> None:
    curve = arch(*case.size, case.rise)
    assert curve.target is not None
    assert abs(curve.target.length / curve.source.length - growth) < 0.05
    assert len(PAPER) == 10
