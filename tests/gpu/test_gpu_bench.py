"""What `weft bench --only gpu` measures."""

import pytest

from app.bench.gpu_mapping import measure
from app.render import gpu

pytestmark = pytest.mark.gpu


def test_both_ways_are_timed_on_the_same_frames() -> None:
    if gpu.standalone().version_code < gpu.COMPUTE:
        pytest.skip("no OpenGL 4.3")
    records = measure([(21, 25)])
    assert [(record["deed"], record["grid"]) for record in records] == [("preset", [21, 25]), ("pins", [21, 25])]
    for record in records:
        assert record["steps"] > 0
        assert record["apart_px"] < 0.01
        assert record["ratio"] == record["factor_ms"] / record["gpu_ms"]
