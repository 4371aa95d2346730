"""Modules that the first frame does without, imported once it shows."""

import gc
import importlib

LOADED_LATER = (
    "scipy.linalg",
    "scipy.sparse",
    "scipy.spatial",
    "scipy.ndimage",
    "scipy.fft",
    "scipy.sparse.csgraph",
    "scipy.interpolate",
    "numpy.random",
    "importlib.metadata",
)
"""What only the tools need: SciPy and NumPy import their parts where they are first used."""


def load_rest() -> None:
    """Import them, and exempt what is there by now from garbage collection."""
    for name in LOADED_LATER:
        importlib.import_module(name)
    gc.freeze()
