"""Where nodes end, worked out where their solution is: on the GPU, in double precision."""

import moderngl
import numpy as np

from app.render.gpu import release
from app.render.solver.hierarchy import Hierarchy
from core.arrays import Bools, Floats, Ints
from core.linalg.cubic_convolution import Complexes, CubicConvolution
from core.linalg.grid_solver import Onto

_LISTS = 8
"""So many lists of nodes that come again and again are kept."""


class NodePlacement:
    """Adds solutions of the finest grid to what they displace; sends what changes, and reads the places back."""

    def __init__(self, context: moderngl.Context, hierarchy: Hierarchy) -> None:
        self._context, self._hierarchy = context, hierarchy
        self._finest = hierarchy.levels[0]
        bytes_ = 16 * self._finest.size
        self._places, self._base, self._values = (context.buffer(reserve=bytes_) for _ in range(3))
        self._coarse, self._taps, self._weights = (context.buffer(reserve=32) for _ in range(3))
        rows, columns = self._finest.shape
        self._quads = rows, 4 * -(-columns // 4)
        """Bytes that say which quads are folded: of every node's, whole numbers to a row."""
        self._folded = context.buffer(reserve=4 + self._quads[0] * self._quads[1])
        self._sent: Complexes | None = None
        """Positions that are in `base`,"""
        self._cubic: CubicConvolution | None = None
        """and what the taps are of."""
        self._lists: dict[int, tuple[Ints, moderngl.Buffer]] = {}

    def add(self, target: moderngl.Buffer, nodes: Ints, values: Floats) -> None:
        """Add `values` (n, 2) to what nodes have in a `target` in single precision."""
        self._put(target, nodes, values, "NUMBER vec2", "PUT +=")

    def place(self, v: moderngl.Buffer, onto: Onto) -> tuple[Complexes, Bools]:
        """Return where a solution takes all nodes (R, C), and which quads (R-1, C-1) that folds."""
        base = onto.base
        if onto.smooth is not None and onto.smooth.cubic is None:
            base = base + onto.smooth.d
        if base is not self._sent:
            self._base.write(np.ascontiguousarray(base))
            self._sent = base
        columns = self._send_smooth(onto)
        held = self._places, self._base, v, self._coarse, self._taps, self._weights
        for number, buffer in enumerate(held, 1):
            buffer.bind_to_storage_buffer(number)
        self._hierarchy.run("place", self._finest, columns=columns)
        self._put(self._places, onto.nodes, onto.at.view(np.float64), "NUMBER dvec2", "PUT =")
        self._folded.write(bytes(4))
        self._places.bind_to_storage_buffer(1)
        self._folded.bind_to_storage_buffer(2)
        across, down = self._finest.tiles
        self._hierarchy.run("folds", self._finest, (-(-across // 4), down))
        z = np.empty(self._finest.shape, np.complex128)
        self._places.read_into(z)
        rows, columns = z.shape
        if not any(self._folded.read(4)):
            return z, np.zeros((rows - 1, columns - 1), bool)
        folded = np.frombuffer(self._folded.read(offset=4), bool).reshape(self._quads)
        return z, folded[:-1, : columns - 1]

    def _send_smooth(self, onto: Onto) -> int:
        """Send the field that all nodes move by; return the columns of the grid that it is refined from, 0 for none."""
        if onto.smooth is None or onto.smooth.cubic is None:
            return 0
        cubic = onto.smooth.cubic
        if cubic is not self._cubic:
            taps, weights = zip(*cubic.taps, strict=True)
            for buffer, parts in (
                (self._taps, np.concatenate(taps).astype(np.int32)),
                (self._weights, np.concatenate(weights)),
            ):
                buffer.orphan(parts.nbytes)
                buffer.write(parts)
            self._coarse.orphan(onto.smooth.d.nbytes)
            self._cubic = cubic
        self._coarse.write(np.ascontiguousarray(onto.smooth.d))
        return int(onto.smooth.d.shape[1])

    def _put(self, target: moderngl.Buffer, nodes: Ints, values: Floats, *defined: str) -> None:
        if not nodes.size:
            return
        if id(nodes) not in self._lists:
            if len(self._lists) == _LISTS:
                release(self._lists.pop(next(iter(self._lists)))[1])
            self._lists[id(nodes)] = nodes, self._context.buffer(nodes.astype(np.int32).tobytes())
        self._values.write(np.ascontiguousarray(values))
        for number, buffer in enumerate((target, self._lists[id(nodes)][1], self._values), 1):
            buffer.bind_to_storage_buffer(number)
        self._hierarchy.run("put", self._finest, (-(-nodes.size // 256), 1), defined, count=nodes.size)

    def release(self) -> None:
        """Free the GPU objects."""
        held = self._places, self._base, self._values, self._coarse, self._taps, self._weights, self._folded
        release(*held, *(buffer for _, buffer in self._lists.values()))
