"""Small files that the program keeps for itself: none of them may ever stop it from starting.

A damaged one is set aside under another name, so that it can be looked at and is not met again, and that is said once.
"""

import contextlib
from pathlib import Path
from typing import Any

from core.files.json_file import parse_json
from core.notices import notice

ASIDE = ".damaged"
"""Ending of the name under which a damaged file is set aside."""
MOST_BYTES = 1 << 20


def read_state(file: Path, kind: type) -> Any:
    """Return what the JSON file `file` holds, an object of `kind`; None where there is none, or it is set aside."""
    try:
        with file.open("rb") as opened:
            data = parse_json(opened.read(MOST_BYTES))
    except OSError:
        return None
    except ValueError:
        data = None
    if isinstance(data, kind):
        return data
    with contextlib.suppress(OSError):
        file.replace(file.with_name(f"{file.name}{ASIDE}"))
        notice(f"{file} was damaged: it is set aside, and Weft begins without it")
    return None
