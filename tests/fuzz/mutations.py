"""Damage, drawn from a seed: to bytes, to JSON trees, to arrays and to zip archives."""

import contextlib
import copy
import io
import json
import random
import struct
import zipfile
from typing import Any

import numpy as np

ODD: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 0.5, -0.0, 1e-300, 1e-5, 1e9, -1e9, 1e300, -1e300, 10**18, 10**400, -(10**30),
    float("nan"), float("inf"), float("-inf"), "", "a", "nan", "0", "\ud800", "\0", "a" * 5000, "../../a", "weft.json",
    [], [[]], [[[]]], {}, [None], [0], [0, 0], [1, 2, 3], [[0, 0]], [[0, 0]] * 4, [[1, "2"]], {"file": "a"}, {"": 0},
)  # fmt: skip
"""What may stand in the place of a value."""
DTYPES = (
    "<f8",
    ">f8",
    "<f4",
    "<f2",
    "<i8",
    "<u1",
    "|b1",
    "<c16",
    "|S4",
    "<U3",
    "|O",
    "|V8",
    "<M8[s]",
    "<f16",
    "nonsense",
)
SHAPES: tuple[tuple[int, ...], ...] = (
    (),
    (0,),
    (0, 2),
    (1,),
    (2,),
    (4, 2),
    (5, 2),
    (4, 3),
    (12, 2),
    (1, 1, 1),
    (10**9, 2),
    (2**62,),
)


def damaged_bytes(data: bytes, draw: random.Random) -> bytes:
    """Return bytes with some of them changed, cut out, doubled or cut off."""
    parts = bytearray(data)
    for _ in range(draw.choice((1, 1, 2, 4, 16))):
        at = draw.randrange(len(parts) + 1)
        match draw.randrange(6):
            case 0 if parts:
                parts[min(at, len(parts) - 1)] = draw.randrange(256)
            case 1:
                del parts[at:]
            case 2:
                del parts[at : at + draw.randrange(1, 32)]
            case 3:
                parts[at:at] = draw.randbytes(draw.randrange(1, 16))
            case 4:
                parts[at : at + 4] = struct.pack(
                    draw.choice("<>") + "I", draw.choice((0, 1, 0xFF, 0xFFFF, 2**31, 2**32 - 1))
                )
            case _:
                parts[at:at] = parts[at : at + draw.randrange(1, 64)]
    return bytes(parts)


def damaged_tree(data: Any, draw: random.Random) -> Any:
    """Return a JSON tree with some of its nodes exchanged, taken out, doubled or put elsewhere."""
    tree = copy.deepcopy(data)
    for _ in range(draw.choice((1, 1, 1, 2, 3, 6))):
        places = [place for place in _places(tree) if place]
        if not places:
            return draw.choice(ODD)
        parent, key = draw.choice(places)
        match draw.randrange(7):
            case 0 | 1 | 2:
                parent[key] = copy.deepcopy(draw.choice(ODD))
            case 3:
                del parent[key]
            case 4:
                other, there = draw.choice(places)
                parent[key] = copy.deepcopy(other[there])
            case 5 if isinstance(parent, list):
                parent.insert(key, copy.deepcopy(parent[key]))
            case _ if isinstance(parent[key], int | float) and not isinstance(parent[key], bool):
                with contextlib.suppress(OverflowError):
                    parent[key] = parent[key] * draw.choice((-1, 10, 1e3, 1e6, 1e-6, 0))
            case _:
                parent[key] = [copy.deepcopy(parent[key])]
    return tree


def _places(tree: Any) -> list[tuple[Any, Any]]:
    """Return every node of a tree as what holds it and its key there."""
    found: list[tuple[Any, Any]] = []
    left = [tree]
    while left:
        node = left.pop()
        keys = list(node) if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ()
        for key in keys:
            found.append((node, key))
            left.append(node[key])
    return found


def written(tree: Any, draw: random.Random) -> bytes:
    """Return a tree as JSON text, sometimes damaged itself."""
    text = json.dumps(tree).encode("utf-8")
    match draw.randrange(12):
        case 0:
            return damaged_bytes(text, draw)
        case 1:
            return b"[" * draw.choice((10, 1000, 100_000)) + text
        case 2:
            return text.decode().encode(draw.choice(("utf-16", "utf-8-sig", "latin-1")))
    return text


def damaged_npy(data: bytes, draw: random.Random) -> bytes:
    """Return a `.npy` file with another header, other bytes, or something else altogether."""
    match draw.randrange(6):
        case 0:
            return damaged_bytes(data, draw)
        case 1:
            return b"PK\x03\x04" + data
        case 2:
            return b""
        case 3:
            fields = {
                "descr": draw.choice(DTYPES),
                "fortran_order": draw.choice((True, False, 3)),
                "shape": draw.choice(SHAPES),
            }
            header = repr(fields).encode() + b"\n"
            return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + data[-draw.randrange(1, 80) :]
        case 4:
            values = np.array(draw.choices((0.0, 1.0, np.nan, np.inf, -1e300, 7.0), k=24)).reshape(
                draw.choice(((24,), (12, 2), (8, 3)))
            )
            with np.errstate(all="ignore"):
                return npy(values.astype(draw.choice((np.float64, np.float32, np.int8, np.bool_))))
    return draw.randbytes(draw.randrange(200))


def npy(values: "np.ndarray[Any, Any]") -> bytes:
    """Return an array as a `.npy` file."""
    buffer = io.BytesIO()
    np.save(buffer, values)
    return buffer.getvalue()


def zipped(members: dict[str, bytes], draw: random.Random) -> bytes:
    """Return a zip archive, sometimes damaged itself."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content, draw.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)))
    return damaged_bytes(buffer.getvalue(), draw) if draw.randrange(8) == 0 else buffer.getvalue()
