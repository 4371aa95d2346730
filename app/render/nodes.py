"""Places of a grid's nodes, and of the ring around it, in a small texture that the vertex shader reads."""

import moderngl
import numpy as np

from core.arrays import Points


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
        self._convert(np.s_[:], np.s_[:])
        self.texture.write(self._sent)

    def send_ring(self) -> None:
        """Send the places of the ring, since the others are there."""
        rows, columns = self.at.shape[:2]
        for top, bottom, left, right in (
            (0, 1, 0, columns),
            (rows - 1, rows, 0, columns),
            (1, rows - 1, 0, 1),
            (1, rows - 1, columns - 1, columns),
        ):
            self._convert(slice(top, bottom), slice(left, right))
            strip = np.ascontiguousarray(self._sent[top:bottom, left:right])
            self.texture.write(strip, viewport=(left, top, right - left, bottom - top))

    def _convert(self, rows: slice, columns: slice) -> None:
        at, sent = self.at[rows, columns], self._sent[rows, columns]
        if self._split:
            whole = np.floor(at)
            np.subtract(at, whole, out=sent[..., :2], casting="same_kind")
            sent[..., 2:] = whole
        else:
            sent[...] = at

    def release(self) -> None:
        """Free the texture."""
        self.texture.release()
