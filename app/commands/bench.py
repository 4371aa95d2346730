"""Time the engines beside the bare solvers and the papers' own figures: medians of several runs."""

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, TypeAlias

from app.bench import export, machine, mapping, overlay, retexture

Record: TypeAlias = dict[str, Any]

ENGINES: Mapping[str, tuple[Callable[[], list[Record]], Callable[[], list[Record]]]] = {
    "mapping": (mapping.measure, lambda: mapping.measure(mapping.SIZES[:4])),
    "retexture": (retexture.measure, lambda: retexture.measure(retexture.PAPER[:1], runs=1)),
    "overlay": (overlay.measure, lambda: overlay.measure(overlay.SIZES[:1], runs=1)),
    "export": (export.measure, lambda: export.measure(export.SIZES[:1], runs=1)),
}
"""What measures each engine, in full and quickly."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `weft bench`."""
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of tables")
    parser.add_argument("--quick", action="store_true", help="small sizes and single runs only")
    parser.add_argument("--only", nargs="+", choices=ENGINES, default=list(ENGINES), help="some of the engines")


def run(arguments: argparse.Namespace) -> None:
    """Measure and print."""
    found: dict[str, Any] = {"machine": machine.describe()}
    for name in arguments.only:
        if sys.stderr.isatty():
            sys.stderr.write(f"timing {name} ...\n")
        found[name] = ENGINES[name][arguments.quick]()
    if arguments.json:
        sys.stdout.write(json.dumps(found, indent=1) + "\n")
        return
    sys.stdout.write(found.pop("machine") + "\n")
    for name, records in found.items():
        sys.stdout.write("\n".join(["", name, *table(records), ""]))


def table(records: Sequence[Record]) -> Iterator[str]:
    """Yield the lines of a table with a column for every field, those of nested objects as `bare.solve_ms`."""
    rows = [dict(_flat(record)) for record in records]
    names = list(dict.fromkeys(name for row in rows for name in row))
    cells = [names, *([_shown(row.get(name)) for name in names] for row in rows)]
    widths = [max(len(line[i]) for line in cells) for i in range(len(names))]
    for line in cells:
        yield "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True))


def _flat(record: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in record.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _shown(value: object) -> str:
    match value:
        case None:
            return "-"
        case float():
            return f"{value:.4g}"
        case list() | tuple():
            return "x".join(str(part) for part in value)
    return str(value)
