"""Sample pictures, drawn by `make_samples.py`."""

from pathlib import Path


def asset(name: str) -> Path:
    """Return the path of the file `name` of this folder."""
    return Path(__file__).parent / name
