"""Array aliases, shape checks and the error tree.

Conventions of the whole program: coordinates are (x, y) float64, y down, pixel centres at integers; a picture of
H x W pixels covers [-0.5, W - 0.5] x [-0.5, H - 0.5]; arrays of pixels are (H, W, C). Letters: N nodes, M quads,
R x C grid rows and columns, H x W pixels.
"""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
"""Any float64 array."""
Points: TypeAlias = NDArray[np.float64]
"""Positions (..., 2), x then y."""
Ints: TypeAlias = NDArray[np.int64]
Bools: TypeAlias = NDArray[np.bool_]
Bytes: TypeAlias = NDArray[np.uint8]
Singles: TypeAlias = NDArray[np.float32]
Pixels: TypeAlias = NDArray[Any]
"""(H, W, C) of uint8, uint16 or float32."""


class WeftError(Exception):
    """A fault that the program can explain in one line."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Go to another process as it is: what a class is made from need not be what its message says."""
        return _fault_again, (type(self), self.args, vars(self))


def _fault_again(kind: type[WeftError], arguments: tuple[Any, ...], state: dict[str, Any]) -> WeftError:
    fault = kind.__new__(kind, *arguments)
    vars(fault).update(state)
    return fault


class InputError(WeftError):
    """What the user gave cannot be used; the message names it and the fault, in one line."""


class CurveError(InputError):
    """One of several curves cannot be used; `number` says which, counted from 1."""

    def __init__(self, number: int, fault: str) -> None:
        super().__init__(f"curve {number}: {fault}")
        self.number = number


class SingularSystemError(WeftError):
    """A linear system without a unique solution; `nodes` says where."""

    def __init__(self, message: str, nodes: Ints | None = None) -> None:
        super().__init__(message)
        self.nodes = np.empty(0, np.int64) if nodes is None else nodes


def readonly(array: NDArray[Any]) -> NDArray[Any]:
    """Return `array` with writing switched off; a view is copied first, so that nobody else writes to it."""
    if array.base is not None:
        array = array.copy()
    array.flags.writeable = False
    return array


def as_points(values: object, name: str = "points") -> Points:
    """Return `values` as finite (n, 2) float64; raise `InputError` that names them if they are not."""
    try:
        points = np.asarray(values, np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name}: not a list of [x, y] pairs") from None
    if points.shape == (0,):
        return np.empty((0, 2))
    if points.ndim != 2 or points.shape[1] != 2:
        raise InputError(f"{name}: not a list of [x, y] pairs")
    if not np.isfinite(points).all():
        raise InputError(f"{name}: holds NaN or infinity")
    return points
