"""The retexture table of `weft bench` has the records that it promises."""

from app.bench.retexture import PAPER, Case, arch, measure


def test_a_record_holds_both_times_and_the_papers() -> None:
    (record,) = measure((Case("small", (120, 100), (21, 13), 88.0),), runs=1)
    assert record["name"] == "small"
    assert record["size"] == [100, 120]
    assert record["paper_s"] == 88
    assert 0 < record["first_s"] < record["total_s"]
    assert record["drag_ms"] > 0


def test_the_curve_grows_by_a_quarter() -> None:
    curve = arch(500, 692)
    assert curve.target is not None
    assert 1.2 < curve.target.length / curve.source.length < 1.3
    assert len(PAPER) == 10
