"""Recipes: what is done to which pictures, as a TOML file or a project. `docs/batch.md` lists every key."""

import tomllib
import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal, TypeAlias

from core.arrays import InputError
from core.canvas import Framing
from core.document.document import Frame, Keep, Method, WarpSettings
from core.document.feature import Feature, read_feature
from core.document.keys import Easing
from core.document.plain_data import decode
from core.document.project import SUFFIX
from core.files.faults import faults_named, system_faults_named

Codec: TypeAlias = Literal["prores", "h264", "ffv1"]
Pair: TypeAlias = tuple[float, float]


@dataclass(frozen=True)
class WarpTable:
    """`[warp]`: as the options of `weft warp`. `size` is in pixels, `values` are the preset's own parameters."""

    preset: str | None = None
    bend: float = WarpSettings.bend
    horizontal: float = WarpSettings.horizontal
    vertical: float = WarpSettings.vertical
    vertical_axis: bool = WarpSettings.vertical_axis
    values: Mapping[str, float] = field(default_factory=dict)
    size: tuple[int, int] | None = None
    outline: Frame = WarpSettings.frame
    keep: Keep = WarpSettings.keep
    method: Method = WarpSettings.method
    weight: float = WarpSettings.weight
    falloff: float = WarpSettings.falloff
    straight: bool = WarpSettings.straight
    cell: float | None = None


@dataclass(frozen=True)
class KeyTable:
    """A key of a parameter."""

    frame: float
    value: tuple[float, ...]
    easing: Easing = "linear"


@dataclass(frozen=True)
class PinKeyTable:
    """A key of a pin, in pixels of the result."""

    frame: float
    to: Pair
    easing: Easing = "linear"


@dataclass(frozen=True)
class PinTable:
    """`[[pins]]`: a point in pixels of the first picture, and where it goes, in pixels of the result."""

    at: Pair
    to: Pair | None = None
    keys: tuple[PinKeyTable, ...] = ()


@dataclass(frozen=True)
class OutputTable:
    """`[output]`: how results are written."""

    frame: Framing = "picture"
    scale: float = 1.0
    bits: Literal[8, 16, 32] | None = None
    quality: int = 95
    codec: Codec | None = None
    alpha: bool = False
    rate: str | None = None

    @property
    def frames_per_second(self) -> Fraction | None:
        """The rate of a video that is made of pictures, such as 24 or 30000/1001; None for that of the project."""
        if self.rate is None:
            return None
        try:
            rate = Fraction(self.rate)
        except (ValueError, ZeroDivisionError):
            rate = Fraction(0)
        if not 0 < rate <= 1000:
            raise InputError(f"output.rate: {self.rate!r} is not a number or a fraction above 0 and up to 1000")
        return rate


@dataclass(frozen=True)
class RecipeTable:
    """The whole file; places are relative to its folder."""

    project: str | None = None
    picture: tuple[str, ...] = ()
    frames: str | None = None
    mask: str | None = None
    handles: str | None = None
    stmap: str | None = None
    displacement: str | None = None
    chunk: int = 25
    warp: WarpTable = field(default_factory=WarpTable)
    features: Mapping[str, str] = field(default_factory=dict)
    """How single features are kept, by their numbers, in the words of `weft warp --feature`."""
    pins: tuple[PinTable, ...] = ()
    keys: Mapping[str, tuple[KeyTable, ...]] = field(default_factory=dict)
    output: OutputTable = field(default_factory=OutputTable)

    @property
    def said(self) -> tuple[Feature, ...]:
        """What is said of single features."""
        return tuple(_feature(number, how) for number, how in self.features.items())


@dataclass(frozen=True)
class Recipe:
    """A recipe as it was read; plain data, so that it can be sent to another machine."""

    path: Path
    """Absolute; faults name it."""
    data: Mapping[str, Any]
    """What the file says."""

    @property
    def table(self) -> RecipeTable:
        """The recipe with the defaults of what it does not say."""
        table: RecipeTable = decode(RecipeTable, self.data, _Nothing())
        return table

    def place(self, name: str) -> Path:
        """Return the file or pattern that the recipe calls `name`."""
        return self.path.parent / name

    @property
    def project(self) -> Path | None:
        """The project that the recipe starts from."""
        return None if self.table.project is None else self.place(self.table.project)


def _feature(number: str, how: str) -> Feature:
    try:
        return read_feature(number, how)
    except InputError as fault:
        raise InputError(f"features.{number}: {fault}") from None


class _Nothing:
    """A recipe keeps nothing outside its own file."""

    def take(self, _kind: type, _data: object, _name: str) -> None:
        """Take nothing."""


def read_recipe(path: Path) -> Recipe:
    """Return the recipe in the TOML file `path`, or the one that a project is.

    Raises
    ------
    InputError
        In one line that names the file and the key that is unknown, missing or not of its kind.
    """
    path = path.absolute()
    if path.suffix.lower() == SUFFIX:
        if not path.is_file():
            raise InputError(f"{path}: no such file or directory")
        return Recipe(path, {"project": path.name})
    try:
        with system_faults_named(path):
            data = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except ValueError as fault:
        raise InputError(f"{path}: not a recipe in TOML: {fault}") from None
    recipe = Recipe(path, _list_folder(data))
    with faults_named(path):
        _check_known(RecipeTable, recipe.data, "")
        _check_values(recipe.table)
    return recipe


def _list_folder(data: dict[str, Any]) -> dict[str, Any]:
    """Return a recipe's data with lists where it may have single values, and the rate as text."""
    data = dict(data)
    if isinstance(data.get("picture"), str):
        data["picture"] = [data["picture"]]
    output = data.get("output")
    if isinstance(output, dict) and type(output.get("rate")) in (int, float):
        data["output"] = {**output, "rate": str(output["rate"])}
    if isinstance(data.get("keys"), dict):
        data["keys"] = {name: _with_lists(track) for name, track in data["keys"].items()}
    return data


def _with_lists(track: object) -> object:
    if not isinstance(track, list):
        return track
    return [
        {**key, "value": [key["value"]]} if isinstance(key, dict) and isinstance(key.get("value"), int | float) else key
        for key in track
    ]


def _check_known(hint: Any, data: object, name: str) -> None:
    """Raise `InputError` for a key of `data` that the table `hint`, or one within, does not have."""
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        _check_known(inner[0], data, name)
    elif origin is tuple and isinstance(data, list):
        for i, item in enumerate(data, 1):
            _check_known(inner[0], item, f"{name} {i}")
    elif origin is not None and origin is not tuple and isinstance(data, dict):
        for key, item in data.items():
            _check_known(inner[-1], item, f"{name}.{key}")
    elif is_dataclass(hint) and isinstance(data, dict):
        hints = typing.get_type_hints(hint)
        known = [entry.name for entry in fields(hint)]
        for key, item in data.items():
            if key not in known:
                where = f"{name}: " if name else ""
                raise InputError(f"{where}unknown key {key!r}; known are {', '.join(known)}")
            _check_known(hints[key], item, f"{name}.{key}" if name else key)


def _check_values(table: RecipeTable) -> None:
    """Raise `InputError` for what is of the right kind and cannot be."""
    if table.stmap is not None and table.displacement is not None:
        raise InputError("stmap: a recipe has this or displacement, not both")
    if not 1 <= table.chunk <= 100_000:
        raise InputError(f"chunk: {table.chunk} is not from 1 to 100000")
    if not 1 <= table.output.quality <= 100:
        raise InputError(f"output.quality: {table.output.quality} is not from 1 to 100")
    _ = table.output.frames_per_second, table.said
    if not 0 < table.output.scale <= 64:
        raise InputError(f"output.scale: {table.output.scale:g} is not above 0 and up to 64")
    for number, pin in enumerate(table.pins, 1):
        if pin.to is None and not pin.keys:
            raise InputError(f'pins {number}: has neither "to" nor "keys"')
    if table.warp.size is not None and not all(1 <= side <= 65_536 for side in table.warp.size):
        raise InputError("warp.size: sides are not from 1 to 65536 pixels")
