"""Whether a PNG file is whole, told by its chunks: libpng says what it misses to the terminal rather than to who asks.

Source: PNG specification, sections 5.2 to 5.4.
"""

import zlib
from pathlib import Path
from typing import BinaryIO

SIGNATURE = b"\x89PNG\r\n\x1a\n"
_PIECE = 1 << 20
"""So many bytes are read at once."""


def is_broken_png(path: Path) -> bool:
    """Return whether a file begins as a PNG but is cut short, or one of its critical chunks is damaged."""
    with path.open("rb") as file:
        if file.read(len(SIGNATURE)) != SIGNATURE:
            return False
        while (kind := _next_chunk(file)) is not None:
            if kind == b"IEND":
                return False
    return True


def _next_chunk(file: BinaryIO) -> bytes | None:
    """Read on by one chunk and return its type; None where it is cut short or its checksum is wrong."""
    head = file.read(8)
    if len(head) < 8:
        return None
    left, kind = int.from_bytes(head[:4], "big"), head[4:]
    is_critical = not kind[0] & 0x20
    total = zlib.crc32(kind)
    while left:
        piece = file.read(min(left, _PIECE))
        if not piece:
            return None
        left -= len(piece)
        total = zlib.crc32(piece, total) if is_critical else 0
    checksum = file.read(4)
    if len(checksum) < 4 or (is_critical and int.from_bytes(checksum, "big") != total):
        return None
    return kind
