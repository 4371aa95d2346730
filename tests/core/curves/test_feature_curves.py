"""The curves that are kept for photographs can be read, and move something."""

from pathlib import Path

import numpy as np
import pytest

from core.curves.feature_curves import disjoint, read

FILES = sorted((Path(__file__).parents[2] / "curves").glob("*.json"))


@pytest.mark.parametrize("path", FILES, ids=[path.stem for path in FILES])
def test_a_kept_file_moves_its_curves_and_none_crosses_another(path: Path) -> None:
    curves = read(path)
    assert len(disjoint(curves)) == len(curves)
    moves = [curve.target.points - curve.source.points for curve in curves if curve.target is not None]
    assert max(np.linalg.norm(move, axis=1).max() for move in moves) > 10


def test_there_is_one_for_every_kind_of_texture() -> None:
    kinds = "beach_foam bruegel_harvesters hair_lace lemur pizza_basil starry_night tabby_cat"
    assert [path.stem for path in FILES] == kinds.split()
