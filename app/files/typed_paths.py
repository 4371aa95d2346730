"""File names as they are typed: what cannot be the name of a file is said, and never a fault of the program."""

import os
from pathlib import Path

from core.arrays import InputError

LONGEST_BYTES = 255
"""Of one name, on all file systems of today."""


def is_folder(path: Path) -> bool:
    """Return whether `path` is a folder that can be seen; False for names that no file system takes."""
    return os.path.isdir(path)  # noqa: PTH112  pathlib raises an exception for what is too long or out of bounds


def is_file(path: Path) -> bool:
    """Return whether `path` is a file that can be seen; False for names that no file system takes."""
    return os.path.isfile(path)  # noqa: PTH113  as above


def is_there(path: Path) -> bool:
    """Return whether there is a file or folder at `path` that can be seen."""
    return is_folder(path) or is_file(path)


def resolve_name(folder: Path, name: str) -> Path:
    """Return what is meant by a name or a whole path typed in `folder`: `~` is a home, `..` the folder above.

    Blanks around it count only where such a file exists. Raises `InputError` for what cannot be a path.
    """
    if is_there(folder / name):
        return _without_detours(folder / name)
    name = name.strip()
    if "\0" in name:
        raise InputError("a name cannot hold a zero byte")
    try:
        path = folder / Path(name).expanduser()
    except RuntimeError:
        raise InputError(f"{name.split('/')[0]}: there is no such user") from None
    if any(len(os.fsencode(part)) > LONGEST_BYTES for part in path.parts):
        raise InputError(f"{name[:20]} …: the name is too long")
    return _without_detours(path)


def _without_detours(path: Path) -> Path:
    """Return the path to the same file without `..` on the way: it is shown, and listed among recent files."""
    return Path(os.path.realpath(path.parent), path.name) if ".." in path.parent.parts else path


def file_to_write(folder: Path, name: str) -> Path:
    """Return the file that is meant by a name typed in `folder`; raise `InputError` if no file can be written there."""
    if not name.strip():
        raise InputError("type a name")
    path = resolve_name(folder, name)
    if is_folder(path) or not path.name or name.rstrip().endswith("/") or path.name == "..":
        raise InputError(f"{path}: is a folder, type a name as well")
    if not is_folder(path.parent):
        raise InputError(f"{path.parent}: no such folder")
    return path
