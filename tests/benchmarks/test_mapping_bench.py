import math

from app.bench.mapping import PAPER, SIZES, measure

MEASURED = {
    "setup_ms",
    "factor_ms",
    "rhs_ms",
    "solve_ms",
    "drag_preset_ms",
    "drag_handles_ms",
    "stroke_ms",
    "unfold_ms",
}
BARE = {
    "cholmod_factor_ms",
    "cholmod_solve_ms",
    "cholmod_stroke_ms",
    "superlu_factor_ms",
    "superlu_solve_ms",
    "libigl_arap_ms",
}


def test_a_record_holds_every_figure_of_the_contract() -> None:
    (record,) = measure([(30, 40)], repeats=2)
    assert record["grid"] == [30, 40]
    assert set(record) == MEASURED | {"grid", "bare", "paper"}
    assert set(record["bare"]) == BARE
    assert record["paper"] == dict.fromkeys(("setup_s", "factor_s", "rhs_s", "solve_s"))
    taken = [record[key] for key in MEASURED] + list(record["bare"].values())
    assert all(figure is None or (math.isfinite(figure) and figure > 0) for figure in taken)
    assert record["solve_ms"] is not None


def test_the_table_of_the_paper_is_among_the_sizes() -> None:
    assert set(PAPER) <= set(SIZES)
    assert {(500, 500), (1000, 1000)} <= set(SIZES)


def test_a_solve_is_much_cheaper_than_a_factorisation() -> None:
    (record,) = measure([(120, 120)], repeats=5)
    assert record["rhs_ms"] + record["solve_ms"] < record["setup_ms"] + record["factor_ms"]
