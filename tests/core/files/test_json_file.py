"""JSON files: what is wrong with one is said in one line, whatever it is."""

import math
from pathlib import Path

import pytest

from core.arrays import InputError
from core.files.json_file import read_json


def test_a_byte_order_mark_is_no_fault(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text('{"grün": [1, 2.5, true, null]}', encoding="utf-8-sig")
    assert read_json(tmp_path / "a.json") == {"grün": [1, 2.5, True, None]}


def test_numbers_beyond_floats_are_infinite(tmp_path: Path) -> None:
    digits = 5000  # Python refuses to read so many as an integer
    (tmp_path / "a.json").write_text(f"[{'9' * 18}, -{'9' * 30}, 1{'0' * digits}, -1{'0' * digits}, 1e999]")
    small, large, *rest = read_json(tmp_path / "a.json")
    assert small == 999_999_999_999_999_999
    assert isinstance(small, int)
    assert large == -1e30
    assert rest == [math.inf, -math.inf, math.inf]


@pytest.mark.parametrize("content", [b"", b"{", b"[" * 100_000, b'{"a": "\xff"}', b"\x89PNG\r\n", b"{'a': 1}"])
def test_what_is_no_json_is_named(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "a.json").write_bytes(content)
    with pytest.raises(InputError, match=r"a\.json: not a JSON file$"):
        read_json(tmp_path / "a.json")


def test_what_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.json: no such file or directory$"):
        read_json(tmp_path / "none.json")
    with pytest.raises(InputError, match=r": is a directory$"):
        read_json(tmp_path)
