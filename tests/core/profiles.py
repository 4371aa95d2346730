"""A small valid ICC profile, made by hand."""

import struct


def icc_profile(space: bytes = b"RGB ") -> bytes:
    """Return a display profile of matrix and gamma for RGB, of gamma for GRAY."""
    gamma = b"curv" + bytes(4) + struct.pack(">IHH", 1, 0x0233, 0)
    tags = {
        b"desc": b"desc" + bytes(4) + struct.pack(">I", 5) + b"test\0" + bytes(79),
        b"cprt": b"text" + bytes(4) + b"none" + bytes(4),
        b"wtpt": _xyz(0.9642, 1, 0.8249),
    }
    if space == b"RGB ":
        tags |= {b"rXYZ": _xyz(0.436, 0.222, 0.0139), b"gXYZ": _xyz(0.385, 0.717, 0.097)}
        tags |= {b"bXYZ": _xyz(0.143, 0.06, 0.714), b"rTRC": gamma, b"gTRC": gamma, b"bTRC": gamma}
    else:
        tags[b"kTRC"] = gamma
    place = 128 + 4 + 12 * len(tags)
    table, bodies = struct.pack(">I", len(tags)), b""
    for name, body in tags.items():
        table += name + struct.pack(">II", place + len(bodies), len(body))
        bodies += body + bytes(-len(body) % 4)
    size = 128 + len(table) + len(bodies)
    head = struct.pack(">I4sI4s4s4s", size, bytes(4), 0x02100000, b"mntr", space, b"XYZ ") + bytes(12) + b"acsp"
    head += bytes(28) + struct.pack(">iii", round(0.9642 * 65536), 65536, round(0.8249 * 65536))
    return head.ljust(128, b"\0") + table + bodies


def _xyz(*values: float) -> bytes:
    return b"XYZ " + bytes(4) + struct.pack(">iii", *(round(value * 65536) for value in values))
