"""The command line: finds the subcommand, runs it, and turns faults into one line and an exit status."""

import argparse
import errno
import importlib
import io
import os
import re
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn, Protocol, cast

from app.window.loading import loading
from core import tracing
from core.arrays import WeftError
from core.files.atomic import atomic_file, check_outputs
from core.notices import hear_notices

COMMANDS = {
    "warp": "warp a picture and keep its features",
    "retexture": "move feature curves and regrow the texture along them",
    "decompose": "split a photo of patterned cloth into texel, mesh, shading and detail",
    "overlay": "lay a new texture into decomposed cloth",
    "render": "export a saved project",
    "batch": "make many pictures by one recipe: folders, sequences, videos",
    "bench": "time the engines beside the bare solvers",
    "presets": "list the warps and their parameters",
    "doctor": "say what this machine has of what Weft needs",
    "desktop": "put Weft among the desktop's programs, with .weft files its own",
}


class Command(Protocol):
    """A module of `app.commands`; its docstring is the help text."""

    __doc__: str | None

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Declare the options."""

    def run(self, arguments: argparse.Namespace) -> None:
        """Do the work; raise `WeftError` for what the user can mend."""


class Terminated(BaseException):
    """The process was asked to end; `status` is the exit status that says so."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.status = 128 + number


class OneLineParser(argparse.ArgumentParser):
    """An argument parser whose errors are one line, `weft: error: ...`."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        # What begins so is a value, not an option: -5, -.5, -1e3, and -0.5,0.25 for a pair.
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def _print_message(self, message: str, file: Any = None) -> None:
        """Write help or version, and let nothing of what goes wrong with that be lost, as argparse does."""
        stream = file or sys.stderr
        stream.write(message)
        stream.flush()

    def error(self, message: str) -> NoReturn:
        """Raise the fault instead of printing the usage and leaving."""
        raise WeftError(message)


def main(arguments: list[str] | None = None) -> int:
    """Run `weft` with `arguments` (those of the process by default) and return its exit status.

    An interrupt is left to `app.__main__`, which also has those that come before this file is loaded.
    """
    _open_streams()
    try:
        command, options = parse(sys.argv[1:] if arguments is None else arguments)
        check_outputs([options.trace], beside=_other_paths(options))
        with ended_by_signals(), record(options.trace), hear_notices() as heard:
            command.run(options)
        for text in heard:
            sys.stderr.write(f"weft: note: {' '.join(text.split())}\n")
        sys.stdout.flush()
    except WeftError as fault:
        return _fail(str(fault))
    except MemoryError:
        return _fail("not enough memory")
    except Terminated as end:
        return end.status
    except BrokenPipeError:  # who read standard output has had enough
        _give_up_output()
    except OSError as fault:
        _give_up_output()
        return _fail(f"{fault.filename or 'standard output'}: {(fault.strerror or str(fault)).lower()}")
    return 0


class _Closed(io.TextIOBase):
    """Standard output that was closed before the program began."""

    def write(self, text: str) -> int:
        """Refuse."""
        raise OSError(errno.EBADF, "is closed")


def _open_streams() -> None:
    """Put something in the place of streams that are closed, which Python leaves None.

    Their numbers are taken too: a file that is opened for writing must not get what a library prints.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    if sys.stdout is None:
        sys.stdout = _Closed()
    if sys.stderr is None:
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115  for as long as the program runs


def _give_up_output() -> None:
    """Have what is left in the buffer of standard output not fail again at exit."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, ValueError):  # it has no number: it was closed, or is no file
        return


def _other_paths(options: argparse.Namespace) -> Iterator[Path]:
    """Yield the files and folders that options name, but for the timeline."""
    for name, value in vars(options).items():
        for path in value if isinstance(value, list) else [value]:
            if isinstance(path, Path) and name != "trace":
                yield path


def _fail(fault: str) -> int:
    """Say what went wrong, in one line, and return the exit status of it."""
    sys.stderr.write(f"weft: error: {' '.join(fault.split())}\n")
    return 2


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """Have the signals that end a process end the block as a fault does, so that nothing half done stays behind."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def end(number: int, _frame: object) -> None:
        raise Terminated(number)

    numbers = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    heeded = [number for number in numbers if signal.getsignal(number) is signal.SIG_DFL]
    for number in heeded:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number in heeded:
            signal.signal(number, signal.SIG_DFL)


@contextmanager
def record(trace: Path | None) -> Iterator[None]:
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


class _Version(argparse.Action):
    """Says which version this is; it is read only when it is asked for, since that takes its time."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        parser._print_message(f"weft {version('weft')}\n", sys.stdout)
        parser.exit()


def parse(words: list[str]) -> tuple[Command, argparse.Namespace]:
    """Return the module of the subcommand named by `words` and its parsed options."""
    if words and words[0] in COMMANDS:
        name, rest = words[0], words[1:]
        parser = OneLineParser(prog=f"weft {name}", allow_abbrev=False)
    else:
        name, rest = "edit", words
        listing = "\n".join(f"  {known:11s} {what}" for known, what in COMMANDS.items())
        parser = OneLineParser(
            prog="weft",
            allow_abbrev=False,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            epilog=f"commands that need no display (weft COMMAND --help):\n{listing}",
        )
        parser.add_argument("--version", action=_Version, nargs=0, help="show program's version number and exit")
    with loading():
        command = cast("Command", importlib.import_module(f"app.commands.{name}"))
    parser.description = command.__doc__
    parser.add_argument("--trace", type=Path, metavar="FILE", help="write a timeline in the Chrome trace event format")
    command.add_arguments(parser)
    return command, parser.parse_args(rest)
