"""The command line: finds the subcommand, runs it, and turns faults into one line and an exit status."""

import argparse
import importlib
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn, Protocol, cast

from core import tracing
from core.arrays import WeftError
from core.files import atomic_file

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

    def error(self, message: str) -> NoReturn:
        """Raise the fault instead of printing the usage and leaving."""
        raise WeftError(message)


def main(arguments: list[str] | None = None) -> int:
    """Run `weft` with `arguments` (those of the process by default) and return its exit status."""
    try:
        command, options = parse(sys.argv[1:] if arguments is None else arguments)
        with recorded(options.trace):
            command.run(options)
        sys.stdout.flush()
    except WeftError as fault:
        return _fail(str(fault))
    except MemoryError:
        return _fail("not enough memory")
    except KeyboardInterrupt:
        sys.stderr.write("weft: interrupted\n")
        return 130
    except BrokenPipeError:
        # Who read standard output has had enough. What is left in the buffer must not fail again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 0


def _fail(fault: str) -> int:
    """Say what went wrong, in one line, and return the exit status of it."""
    sys.stderr.write(f"weft: error: {' '.join(fault.split())}\n")
    return 2


@contextmanager
def recorded(trace: Path | None) -> Iterator[None]:
    """Write a timeline of the block to `trace`, if there is one, however the block ends."""
    if trace is None:
        yield
        return
    tracing.start()
    try:
        yield
    finally:
        with atomic_file(trace) as place:
            tracing.save(place)


def parse(words: list[str]) -> tuple[Command, argparse.Namespace]:
    """Return the module of the subcommand named by `words` and its parsed options."""
    if words and words[0] in COMMANDS:
        name, rest = words[0], words[1:]
        parser = OneLineParser(prog=f"weft {name}", allow_abbrev=False)
    else:
        from importlib.metadata import version

        name, rest = "edit", words
        listing = "\n".join(f"  {known:11s} {what}" for known, what in COMMANDS.items())
        parser = OneLineParser(
            prog="weft",
            allow_abbrev=False,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            epilog=f"commands that need no display (weft COMMAND --help):\n{listing}",
        )
        parser.add_argument("--version", action="version", version=f"weft {version('weft')}")
    command = cast("Command", importlib.import_module(f"app.commands.{name}"))
    parser.description = command.__doc__
    parser.add_argument("--trace", type=Path, metavar="FILE", help="write a timeline in the Chrome trace event format")
    command.add_arguments(parser)
    return command, parser.parse_args(rest)
