"""CHOLMOD through CVXOPT, with the kernels that the processor can run.

CVXOPT brings an OpenBLAS of its own, which gives a processor newer than itself the kernels of the oldest. One that has
AVX2 and FMA is better off with those for Haswell; what OPENBLAS_CORETYPE already says stands.
"""

import importlib
import os
from collections.abc import Iterator
from contextlib import contextmanager

import cv2

_CORETYPE = "OPENBLAS_CORETYPE"
_AVX2, _FMA3 = 11, 12
"""OpenCV's numbers of them."""


@contextmanager
def kernels() -> Iterator[None]:
    """Name the kernels to an OpenBLAS that is loaded within; others keep those that they choose."""
    if _CORETYPE in os.environ or not all(map(cv2.checkHardwareSupport, (_AVX2, _FMA3))):
        yield
        return
    os.environ[_CORETYPE] = "Haswell"
    try:
        yield
    finally:
        del os.environ[_CORETYPE]


with kernels():
    cvxopt = importlib.import_module("cvxopt")
    cholmod = importlib.import_module("cvxopt.cholmod")
