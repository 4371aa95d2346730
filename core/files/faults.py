"""Faults that name what they are about: a file, an entry of it."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from core.arrays import InputError


@contextmanager
def faults_named(name: object) -> Iterator[None]:
    """Put `name` before every `InputError` of the block."""
    try:
        yield
    except InputError as fault:
        raise InputError(f"{name}: {fault}") from None


@contextmanager
def system_faults_named(path: object) -> Iterator[None]:
    """Turn an `OSError` of the block into an `InputError` that names `path`."""
    try:
        yield
    except OSError as fault:
        raise InputError(f"{path}: {(fault.strerror or str(fault)).lower()}") from fault


def make_folder(folder: Path) -> None:
    """Make a folder, and those that it lies in; raise `InputError` where that cannot be done."""
    with system_faults_named(folder):
        folder.mkdir(parents=True, exist_ok=True)
