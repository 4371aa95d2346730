"""One thread for BLAS: on small blocks, its threads wait for one another longer than they work."""

from contextlib import AbstractContextManager

import numpy as np  # noqa: F401  loads the library to be found
import scipy.linalg  # noqa: F401
from threadpoolctl import ThreadpoolController

_LIBRARIES = ThreadpoolController().select(user_api="blas")


def one_thread() -> AbstractContextManager[object]:
    """Hold BLAS to one thread, whatever the caller's process has it use, for as long as the context lasts."""
    limited: AbstractContextManager[object] = _LIBRARIES.limit(limits=1)
    return limited
