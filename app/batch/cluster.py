"""Chunks on Dask distributed: one task a chunk. Dask decides where, and does again what a lost worker had."""

import importlib
import logging
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from app.batch.plan import Chunk
from app.batch.pool import Tell
from app.batch.records import Row
from app.batch.work import DiskFullError, do_chunk
from core.arrays import InputError, WeftError

ANSWER_S = 10
"""How long a scheduler has to answer, and to name a worker."""
_ALIVE_S = 2


class _LostError(WeftError):
    """The scheduler is gone."""


def run_there(chunks: Sequence[Chunk], address: str, tell: Tell) -> None:
    """Do the chunks on the workers of the scheduler at `address`, and `tell` the rows of each as they come.

    Raises `InputError` where Dask is not installed, or nobody answers, and `WeftError` where the scheduler is lost.
    """
    try:
        distributed: Any = importlib.import_module("distributed")
    except ImportError:
        raise InputError("--cluster: needs Dask: pip install 'weft[cluster]'") from None
    for name in ("distributed", "distributed.client", "tornado", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)  # what is lost is said here, in one line
    try:
        client = distributed.Client(address, timeout=ANSWER_S)
    except (OSError, TimeoutError, ValueError, ImportError) as fault:
        raise InputError(f"--cluster {address}: no Dask scheduler answers there") from fault
    try:
        _do(distributed, client, chunks, address, tell)
    finally:
        client.close(timeout=_ALIVE_S)


def _do(distributed: Any, client: Any, chunks: Sequence[Chunk], address: str, tell: Tell) -> None:
    """Send every chunk, and take what comes back."""
    lost = _LostError(f"--cluster {address}: the scheduler is gone; go on with --resume")
    of_client = distributed.client
    cancelled = distributed.CancelledError, of_client.FutureCancelledError, of_client.FuturesCancelledError
    try:
        client.wait_for_workers(1, timeout=ANSWER_S)
    except TimeoutError:
        raise InputError(f"--cluster {address}: has no workers") from None
    # Dask does a lost worker's tasks again: what that worker had done of them is to be kept.
    chunks = [replace(chunk, batch=replace(chunk.batch, resume=True)) for chunk in chunks]
    waiting = {client.submit(do_chunk, chunk, pure=False): chunk for chunk in chunks}
    while waiting:
        try:
            done, _ = distributed.wait(list(waiting), timeout=_ALIVE_S, return_when="FIRST_COMPLETED")
        except TimeoutError:
            if client.status != "running":
                raise lost from None
            continue
        except cancelled:
            raise lost from None
        for future in done:
            chunk = waiting.pop(future)
            try:
                rows = future.result()
            except cancelled:
                raise lost from None
            except DiskFullError:
                raise
            except distributed.KilledWorker:
                rows = _failed(chunk, "the workers that drew it were killed")
            except Exception as fault:  # noqa: BLE001  a worker without Weft, or of another version
                rows = _failed(chunk, f"the worker: {type(fault).__name__}: {fault}")
            tell(rows)


def _failed(chunk: Chunk, fault: str) -> list[Row]:
    return [Row(item.frame, item.source, item.output, "failed", fault=fault) for item in chunk.items]
