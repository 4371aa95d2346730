"""Pixels of a very large picture, in a temporary file without a name instead of in memory.

They are an array like any other: the system reads from the file what is looked at. What was looked at stays in memory
until it is let go; the file is gone with the program, however that ends.
"""

import mmap
import os
import tempfile

import numpy as np
from numpy.typing import DTypeLike

from core.arrays import Pixels

LARGE_BYTES = 1 << 29
"""Pixels that take as much are set aside; those of smaller pictures are in memory."""


class SetAside:
    """Takes the rows of a picture from the top down, none of which stay in memory."""

    def __init__(self, shape: tuple[int, int, int], dtype: DTypeLike) -> None:
        """Raise `OSError` where there is no room for a picture of `shape`, (H, W, C), or the system knows no way."""
        if not (hasattr(os, "posix_fallocate") and hasattr(mmap, "MADV_DONTNEED")):
            raise OSError("no files that are let go of")
        self._shape, self._dtype = shape, np.dtype(dtype)
        self._file = tempfile.TemporaryFile()  # noqa: SIM115  it is kept by the mapping that is returned
        try:
            # All at once: where the disk is full that is known before anything is read.
            os.posix_fallocate(self._file.fileno(), 0, self.size_bytes)
        except OSError:
            self._file.close()
            raise

    @property
    def size_bytes(self) -> int:
        """What all of the picture takes."""
        height, width, channels = self._shape
        return height * width * channels * self._dtype.itemsize

    def close(self) -> None:
        """Give up what is there."""
        self._file.close()

    def append(self, rows: Pixels) -> None:
        """Put rows (h, W, C) below those that are there."""
        self._file.write(np.ascontiguousarray(rows, self._dtype).data)

    def pixels(self) -> Pixels:
        """Return all pixels (H, W, C), read-only."""
        with self._file as file:
            file.flush()
            mapped = mmap.mmap(file.fileno(), self.size_bytes, access=mmap.ACCESS_READ)
        return np.frombuffer(mapped, self._dtype).reshape(self._shape)


def let_go(pixels: Pixels) -> None:
    """Let go of what was looked at of pixels that were set aside, and of views of them; nothing happens to others."""
    base: object = pixels
    while isinstance(base, np.ndarray):
        base = base.base
    mapped = base.obj if isinstance(base, memoryview) else base
    if isinstance(mapped, mmap.mmap):
        mapped.madvise(mmap.MADV_DONTNEED)
