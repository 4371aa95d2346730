"""The window's frames are measured in the real window."""

from app.bench.window import PARTS, measure


def test_every_deed_is_played_and_measured_with_and_without_draw_calls() -> None:
    records = measure((4,), frames=4)
    assert [(r["draws"], r["deed"]) for r in records] == [
        (draws, deed) for draws in (True, False) for deed in ("drag", "brush", "zoom", "idle")
    ]
    for record in records:
        assert record["frames"] == 4
        assert record["ms"] > 0
        assert tuple(record["parts"]) == PARTS
    by_deed = {record["deed"]: record for record in records if not record["draws"]}
    assert by_deed["drag"]["parts"]["solve"] > by_deed["idle"]["parts"]["solve"]
    assert by_deed["zoom"]["parts"]["upload"] > 0
    assert by_deed["idle"]["parts"]["upload"] == 0
