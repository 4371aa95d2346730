"""Frozen dataclasses as plain JSON data and back, led by their type hints.

Known are numbers, text, None, `Literal`, unions with None, tuples, frozensets, mappings from text, arrays and
dataclasses. A part of a document needs no code of its own to be saved. What is too large for JSON, such as pictures,
goes through a `Pack`.
"""

import math
import sys
import types
import typing
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np

from core.arrays import InputError


class Pack(Protocol):
    """Keeps values of some types outside the JSON data."""

    def put(self, value: object, name: str) -> object | None:
        """Keep `value`, found at `name`, and return the data that stands for it; None for a type not kept here."""


class Unpack(Protocol):
    """Gives back what a `Pack` kept."""

    def take(self, kind: type, data: object, name: str) -> object | None:
        """Return the value that `data` stands for; None for a type not kept here."""


def encode(value: object, parts: Pack, *, name: str = "") -> object:
    """Return `value` as data for `json.dump`; `name` is where it stands, for messages and file names."""
    kept = parts.put(value, name)
    if kept is not None:
        return kept
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError(f"{name}: is not a finite number")
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Mapping):
        return {key: encode(item, parts, name=f"{name}.{key}") for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [encode(item, parts, name=f"{name}.{i}") for i, item in enumerate(value)]
    if isinstance(value, frozenset):
        return sorted(value)
    if is_dataclass(value):
        return {f.name: encode(getattr(value, f.name), parts, name=_below(name, f.name)) for f in fields(value)}
    raise InputError(f"{name}: {type(value).__name__} cannot be saved")


def decode(hint: Any, data: Any, parts: Unpack, *, name: str = "") -> Any:
    """Return the value of type `hint` that `data` stands for; raise `InputError` that names what does not fit."""
    hint = _unaliased(hint)
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        rest = [kind for kind in inner if kind is not type(None)]
        return None if data is None else decode(rest[0], data, parts, name=name)
    kept = parts.take(origin or hint, data, name)
    if kept is not None:
        return kept
    if origin is typing.Literal:
        return _check(data, data in inner, name, f"one of {', '.join(map(str, inner))}")
    if origin is tuple:
        return _decode_tuple(inner, data, parts, name)
    if origin is frozenset:
        return frozenset(decode(inner[0], item, parts, name=name) for item in _checked_list(data, name))
    if origin is not None and issubclass(origin, Mapping):
        _check(data, isinstance(data, dict), name, "an object")
        return MappingProxyType(
            {key: decode(inner[1], item, parts, name=_below(name, key)) for key, item in data.items()}
        )
    if is_dataclass(hint):
        return _decode_dataclass(hint, data, parts, name)
    return _decode_plain(hint, data, name)


def _unaliased(hint: Any) -> Any:
    """Return what a name made by `type` stands for: from NumPy 2.5 on, `NDArray` is one where Python has them."""
    while hasattr(alias := typing.get_origin(hint) or hint, "__value__"):
        hint = alias.__value__
    return hint


def _decode_plain(hint: Any, data: Any, name: str) -> Any:
    """Return a number, text or truth value."""
    if hint is float:
        number = isinstance(data, int | float) and not isinstance(data, bool) and abs(data) <= sys.float_info.max
        return float(_check(data, number, name, "a finite number"))
    if hint in (int, str, bool):
        return _check(data, type(data) is hint, name, f"of type {hint.__name__}")
    raise TypeError(f"{name}: no way to read {hint}")


def _decode_tuple(inner: tuple[Any, ...], data: Any, parts: Unpack, name: str) -> tuple[Any, ...]:
    """Return a tuple of any length of one type, or one of given types."""
    items = _checked_list(data, name)
    kinds = [inner[0]] * len(items) if len(inner) == 2 and inner[1] is Ellipsis else list(inner)
    _check(items, len(items) == len(kinds), name, f"a list of {len(kinds)}")
    return tuple(
        decode(kind, item, parts, name=f"{name}.{i}") for i, (kind, item) in enumerate(zip(kinds, items, strict=True))
    )


def _decode_dataclass(hint: Any, data: Any, parts: Unpack, name: str) -> Any:
    """Return a dataclass; what `data` lacks takes its default."""
    _check(data, isinstance(data, dict), name, "an object")
    hints = typing.get_type_hints(hint)
    found = {}
    for entry in fields(hint):
        if entry.name in data:
            found[entry.name] = decode(hints[entry.name], data[entry.name], parts, name=_below(name, entry.name))
        elif entry.default is MISSING and entry.default_factory is MISSING:
            raise InputError(f"{_below(name, entry.name)}: is missing")
    return hint(**found)


def _checked_list(data: Any, name: str) -> list[Any]:
    """Return `data` if it is a list."""
    checked: list[Any] = _check(data, isinstance(data, list), name, "a list")
    return checked


def _check(data: Any, fits: bool, name: str, what: str) -> Any:
    """Return `data` if it fits."""
    if not fits:
        raise InputError(f"{name}: is not {what}")
    return data


def _below(name: str, part: str) -> str:
    return f"{name}.{part}" if name else part


def as_list(array: np.ndarray[Any, Any]) -> list[Any]:
    """Return the numbers of an array as nested lists; `float64` survives JSON bit by bit."""
    listed: list[Any] = array.tolist()
    return listed
