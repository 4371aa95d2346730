"""List the warps and their parameters."""

import argparse
import json
import sys
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from core.warps.presets import BEND, HORIZONTAL, PRESETS, VERTICAL, Parameter, Preset


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `weft presets`."""
    parser.add_argument("--json", action="store_true", help="print a JSON list instead of a table")


def run(arguments: argparse.Namespace) -> None:
    """Print the table."""
    text = (
        json.dumps([record(preset) for preset in PRESETS.values()], indent=1) if arguments.json else "\n".join(lines())
    )
    sys.stdout.write(f"{text}\n")


def record(preset: Preset) -> dict[str, Any]:
    """Return what a script wants to know about `preset`."""
    return {
        "name": preset.name,
        "label": preset.label,
        "group": preset.group,
        "parameters": [asdict(parameter) for parameter in parameters(preset)],
        "settings": [parameter.name for parameter in preset.settings],
    }


def parameters(preset: Preset) -> tuple[Parameter, ...]:
    """Return everything that `preset` can be given, its own settings last."""
    return (*((BEND,) if preset.bends else ()), HORIZONTAL, VERTICAL, *preset.settings)


def lines() -> Iterator[str]:
    """Yield the table for people."""
    yield "Each takes --horizontal and --vertical distortion and --vertical-axis, each but none takes --bend:"
    yield "per cent, from -100 to 100. What follows --set is its own."
    group = ""
    for preset in PRESETS.values():
        if preset.group != group:
            group = preset.group
            yield f"\n{group}"
        yield f"  {preset.name}"
        for parameter in preset.settings:
            span = f"{parameter.low:g} to {parameter.high:g}{parameter.unit}"
            yield f"      --set {parameter.name + '=' + format(parameter.default, 'g'):22s} {parameter.label}, {span}"
