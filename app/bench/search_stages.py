"""The stages of the search that can be left out, to see what they are worth: what stands in for each."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any, NamedTuple, TypeVar

import numpy as np

from core.overlay import cloth_search
from core.overlay.detection import seeding
from core.overlay.registration import evidence, fitting, pieces
from core.overlay.search import finding
from core.progress import Job, Progress

T = TypeVar("T")


class Place(NamedTuple):
    """Where the search calls a stage by its name, and what it calls where that is left out."""

    module: Any
    instead: Callable[..., Any]


def find_none(*_: object, **__: object) -> Job[None]:
    """Refuse the picture."""
    yield Progress(0.0, "")
    raise seeding.NoPatternError


def propose_none(*_: object, **__: object) -> list[object]:
    """Return an empty list."""
    return []


def keep(found: T) -> Job[T]:
    """Return what was found before."""
    yield Progress(0.0, "")
    return found


SEARCH_STAGES = {
    "alike_keypoints": Place(seeding, propose_none),
    "can_be_magnified": Place(finding, lambda _: False),
    "confirm": Place(finding, lambda finds, new: [*finds, new]),
    "find_in_all": Place(cloth_search, find_none),
    "find_large": Place(finding, find_none),
    "find_print": Place(cloth_search, find_none),
    "find_starts": Place(pieces, propose_none),
    "least_texel": Place(finding, lambda _photo, _canvas, found, *_: keep(found)),
    "may_be_plaid": Place(evidence, lambda *_: False),
    "true_period": Place(fitting, lambda *_: np.eye(2)),
    "with_more_pieces": Place(fitting, lambda _cloth, found, *_, **__: keep(found)),
}


@contextmanager
def replaced(name: str, other: Callable[..., Any]) -> Iterator[None]:
    """Have the search call another function in place of a stage."""
    module = SEARCH_STAGES[name].module
    own = getattr(module, name)
    setattr(module, name, other)
    try:
        yield
    finally:
        setattr(module, name, own)


@contextmanager
def watched() -> Iterator[set[str]]:
    """Give the names of the stages that the search has come to: the others are worth nothing to a photo."""
    called: set[str] = set()

    def noted(name: str) -> Callable[..., Any]:
        own = getattr(SEARCH_STAGES[name].module, name)

        def stage(*values: object, **named: object) -> object:
            called.add(name)
            return own(*values, **named)

        return stage

    with ExitStack() as stack:
        for name in SEARCH_STAGES:
            stack.enter_context(replaced(name, noted(name)))
        yield called
