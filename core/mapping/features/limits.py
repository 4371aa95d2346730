"""What bounds the similarity z = α p + t of a feature, beside that it is one."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from core.arrays import InputError


@dataclass(frozen=True)
class Limits:
    """Bounds of |α|, and whether α has to be real; raise `InputError` for bounds that nothing lies between."""

    least: float = 0.0
    most: float = math.inf
    turns: bool = True
    """Else α is real and positive: the feature stays upright."""
    weight: float = 1.0
    """How much it is protected, over 0; under 1 softly, as `soft_features` says."""

    def __post_init__(self) -> None:
        if not (0 <= self.least <= self.most and self.most > 0 and math.isfinite(self.least)):
            raise InputError(f"size of a feature from {self.least:g} to {self.most:g}: must be positive, and in order")
        if not 0 < self.weight <= 1:
            raise InputError(f"protection of a feature by {self.weight:g}: must be over 0, and 1 at most")

    @property
    def is_rigid(self) -> bool:
        """Whether the feature keeps its size."""
        return self.least == self.most == self.weight == 1

    @property
    def fix_size(self) -> bool:
        """Whether one size is left."""
        return self.least == self.most


FREE, RIGID = Limits(), Limits(1.0, 1.0)
Single = Mapping[int, Limits]
"""The limits of single features, by number."""
NONE: Single = MappingProxyType({})
