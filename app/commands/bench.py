"""Time the engines beside the bare solvers and the papers' own figures; judge Overlay by a folder of photographs."""

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from app.bench import (
    ablation,
    batch,
    bounds,
    export,
    gpu_mapping,
    machine,
    mapping,
    overlay,
    photographs,
    retargeting,
    retexture,
    retexture_photographs,
)
from app.window.loading import loading
from core.arrays import InputError

Record: TypeAlias = dict[str, Any]


def _window(**settings: Any) -> list[Record]:
    """Measure frames of the window; nobody else waits for what it is made with to load."""
    with loading():
        from app.bench import window
    return window.measure(**settings)


def _stories(**settings: Any) -> list[Record]:
    """Measure the longest frames of whole jobs in the window."""
    with loading():
        from app.bench import stories
    return stories.measure(**settings)


ENGINES: Mapping[str, tuple[Callable[[], list[Record]], Callable[[], list[Record]]]] = {
    "mapping": (mapping.measure, lambda: mapping.measure(mapping.SIZES[:4])),
    "retexture": (retexture.measure, lambda: retexture.measure(retexture.PAPER[:1], runs=1)),
    "overlay": (overlay.measure, lambda: overlay.measure(overlay.SIZES[:1], runs=1)),
    "export": (export.measure, lambda: export.measure(export.SIZES[:1], runs=1)),
    "window": (_window, lambda: _window(features=(4,), frames=10)),
    "stories": (_stories, lambda: _stories(frames=4)),
    "gpu": (gpu_mapping.measure, lambda: gpu_mapping.measure(gpu_mapping.QUICK)),
    "bounds": (bounds.measure, lambda: bounds.measure(bounds.QUICK)),
    "batch": (batch.measure, lambda: batch.measure(batch.QUICK_FRAMES)),
}
"""What measures each engine, in full and quickly."""
USUAL = [name for name in ENGINES if name not in {"window", "stories", "gpu", "bounds", "batch"}]
"""What is measured unless asked otherwise: the window and stories in it need a display, the GPU OpenGL 4.3, large
pictures and batches take minutes."""
PHOTOGRAPHS, RETEXTURED, RETARGETED = "photographs", "retexture-photographs", "retargeting"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `weft bench`."""
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of tables")
    parser.add_argument("--quick", action="store_true", help="small sizes and single runs only")
    parser.add_argument(
        "--only",
        nargs="+",
        metavar="NAME",
        default=USUAL,
        help=f"some of the engines, {', '.join(ENGINES)}, of which window and stories need a display; "
        f"or {PHOTOGRAPHS} DIR: how many of a folder are decomposed; "
        f"or {RETEXTURED} DIR: what is regrown of pictures with curves, beside the plain deformation; "
        f"or {RETARGETED} DIR: pictures in other sizes, beside what other operators made of them",
    )
    add = parser.add_argument
    add(
        "--without",
        nargs="+",
        metavar="STAGE",
        help=f"with {PHOTOGRAPHS}: what each of these stages is worth, {ablation.EACH} for every one: it is left out",
    )
    add("--sheets", type=Path, metavar="FOLDER", help=f"with {RETEXTURED} and {RETARGETED}: show them side by side")


def run(arguments: argparse.Namespace) -> None:
    """Measure and print."""
    engines, folders = choose(arguments.only)
    if arguments.sheets is not None and not {RETEXTURED, RETARGETED} & set(folders):
        raise InputError(f"--sheets: only with {RETEXTURED} and {RETARGETED}")
    if arguments.without and PHOTOGRAPHS not in folders:
        raise InputError(f"--without: only with {PHOTOGRAPHS}")
    found: dict[str, Any] = {"machine": machine.describe()}
    for name in engines:
        if sys.stderr.isatty():
            sys.stderr.write(f"timing {name} ...\n")
        found[name] = ENGINES[name][arguments.quick]()
    if PHOTOGRAPHS in folders and arguments.without:
        records = ablation.measure(folders[PHOTOGRAPHS], arguments.without)
        found |= {f"{PHOTOGRAPHS}_by_stage": records} if arguments.json else {}
        found[f"{PHOTOGRAPHS}_without"] = ablation.summarise(records)
    elif PHOTOGRAPHS in folders:
        found[PHOTOGRAPHS] = photographs.measure(folders[PHOTOGRAPHS])
        found[f"{PHOTOGRAPHS}_by_half"] = photographs.summarise(found[PHOTOGRAPHS])
    if RETEXTURED in folders:
        found[RETEXTURED] = retexture_photographs.measure(folders[RETEXTURED], arguments.sheets)
        found[f"{RETEXTURED}_by_half"] = retexture_photographs.summarise(found[RETEXTURED])
    if RETARGETED in folders:
        found[RETARGETED] = retargeting.measure(folders[RETARGETED], arguments.sheets)
    if arguments.json:
        sys.stdout.write(json.dumps(found, indent=1) + "\n")
        return
    sys.stdout.write(found.pop("machine") + "\n")
    for name, records in found.items():
        sys.stdout.write("\n".join(["", name, *table(records), ""]))


def choose(words: Sequence[str]) -> tuple[list[str], dict[str, Path]]:
    """Return the engines that `--only` names, and the folders of pictures that it names for a judgement."""
    engines, folders = list(words), {}
    for name, holding in ((PHOTOGRAPHS, "photographs"), (RETEXTURED, "pictures with curves"), (RETARGETED, "pictures")):
        if name not in engines:
            continue
        place = engines.index(name)
        after = [Path(word) for word in engines[place + 1 : place + 2]]
        del engines[place : place + 2]
        if not after or not after[0].is_dir():
            raise InputError(f"--only {name}: needs a folder of {holding}")
        folders[name] = after[0]
    unknown = next((name for name in engines if name not in ENGINES), None)
    if unknown is not None:
        raise InputError(
            f"--only {unknown}: not one of {', '.join(ENGINES)}, {PHOTOGRAPHS}, {RETEXTURED}, {RETARGETED}"
        )
    return engines, folders


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
