"""The overlay table of `weft bench`."""

import pytest

from app.bench.overlay import measure


def test_a_record_holds_the_whole_and_its_stages() -> None:
    (record,) = measure(((192, 200),), runs=1)
    assert record["size"] == [192, 200]
    assert record["texels"] == pytest.approx(150, rel=0.15)
    assert sum(record["stages"].values()) == pytest.approx(record["total_s"], rel=0.1)
    assert {"growing the lattice", "registering", "splitting off the detail"} <= set(record["stages"])
