"""Arrays from files are whole arrays of numbers, or they are refused."""

import io
import tracemalloc
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core.arrays import InputError
from core.files.npy_file import read_npy, read_npz, write_npz


def npy(values: Any) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, values, allow_pickle=True)
    return buffer.getvalue()


@pytest.mark.parametrize("dtype", ["<f8", ">f4", "<f2", "<i8", "u1", "?"])
def test_whole_arrays_are_read_bit_by_bit(dtype: str) -> None:
    for values in (np.arange(24).reshape(2, 3, 4).astype(dtype), np.asfortranarray(np.eye(3, 5).astype(dtype))):
        back = read_npy(npy(values), "a")
        assert back.dtype == values.dtype
        np.testing.assert_array_equal(back, values)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"PK\x03\x04" + npy(np.eye(2)),
        npy(np.eye(2))[:-1],
        npy(np.eye(2)) + b"x",
        npy(np.eye(2)).replace(b"(2, 2)", b"(9, 9)"),
        npy(np.eye(2)).replace(b"(2, 2)", b"(-2,-2)"),
        npy(np.array([None])),
        npy(np.array(["text"])),
        npy(np.array([1j])),
        npy(np.zeros(1, "V8")),
        npy(np.array([1], np.longdouble)),
        npy(np.array(["2001-01-01"], "M8[s]")),
    ],
)
def test_everything_else_is_refused(data: bytes) -> None:
    with pytest.raises(InputError, match=r"^pins: is "):
        read_npy(data, "pins")


def test_a_header_that_asks_for_much_is_given_nothing() -> None:
    data = npy(np.eye(2)).replace(b"(2, 2), }      ", b"(2000000000,), }")
    tracemalloc.start()
    with pytest.raises(InputError):
        read_npy(data, "a")
    assert tracemalloc.get_traced_memory()[1] < 1e6
    tracemalloc.stop()


def test_of_an_archive_no_more_is_unpacked_than_the_array_needs(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("uv.npy", npy(np.zeros((4, 5))))
        archive.writestr("other.npy", bytes(50_000_000))
        archive.writestr("large.npy", bytes(50_000_000))
    tracemalloc.start()
    assert read_npz(path, "uv", [(4, 5)]).shape == (4, 5)
    with pytest.raises(InputError, match="of another picture"):
        read_npz(path, "large", [(4, 5), (4, 5, 3)])
    assert tracemalloc.get_traced_memory()[1] < 2e6
    tracemalloc.stop()
    with pytest.raises(InputError, match="has shape"):
        read_npz(path, "uv", [(5, 4)])


def test_what_is_even_is_packed_and_what_was_measured_is_not(tmp_path: Path) -> None:
    measured = np.random.default_rng(0).normal(0, 0.01, (300, 400, 3)).astype(np.float32)
    partly = np.where(np.arange(400)[:, None] < 200, measured, np.float32(np.nan))
    sizes = {}
    for name, values in (("measured", measured), ("partly", partly), ("empty", measured[:0])):
        path = tmp_path / f"{name}.npz"
        write_npz(path, run=np.uint32(7), values=values)
        np.testing.assert_array_equal(read_npz(path, "values", [values.shape]), values)
        sizes[name] = path.stat().st_size
    assert measured.nbytes < sizes["measured"] < measured.nbytes + 2000
    assert sizes["partly"] < 0.6 * measured.nbytes
