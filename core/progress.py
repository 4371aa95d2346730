"""Long work as generators: they yield `Progress` and return their result.

A generator can be stopped at any yield, shown while it runs, and run to its end by `run`. Nothing else is needed for
cancelling, previews and tests.
"""

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeAlias, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Progress:
    """How far a job is."""

    fraction: float
    """0 to 1; never runs backwards within a job."""
    note: str = ""
    """What it does now, as a user would say it: "choosing patches"."""
    preview: Any = None
    """A partial result of the job's own kind, or None."""
    work: int = 0
    """What the step took, as the job counts it: the same on any machine."""


Job: TypeAlias = Generator[Progress, None, T]


class Steps(Generic[T]):
    """The steps of a job, to go through once with `for`; afterwards there is its result."""

    result: T

    def __init__(self, job: Job[T]) -> None:
        self._job = job

    def __iter__(self) -> Iterator[Progress]:
        self.result = yield from self._job


def run(job: Job[T], report: Callable[[Progress], None] | None = None) -> T:
    """Run `job` to its end and return its result, handing every step to `report`."""
    for step in (steps := Steps(job)):
        if report is not None:
            report(step)
    return steps.result


def in_one_step(note: str, work: Callable[..., T], *arguments: object) -> Job[T]:
    """Call `work` with its `arguments`, as a job of a single step."""
    yield Progress(0.0, note)
    return work(*arguments)


def stepwise(job: Job[T], change: Callable[[Progress], Progress]) -> Job[T]:
    """Run `job` with what `change` makes of each step in its place."""
    for step in (steps := Steps(job)):
        yield change(step)
    return steps.result


def part(job: Job[T], start: float, end: float) -> Job[T]:
    """Run `job` as the part of a longer one that takes the fraction from `start` to `end`."""
    return stepwise(job, lambda step: replace(step, fraction=start + (end - start) * step.fraction))


def forwards(job: Job[T]) -> Job[T]:
    """Run `job`, whose parts may be done in any order, with the largest fraction so far in the place of each."""
    reached = 0.0

    def onwards(step: Progress) -> Progress:
        nonlocal reached
        reached = max(reached, step.fraction)
        return replace(step, fraction=reached)

    return stepwise(job, onwards)
