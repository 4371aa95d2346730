"""What large pictures may take, measured on small ones."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.bench.bounds import BOUNDS, Bound, measure
from core.arrays import WeftError


def make_nothing(folder: Path, size: tuple[int, int]) -> list[str]:
    return ["warp", str(folder / "none.jpg"), "-o", "x.jpg"]


def small(name: str) -> Bound:
    return replace(next(bound for bound in BOUNDS if bound.name == name), size=(120, 90))


def test_a_record_says_what_a_command_took_and_whether_that_is_little_enough() -> None:
    ample, tight = measure((replace(small("warp, arc"), seconds=1e9), replace(small("warp, twist"), gigabytes=0.01)))
    assert ample["holds"] is True
    assert tight["holds"] is False
    for record in (ample, tight):
        assert record["busy_s"] > 0
        assert 0.02 < record["peak_gb"] < 1.5
        assert record["size"] == [120, 90]


def test_what_this_process_holds_is_not_the_commands() -> None:
    held = np.ones(150_000_000)
    (record,) = measure((small("warp, arc"),))
    assert record["peak_gb"] < held.nbytes / 1e9


def test_regrowing_is_one_of_the_commands() -> None:
    (record,) = measure((replace(small("retexture"), size=(240, 180)),))
    assert record["seconds"] > 0


def test_a_command_that_fails_is_named_with_what_it_said() -> None:
    failing = replace(small("warp, arc"), make=make_nothing)
    with pytest.raises(WeftError, match=r"weft warp, arc: .*none\.jpg"):
        measure((failing,))
