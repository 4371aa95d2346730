"""Make many pictures by one recipe: folders, sequences, videos, with key frames, here or on other machines.

RECIPE is a project or a TOML file. Pictures are files, folders, patterns with wildcards, a numbered sequence such as
shot.####.exr, or a video; in PATTERN, #### is the number of a frame and {name} the name of its picture.
"""

import argparse
import json
import re
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from app.batch import cluster, farm, pool, records
from app.batch.joining import join_segments, reopen
from app.batch.look import Look
from app.batch.plan import Chunk, plan, shard
from app.batch.recipe import read_recipe
from app.batch.records import Row
from app.batch.table import check_table, summed_up, write_table
from app.batch.work import form_of
from core.arrays import InputError, WeftError
from core.files.atomic import check_outputs, write_text


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of `weft batch`."""
    parser.add_argument("recipe", type=Path, metavar="RECIPE", help="a .weft project or a .toml recipe")
    parser.add_argument("pictures", nargs="*", metavar="PICTURE", help="in the place of those that the recipe names")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="PATTERN")
    parser.add_argument("--frames", metavar="1-500", help="which frames; 1-500x10 is every tenth, 1-3,7 a list")
    parser.add_argument("--resume", action="store_true", help="make only what is not done yet")
    parser.add_argument("--table", type=Path, metavar="FILE", help="write what became of each frame, as .json or .csv")
    where = parser.add_argument_group("where")
    where.add_argument("--jobs", type=int, default=1, metavar="N", help="processes on this machine")
    where.add_argument("--cluster", metavar="ADDRESS", help="the workers of a Dask scheduler, as tcp://host:8786")
    where.add_argument("--shard", type=_share, default=(1, 1), metavar="K/N", help="only the K-th of N shares")
    where.add_argument("--print-commands", action="store_true", help="print a command a chunk, and make nothing")
    where.add_argument("--openjd", type=Path, metavar="FILE", help="write an Open Job Description template instead")


def _share(text: str) -> tuple[int, int]:
    """Read K/N."""
    match = re.fullmatch(r"([1-9]\d{0,8})/([1-9]\d{0,8})", text)
    if match is None or int(match[1]) > int(match[2]):
        raise argparse.ArgumentTypeError(f"{text!r}: not K/N, with K from 1 to N")
    return int(match[1]), int(match[2])


def run(arguments: argparse.Namespace) -> None:
    """Plan, make the frames, and say what became of them."""
    check(arguments)
    recipe = read_recipe(arguments.recipe)
    options = {"pictures": arguments.pictures, "frames": arguments.frames, "resume": arguments.resume}
    chunks = plan(recipe, arguments.output, **options)
    base = Look(chunks[0].batch).base  # what is wrong for every frame is said once
    if chunks[0].batch.writes_video:
        form_of(chunks[0].batch, base)
    own = shard(chunks, *arguments.shard)
    if arguments.print_commands:
        sys.stdout.write("".join(f"{line}\n" for line in farm.commands(own, len(chunks), words(arguments))))
    elif arguments.openjd is not None:
        found = farm.template(arguments.recipe.stem, len(chunks), words(arguments))
        write_text(arguments.openjd, json.dumps(found, indent=1) + "\n")
    else:
        _make(arguments, chunks, own)


def check(arguments: argparse.Namespace) -> None:
    """Raise `InputError` for options that cannot be."""
    if not 1 <= arguments.jobs <= 1024:
        raise InputError(f"--jobs {arguments.jobs}: not from 1 to 1024")
    check_table(arguments.table)
    check_outputs([arguments.table, arguments.openjd], beside=[arguments.recipe])


def words(arguments: argparse.Namespace) -> list[str]:
    """Return the command line of another machine that shares the folders: the same, with absolute paths."""
    pictures = [str(Path(name).absolute()) for name in arguments.pictures]
    frames = [f"--frames={arguments.frames}"] if arguments.frames else []
    return [str(arguments.recipe.absolute()), *pictures, "-o", str(arguments.output.absolute()), *frames]


def _make(arguments: argparse.Namespace, chunks: Sequence[Chunk], own: Sequence[Chunk]) -> None:
    """Make the frames of the shards that are this machine's."""
    batch, rows, started = chunks[0].batch, list[Row](), time.perf_counter()
    if not arguments.resume:
        records.fresh(own)
    elif batch.writes_video:
        reopen(chunks)

    def tell(found: Sequence[Row]) -> None:
        rows.extend(found)
        for row in found:
            _say(row)
        if sys.stderr.isatty():
            sys.stderr.write(f"\r\x1b[K{len(rows)} of {sum(len(chunk.items) for chunk in own)} frames")
            sys.stderr.flush()

    try:
        if arguments.cluster is not None:
            cluster.run_there(own, arguments.cluster, tell)
        else:
            pool.run_here(own, arguments.jobs, tell)
    finally:
        if arguments.table is not None:
            write_table(rows, arguments.table)
    if batch.writes_video and not join_segments(chunks):
        sys.stderr.write(f"weft: note: {batch.output}: is joined when the other shards are done\n")
    sys.stdout.write(summed_up(rows, time.perf_counter() - started) + "\n")
    failures = sum(row.state == "failed" for row in rows)
    if failures:
        raise WeftError(f"{failures} of {len(rows)} frames failed")


def _say(row: Row) -> None:
    """Write the faults and notices of a frame, one line each."""
    lead = "\r\x1b[K" if sys.stderr.isatty() else ""
    if row.state == "failed":
        sys.stderr.write(f"{lead}weft: error: frame {row.frame}: {row.fault}\n")
    for text in row.notes if row.state == "done" else ():
        sys.stderr.write(f"{lead}weft: note: frame {row.frame}: {' '.join(text.split())}\n")
