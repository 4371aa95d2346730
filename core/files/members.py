"""Members of a zip archive, unpacked one by one when they are asked for, and only within bounds.

A small archive can name gigabytes: what nobody asks for is not unpacked, what grows out of all proportion is refused,
and so is what all members together would take.
"""

import lzma
import zipfile
import zlib

from core.arrays import InputError

MOST_GROWTH = 250
"""A member may grow by this factor; pictures and arrays are packed already, so that none of them grows as much."""
ALWAYS_BYTES = 1 << 25
"""So much a member may hold, however small it is packed."""
TOTAL_BYTES = 1 << 34
"""All that is read of one archive."""


class Members:
    """The members of an archive that is open."""

    def __init__(self, archive: zipfile.ZipFile) -> None:
        self._archive = archive
        self._infos = {info.filename: info for info in archive.infolist()}
        self._total = 0

    def __contains__(self, name: str) -> bool:
        return name in self._infos

    def read(self, name: str) -> bytes:
        """Return what a member holds; raise `InputError` if it is missing, damaged, or too large."""
        info = self._infos.get(name)
        if info is None:
            raise InputError(f"has no {name}")
        if info.file_size > max(MOST_GROWTH * info.compress_size, ALWAYS_BYTES):
            raise InputError(f"{name} would grow out of all proportion")
        self._total += info.file_size
        if self._total > TOTAL_BYTES:
            raise InputError("holds more than a document can")
        try:
            return self._archive.read(info)
        except (OSError, zipfile.BadZipFile, zlib.error, lzma.LZMAError, ValueError, EOFError, RuntimeError) as fault:
            raise InputError(f"{name} is damaged") from fault
