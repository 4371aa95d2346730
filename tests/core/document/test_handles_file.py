"""A file of handles is read whole, or refused in one line that names the handle."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core.arrays import InputError
from core.document.handles_file import from_data, read
from core.document.ring import Ring

SIDES = {
    "top": [[0, 0], [10, 0], [20, 0], [30, 0]],
    "right": [[30, 0], [30, 5], [30, 10], [30, 15]],
    "bottom": [[30, 15], [20, 15], [10, 15], [0, 15]],
    "left": [[0, 15], [0, 10], [0, 5], [0, 0]],
}
CURVE = {"source": [[1, 1], [2, 1], [3, 1], [4, 1]], "target": [[1, 2], [2, 3], [3, 3], [4, 2]]}


def test_everything_is_read(tmp_path: Path) -> None:
    path = tmp_path / "handles.json"
    data = {"pins": [{"at": [1, 2], "to": [3, 4]}], "curves": [CURVE], "outline": SIDES}
    path.write_text(json.dumps(data))
    handles = read(path, (31, 16))
    assert handles.pins_at.tolist() == [[1, 2]]
    assert handles.pins_to.tolist() == [[3, 4]]
    assert handles.outline is not None
    assert handles.outline[[0, 3, 6, 9]].tolist() == [[0, 0], [30, 0], [30, 15], [0, 15]]
    assert handles.curves[0].source.points.tolist() == CURVE["source"]


def test_a_pin_with_a_turn_or_a_scale_has_a_ring() -> None:
    pin = {"at": [1, 2], "to": [3, 4]}
    pins = [pin, pin | {"turn": 30}, pin | {"scale": 1.5}, pin | {"turn": -5.5, "scale": 2}]
    rings = from_data({"pins": pins}, (31, 16)).rings
    assert rings == (None, Ring(30, 1), Ring(0, 1.5), Ring(-5.5, 2))


def test_every_key_is_optional() -> None:
    handles = from_data({}, (31, 16))
    assert handles.pins_at.shape == (0, 2)
    assert handles.outline is None
    assert not handles.curves


@pytest.mark.parametrize(
    ("data", "fault"),
    [
        ([], "not an object"),
        ({"pin": []}, "unknown key 'pin'; known are curves, outline, pins"),
        ({"pins": {}}, '"pins" is not a list'),
        ({"pins": [{"at": [1, 2]}]}, r'pins\[0\]: has no "to"'),
        ({"pins": [{"at": [1, 2], "to": [1, "x"]}]}, r"pins\[0\]: to: not a list of \[x, y\] pairs"),
        ({"pins": [{"at": [1, 2], "to": [1, float("inf")]}]}, r"pins\[0\]: to: holds NaN or infinity"),
        ({"pins": [{"at": [1, 2], "to": [1, 10**400]}]}, r"pins\[0\]: to: not a list of \[x, y\] pairs"),
        ({"pins": [{"at": [31, 2], "to": [1, 2]}]}, r"pins\[0\]: lies outside the picture of 31x16 pixels"),
        ({"pins": [{"at": [1, 2], "to": [1, 2], "turn": "x"}]}, r"pins\[0\]: turn is not a finite number"),
        ({"pins": [{"at": [1, 2], "to": [1, 2], "turn": 10**400}]}, r"pins\[0\]: turn is not a finite number"),
        ({"pins": [{"at": [1, 2], "to": [1, 2], "scale": 0}]}, r"pins\[0\]: ring: a scale of 0 is not from 0.05 to 20"),
        ({"curves": [{"source": CURVE["source"]}]}, 'curve 1: has no "target"'),
        ({"curves": [CURVE | {"passive": True}]}, "curve 1: is passive"),
        ({"curves": [CURVE | {"source": [[0, 0], [9, 40], [9, 40], [0, 1]]}]}, "curve 1: lies outside"),
        ({"outline": {"top": SIDES["top"]}}, 'outline: has no "right"'),
        ({"outline": SIDES | {"left": SIDES["left"][:3]}}, "outline: left has 3 points, not 4"),
        ({"outline": SIDES | {"left": SIDES["left"][::-1]}}, "outline: bottom does not end where left begins"),
    ],
)
def test_faults_are_named(data: Any, fault: str) -> None:
    with pytest.raises(InputError, match=fault):
        from_data(data, (31, 16))


def test_what_is_no_json_is_named(tmp_path: Path) -> None:
    path = tmp_path / "handles.json"
    for text in ("{", "[" * 100_000):
        path.write_text(text)
        with pytest.raises(InputError, match=r"handles\.json: not a JSON file"):
            read(path, (31, 16))
    with pytest.raises(InputError, match=r"none\.json: no such file"):
        read(tmp_path / "none.json", (31, 16))


def test_numbers_are_exact() -> None:
    at = np.array([0.1, 15.4999])
    assert (from_data({"pins": [{"at": at.tolist(), "to": [0, 0]}]}, (31, 16)).pins_at == at).all()
