"""Places of a grid's nodes, and of the ring around it, in a small texture that the vertex shader reads."""

from typing import NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from app.render.gpu import COMPUTE, is_software, release
from app.render.programs import programs_of
from core.arrays import Points

BLOCK = 16
"""Quads along the side of a block; only blocks that meet the target are drawn."""


class Scaling(NamedTuple):
    """How positions are looked at: scaled, and then moved."""

    scale: float = 1.0
    offset: tuple[float, float] = (0.0, 0.0)

    def place(self, points: Points) -> Points:
        """Return where positions (..., 2) are."""
        placed: Points = np.multiply(points, self.scale, order="C", dtype=np.float64)
        pairs = placed.view(np.complex128)  # in half the numbers, NumPy takes a fifth of the time for a row of pairs
        pairs += complex(*self.offset)
        return placed


class Nodes:
    """A texture of the places of R x C nodes and their ring; `at` (R + 2, C + 2, 2) is what it is to hold.

    Where it is `split`, the texture has fraction and whole of x and y, so that float32 keeps them to 1e-7 pixel in any
    picture; else x and y.
    """

    def __init__(self, context: moderngl.Context, shape: tuple[int, int], *, split: bool) -> None:
        rows, columns = shape[0] + 2, shape[1] + 2
        self.at: Points = np.zeros((rows, columns, 2))
        self.texture = context.texture((columns, rows), 4 if split else 2, dtype="f4")
        self._split = split
        self._sent = np.zeros((rows, columns, 4 if split else 2), np.float32)

    @property
    def inner(self) -> Points:
        """The part of `at` within the ring."""
        return self.at[1:-1, 1:-1]

    def send(self) -> None:
        """Send all places."""
        self._convert(self.at, self._sent)
        self.texture.write(self._sent)

    def send_ring(self) -> None:
        """Send the places of the ring, since the others are there."""
        (rows, columns), at = self.at.shape[:2], self.at
        ring = np.concatenate([at[0], at[-1], at[1:-1, 0], at[1:-1, -1]])
        sent = np.empty((len(ring), self._sent.shape[-1]), np.float32)
        self._convert(ring, sent)
        first = 0
        for left, top, width, height in (
            (0, 0, columns, 1),
            (0, rows - 1, columns, 1),
            (0, 1, 1, rows - 2),
            (columns - 1, 1, 1, rows - 2),
        ):
            last = first + width * height
            self.texture.write(sent[first:last], viewport=(left, top, width, height))
            first = last

    def _convert(self, at: Points, sent: NDArray[np.float32]) -> None:
        """Write places (..., 2) as the texture has them."""
        pairs = sent.view(np.complex64)
        for number, part in enumerate((at - (whole := np.floor(at)), whole) if self._split else (at,)):
            pairs[..., number] = np.ascontiguousarray(part).view(np.complex128)[..., 0]

    def release(self) -> None:
        """Free the texture."""
        self.texture.release()


class NodePlacer:
    """Scales R x C nodes on the GPU (OpenGL 4.3), from their positions as they are to what `Nodes` would send."""

    def __init__(self, context: moderngl.Context, shape: tuple[int, int]) -> None:
        self._context, self._programs = context, programs_of(context)
        self._blocks = -(-(shape[0] + 1) // BLOCK), -(-(shape[1] + 1) // BLOCK)
        self._nodes = context.buffer(reserve=16 * shape[0] * shape[1])
        self._boxes = context.buffer(reserve=16 * self._blocks[0] * self._blocks[1])

    def take(self, nodes: Points) -> None:
        """Take the positions (R, C, 2) that are placed from now on."""
        self._nodes.write(np.ascontiguousarray(nodes, np.float64))

    def place(self, scaling: Scaling, nodes: Nodes) -> tuple[Points, Points]:
        """Place the nodes within the ring, which has been sent.

        Return the whole pixels between which the nodes of every block are, ring included: two arrays (blocks down,
        blocks across, 2).
        """
        shader = self._programs.compute("place_nodes.comp", (f"BLOCK {BLOCK}", f"CORNERS {BLOCK + 1}"))
        shader["scale"], shader["offset"] = scaling
        nodes.texture.bind_to_image(0, read=True, write=True)
        self._nodes.bind_to_storage_buffer(0)
        self._boxes.bind_to_storage_buffer(1)
        shader.run(self._blocks[1], self._blocks[0])
        self._context.memory_barrier()
        boxes = np.frombuffer(self._boxes.read(), np.int32).astype(np.float64).reshape(*self._blocks, 2, 2)
        return boxes[..., 0, :], boxes[..., 1, :]

    def release(self) -> None:
        """Free the GPU objects."""
        release(self._nodes, self._boxes)


def find_placer(context: moderngl.Context, shape: tuple[int, int]) -> NodePlacer | None:
    """Return what places R x C nodes on the GPU; None where NumPy does that: on a software driver it is faster."""
    return None if context.version_code < COMPUTE or is_software(context) else NodePlacer(context, shape)
