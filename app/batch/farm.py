"""A batch for schedulers of render farms: a command a chunk, or a template in Open Job Description."""

import shlex
from collections.abc import Sequence
from typing import Any

from app.batch.plan import Chunk
from core.arrays import InputError


def commands(chunks: Sequence[Chunk], count: int, words: Sequence[str]) -> list[str]:
    """Return one command for each of the chunks, of `count` in all; `words` are what follows `weft batch`."""
    return [
        shlex.join(["weft", "batch", *words, "--shard", f"{chunk.number + 1}/{count}", "--resume"]) for chunk in chunks
    ]


def template(name: str, count: int, words: Sequence[str]) -> dict[str, Any]:
    """Return a job template of Open Job Description 2023-09: one step with a task for each of `count` chunks.

    Raises `InputError` for words that a template would take for a reference.
    """
    for word in words:
        if "{{" in word:
            raise InputError(f"{word}: a name with {{{{ cannot stand in a job template")
    arguments = ["batch", *words, "--shard", f"{{{{Task.Param.Chunk}}}}/{count}", "--resume"]
    chunk = {"name": "Chunk", "type": "INT", "range": f"1-{count}"}
    return {
        "specificationVersion": "jobtemplate-2023-09",
        "name": name[:64],
        "steps": [
            {
                "name": "Weft",
                "parameterSpace": {"taskParameterDefinitions": [chunk]},
                "script": {"actions": {"onRun": {"command": "weft", "args": arguments}}},
            }
        ],
    }
