"""Open the editor on a picture, a project, or the sample."""

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `weft`."""
    parser.add_argument("file", nargs="?", type=Path, help="a picture or a project")


def run(arguments: argparse.Namespace) -> None:
    """Open the window."""
    raise NotImplementedError
