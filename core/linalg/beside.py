"""Objects in a process of their own: what they do holds no lock of this one, so that other threads go on meanwhile.

A thread has one such process, started when it is first asked for; it ends with this one. Requests and answers go
through pipes.
"""

import os
import pickle
import signal
import subprocess
import sys
import threading
import weakref
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import IO, Any

from core.arrays import WeftError

_START = (
    "import pickle, sys; sys.path[:] = pickle.load(sys.stdin.buffer); from core.linalg.beside import _serve; _serve()"
)
_of_thread = threading.local()


class Process:
    """Another process and the objects in it, by number."""

    def __init__(self) -> None:
        self._child = subprocess.Popen(
            [sys.executable, "-I", "-c", _START],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
        self._lock, self._dropped, self._count = threading.Lock(), deque[int](), 0
        weakref.finalize(self, _end, self._child)
        pickle.dump(sys.path, self._child.stdin)  # type: ignore[arg-type]

    @property
    def runs(self) -> bool:
        """Whether it has not ended."""
        return self._child.poll() is None

    def kill(self) -> None:
        """End it now, whatever it does."""
        self._child.kill()
        self._child.wait()

    def make(self, make: Callable[..., object], *arguments: object) -> "Beside":
        """Make an object there."""
        with self._lock:
            self._count += 1
            number = self._count
        self.ask(number, "", make, *arguments)
        return Beside(self, number)

    def ask(self, number: int, method: str, *arguments: object) -> Any:
        """Return what a method of an object returns, or raise what it raises."""
        try:
            with self._lock:
                self._send((self._take_dropped(), number, method, arguments))
                answer = _read(self._child.stdout)  # type: ignore[arg-type]
        except (OSError, EOFError, pickle.UnpicklingError):
            self.kill()
            raise WeftError("a process that worked for this one has ended; try again") from None
        if isinstance(answer, Exception):
            raise answer
        return answer

    def drop(self, number: int) -> None:
        """Forget an object, at the latest with the next request; on any thread, at any time."""
        self._dropped.append(number)
        if self._lock.acquire(blocking=False):
            with suppress(OSError):
                self._send((self._take_dropped(), 0, "", ()))
            self._lock.release()

    def _take_dropped(self) -> list[int]:
        return [self._dropped.popleft() for _ in range(len(self._dropped))]

    def _send(self, message: object) -> None:
        stream = self._child.stdin
        assert stream is not None
        _write(stream, message)


class Beside:
    """An object in another process."""

    def __init__(self, process: Process, number: int) -> None:
        self._process, self._number = process, number
        weakref.finalize(self, process.drop, number)

    def ask(self, method: str, *arguments: object) -> Any:
        """Call a method of it."""
        return self._process.ask(self._number, method, *arguments)


def process_of_thread() -> Process | None:
    """Return this thread's other process; None for the main thread, and where none can be started.

    What the main thread waits for, nobody else does.
    """
    if threading.current_thread() is threading.main_thread():
        return None
    found: Process | None = getattr(_of_thread, "process", None)
    if found is None or not found.runs:
        try:
            found = _of_thread.process = Process()
        except OSError:
            return None
    return found


def _end(child: "subprocess.Popen[bytes]") -> None:
    child.kill()
    child.wait()
    for stream in (child.stdin, child.stdout):
        assert stream is not None
        with suppress(OSError):
            stream.close()


def _serve() -> None:
    """Answer requests until there are no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    objects: dict[int, Any] = {}
    while True:
        try:
            dropped, number, method, arguments = _read(sys.stdin.buffer)
        except EOFError:
            return
        for old in dropped:
            objects.pop(old, None)
        if not number:
            continue
        try:
            if method:
                answer = getattr(objects[number], method)(*arguments)
            else:
                make, *rest = arguments
                answer, objects[number] = None, make(*rest)
        except Exception as fault:  # noqa: BLE001  it is raised where it was asked for
            answer = fault
        _write(sys.stdout.buffer, answer)


def _write(stream: IO[bytes], message: object) -> None:
    """Send a message, arrays behind it as they are in memory: copies of them would be made under the lock."""
    arrays: list[memoryview] = []
    head = pickle.dumps(message, protocol=5, buffer_callback=lambda array: arrays.append(array.raw()))
    pickle.dump((head, [array.nbytes for array in arrays]), stream)
    for array in arrays:
        stream.write(array)
    stream.flush()


def _read(stream: IO[bytes]) -> Any:
    """Receive what `_write` sends, from a process of our own."""
    head, sizes = pickle.load(stream)  # noqa: S301
    arrays = [bytearray(size) for size in sizes]
    for array in arrays:
        if stream.readinto(array) != len(array):  # type: ignore[attr-defined]
            raise EOFError
    return pickle.loads(head, buffers=arrays)  # noqa: S301
