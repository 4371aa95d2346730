"""EXIF in WebP files, which OpenImageIO neither reads nor writes there.

A WebP file is RIFF: chunks of a name of four letters, a length, and that many bytes, padded to an even number. One with
metadata begins with a chunk VP8X, whose first byte tells which chunks follow, and may end with a chunk EXIF. Entries
are translated by way of a JPEG file of one pixel, which OpenImageIO does read and write.
"""

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import OpenImageIO

from core.files.litter import scratch_folder
from core.imaging.oiio_faults import take_fault

_EXIF_FLAG, _ALPHA_FLAG = 0x08, 0x10
_HEADER = b"Exif\0\0"
_APP1 = b"\xff\xe1"
_LONGEST = 65_533 - len(_HEADER)
"""Bytes of EXIF that a JPEG segment can hold."""


def read_exif(path: Path) -> OpenImageIO.ImageSpec | None:
    """Return a description with the EXIF entries of the WebP file `path`, None if it has none."""
    blocks = [body for name, body in _chunks(path.read_bytes()) if name == b"EXIF"]
    if not blocks or len(blocks[0]) > _LONGEST:
        return None
    exif = _HEADER + blocks[0].removeprefix(_HEADER)
    with scratch_folder() as folder:
        carrier = folder / "carrier.jpg"
        data = _carrier(carrier, OpenImageIO.ImageSpec(1, 1, 1, "uint8"))
        carrier.write_bytes(data[:2] + _APP1 + struct.pack(">H", len(exif) + 2) + exif + data[2:])
        found = OpenImageIO.ImageInput.open(str(carrier))
        take_fault(OpenImageIO)
        return None if found is None else found.spec()


def add_exif(path: Path, entries: OpenImageIO.ImageSpec) -> None:
    """Put the EXIF of `entries` into the WebP file `path`, if there is any."""
    with scratch_folder() as folder:
        carrier = _carrier(folder / "carrier.jpg", entries)
    exif = _exif_segment(carrier)
    if exif is None:
        return
    chunks = [(name, body) for name, body in _chunks(path.read_bytes()) if name != b"EXIF"]
    if chunks[0][0] != b"VP8X":
        chunks.insert(0, (b"VP8X", _extend(entries.width, entries.height, alpha=_has_alpha(*chunks[0]))))
    features = chunks[0][1]
    chunks[0] = (b"VP8X", bytes([features[0] | _EXIF_FLAG]) + features[1:])
    chunks.append((b"EXIF", exif))
    body = b"".join(name + struct.pack("<I", len(part)) + part + b"\0" * (len(part) % 2) for name, part in chunks)
    path.write_bytes(b"RIFF" + struct.pack("<I", len(body) + 4) + b"WEBP" + body)


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield name and contents of every chunk."""
    place = 12
    while place + 8 <= len(data):
        (length,) = struct.unpack_from("<I", data, place + 4)
        yield data[place : place + 4], data[place + 8 : place + 8 + length]
        place += 8 + length + length % 2


def _extend(width: int, height: int, *, alpha: bool) -> bytes:
    """Return the contents of a chunk VP8X: flags, three bytes unused, width - 1 and height - 1 in three bytes each."""
    sides = (width - 1).to_bytes(3, "little") + (height - 1).to_bytes(3, "little")
    return bytes([_ALPHA_FLAG if alpha else 0, 0, 0, 0]) + sides


def _has_alpha(name: bytes, body: bytes) -> bool:
    """Return whether a chunk of pixels holds alpha: lossless ones say so in bit 28 of the word after the signature."""
    return name == b"VP8L" and bool(struct.unpack_from("<I", body, 1)[0] >> 28 & 1)


def _carrier(path: Path, entries: OpenImageIO.ImageSpec) -> bytes:
    """Return a JPEG file of one pixel, written at `path`, with the metadata of `entries`."""
    spec = OpenImageIO.ImageSpec(1, 1, 1, "uint8")
    spec.extra_attribs = entries.extra_attribs
    spec.erase_attribute("ICCProfile")
    spec.erase_attribute("compression")
    sink = OpenImageIO.ImageOutput.create("jpeg")
    assert sink is not None
    if sink.open(str(path), spec):
        sink.write_image(np.zeros((1, 1, 1), np.uint8))
    sink.close()
    return path.read_bytes()


def _exif_segment(jpeg: bytes) -> bytes | None:
    """Return the EXIF in a JPEG file, without its header."""
    place = 2
    while place + 4 <= len(jpeg) and jpeg[place] == 0xFF and jpeg[place + 1] != 0xDA:
        (length,) = struct.unpack_from(">H", jpeg, place + 2)
        segment = jpeg[place + 4 : place + 2 + length]
        if jpeg[place : place + 2] == _APP1 and segment.startswith(_HEADER):
            return segment.removeprefix(_HEADER)
        place += 2 + length
    return None
