"""Arrays in `.npy` form, read without trust: the header must describe just the bytes that follow it.

`numpy.load` would unpickle, take a zip archive for an array, and ask for as much memory as a header names.
"""

import io
import math
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.arrays import InputError
from core.files.faults import system_faults_named

KINDS = "fiub"
"""Floats, whole numbers of both kinds, and truth values; nothing else is a picture's or a curve's."""
PACKED = 1
"""How hard zlib tries, from 1 to 9."""
SAVED = 0.3
"""Share of an array's bytes that packing has to save: it takes many times as long as writing them does."""
BLOCKS, BLOCK_BYTES = 64, 16_384
"""Of an array, that are packed to see what it saves."""
HEADER_BYTES = 4096
"""No header of such an array is longer."""


_HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}


def read_npy(data: bytes, name: str) -> NDArray[Any]:
    """Return the array that `data` holds; raise `InputError` that names it unless it is a whole array of numbers."""
    file = io.BytesIO(data)
    try:
        shape, by_columns, dtype = _HEADERS[np.lib.format.read_magic(file)](file, max_header_size=HEADER_BYTES)
    except Exception:  # noqa: BLE001  a header is a Python expression, and a damaged one fails in many ways
        raise InputError(f"{name}: is not an array") from None
    if dtype.kind not in KINDS or dtype.itemsize > 8:
        raise InputError(f"{name}: is an array of {dtype}, not of numbers")
    start, count = file.tell(), math.prod(shape)
    if min(shape, default=0) < 0 or len(data) - start != count * dtype.itemsize:
        raise InputError(f"{name}: is cut short, or not as large as it says")
    values = np.frombuffer(data, dtype, count, start)
    return values.reshape(shape, order="F" if by_columns else "C")


def write_npz(path: Path, **arrays: NDArray[Any] | np.generic) -> None:
    """Write arrays of numbers by their names to an `.npz` file, packed where that saves much, as it does of even ones.

    Numbers that were measured hardly become smaller.
    """
    pays = any(saved_by_packing(np.asanyarray(values)) > SAVED for values in arrays.values() if np.ndim(values))
    kind = zipfile.ZIP_DEFLATED if pays else zipfile.ZIP_STORED
    with zipfile.ZipFile(path, "w", kind, compresslevel=PACKED) as archive:
        for name, values in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asanyarray(values), allow_pickle=False)


def saved_by_packing(values: NDArray[Any]) -> float:
    """Return about what share of the bytes of an array packing saves."""
    data = np.ascontiguousarray(values).reshape(-1).view(np.uint8)
    starts = range(0, len(data), max(len(data) // BLOCKS, BLOCK_BYTES))
    blocks = [data[start : start + BLOCK_BYTES].tobytes() for start in starts]
    packed = sum(len(zlib.compress(block, PACKED)) for block in blocks)
    return 1 - packed / max(sum(map(len, blocks)), 1)


def read_npz(path: Path, key: str, shapes: Sequence[tuple[int, ...]]) -> NDArray[Any]:
    """Return the array `key` of an `.npz` file, of one of the given shapes; no more is unpacked than those need.

    Raises `InputError` that names the file and the fault.
    """
    most = max(math.prod(shape) for shape in shapes) * 8 + HEADER_BYTES
    try:
        with system_faults_named(path), zipfile.ZipFile(path) as archive:
            member = archive.getinfo(f"{key}.npy")
            if member.file_size > most:
                raise InputError(f"{path}: '{key}' is not {list(shapes[0])} numbers: of another picture?")
            data = archive.read(member)
    except (zipfile.BadZipFile, zlib.error, KeyError, ValueError, EOFError, RuntimeError, NotImplementedError):
        raise InputError(f"{path}: not a readable array file with '{key}'") from None
    values = read_npy(data, f"{path}: '{key}'")
    if values.shape not in shapes:
        raise InputError(f"{path}: '{key}' has shape {list(values.shape)}, not {list(shapes[0])}: of another picture?")
    return values
