"""The command line: finds the subcommand, runs it, and turns faults into one line and an exit status."""

import argparse
import importlib
import sys
from pathlib import Path
from typing import Protocol, cast

from core import tracing
from core.arrays import WeftError

COMMANDS = {
    "warp": "warp a picture and keep its features",
    "retexture": "move feature curves and regrow the texture along them",
    "decompose": "split a photo of patterned cloth into texel, mesh, shading and detail",
    "overlay": "lay a new texture into decomposed cloth",
    "render": "export a saved project",
    "bench": "time the engines beside the bare solvers",
    "presets": "list the warps and their parameters",
}


class Command(Protocol):
    """A module of `app.commands`; its docstring is the help text."""

    __doc__: str | None

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Declare the options."""

    def run(self, arguments: argparse.Namespace) -> None:
        """Do the work; raise `WeftError` for what the user can mend."""


class OneLineParser(argparse.ArgumentParser):
    """An argument parser whose errors are one line, `weft: error: ...`."""

    def error(self, message: str) -> None:  # type: ignore[override]
        """Raise the fault instead of printing the usage and leaving."""
        raise WeftError(message)


def main(arguments: list[str] | None = None) -> int:
    """Run `weft` with `arguments` (those of the process by default) and return its exit status."""
    words = sys.argv[1:] if arguments is None else arguments
    trace: Path | None = None
    try:
        command, options = parse(words)
        trace = options.trace
        if trace is not None:
            tracing.start()
        command.run(options)
    except WeftError as fault:
        print(f"weft: error: {fault}", file=sys.stderr)  # noqa: T201
        return 2
    except KeyboardInterrupt:
        print("weft: interrupted", file=sys.stderr)  # noqa: T201
        return 130
    finally:
        if trace is not None:
            tracing.save(trace)
    return 0


def parse(words: list[str]) -> tuple[Command, argparse.Namespace]:
    """Return the module of the subcommand named by `words` and its parsed options."""
    if words and words[0] in COMMANDS:
        name, rest = words[0], words[1:]
        parser = OneLineParser(prog=f"weft {name}")
    else:
        name, rest = "edit", words
        listing = "\n".join(f"  {known:11s} {what}" for known, what in COMMANDS.items())
        parser = OneLineParser(
            prog="weft",
            formatter_class=argparse.RawDescriptionHelpFormatter,
            epilog=f"commands that need no display (weft COMMAND --help):\n{listing}",
        )
    command = cast("Command", importlib.import_module(f"app.commands.{name}"))
    parser.description = command.__doc__
    parser.add_argument("--trace", type=Path, metavar="FILE", help="write a timeline in the Chrome trace event format")
    command.add_arguments(parser)
    return command, parser.parse_args(rest)
