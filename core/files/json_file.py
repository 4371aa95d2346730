"""Reading JSON: whatever is wrong with a file is one fault, which names it."""

import json
from pathlib import Path
from typing import Any

from core.arrays import InputError
from core.files.faults import system_faults_named

_DIGITS = 18
"""Integers of so many characters fit into 64 bits; longer ones are read as floats, those beyond floats as infinity."""


def read_json(path: Path) -> Any:
    """Return what a JSON file in UTF-8 holds; raise `InputError` that names it if it is missing or no JSON."""
    try:
        with system_faults_named(path):
            return parse_json(path.read_bytes())
    except ValueError:
        raise InputError(f"{path}: not a JSON file") from None


def parse_json(text: bytes) -> Any:
    """Return the value of a JSON text in UTF-8, with a byte order mark or without; raise `ValueError` if it is none."""
    try:
        return json.loads(text.decode("utf-8-sig"), parse_int=_number)
    except RecursionError:
        raise ValueError("nested too deeply") from None


def _number(digits: str) -> int | float:
    return int(digits) if len(digits) <= _DIGITS else float(digits)
