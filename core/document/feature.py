"""What the artist said of a single feature."""

from dataclasses import dataclass
from math import inf
from typing import Literal

from core.mapping.features.limits import Limits

KeptAs = Literal["similarity", "rigid"]


@dataclass(frozen=True)
class Feature:
    """What the artist said of a feature that has a number; of others nothing is said.

    Raises `InputError` for sizes that nothing lies between.
    """

    number: int
    """That of its pixels in `Document.numbers`, 1 to 255."""
    name: str = ""
    """Empty for one that goes by its number."""
    kept: bool = True
    """Whether it keeps its shape; else it is warped like what is not painted."""
    keep: KeptAs | None = None
    """How it keeps it; None for as all do: `WarpSettings.keep`."""
    upright: bool = False
    """Whether it does not turn."""
    least: float | None = None
    most: float | None = None
    """Its size at least and at most, in times that in the picture; None for no bound. A rigid one has its own."""

    def __post_init__(self) -> None:
        self.limits(rigid=False)

    def limits(self, *, rigid: bool) -> Limits:
        """Return what it may do where those of which nothing is said are `rigid`, or similar."""
        if rigid if self.keep is None else self.keep == "rigid":
            return Limits(1.0, 1.0, not self.upright)
        return Limits(self.least or 0.0, inf if self.most is None else self.most, not self.upright)
