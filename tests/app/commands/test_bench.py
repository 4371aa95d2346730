"""`weft bench` prints what scripts rely on."""

import json

import pytest

from app.cli import main
from app.commands.bench import table


def test_mapping_records_have_the_promised_fields(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--json", "--quick", "--only", "mapping"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert "cores" in printed["machine"]
    assert [record["grid"] for record in printed["mapping"]] == [[50, 100], [100, 100], [100, 200], [200, 200]]
    for record in printed["mapping"]:
        assert record["paper"].keys() == {"setup_s", "factor_s", "rhs_s", "solve_s"}
        times = [record[f"{part}_ms"] for part in ("setup", "factor", "rhs", "solve", "drag_preset", "stroke")]
        assert all(time > 0 for time in times)
        assert record["bare"]["cholmod_solve_ms"] > 0
        assert record["bare"]["superlu_factor_ms"] > record["bare"]["superlu_solve_ms"]


def test_a_table_has_a_column_for_every_field() -> None:
    records = [{"grid": [2, 3], "bare": {"solve_ms": 1.23456}}, {"grid": [4, 5], "bare": {"solve_ms": None}}]
    assert list(table(records)) == ["grid  bare.solve_ms", " 2x3          1.235", " 4x5              -"]
