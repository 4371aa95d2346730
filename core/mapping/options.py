"""What an artist chooses about a mapping."""

from dataclasses import dataclass
from typing import Literal

from core.mapping.features.feature_mapping import Method
from core.mapping.features.limits import FREE, RIGID, Limits
from core.mapping.features.straight_lines import Lines
from core.mapping.handles.plate import Frame

Keep = Literal["similarity", "rigid", "none"]


@dataclass(frozen=True)
class MappingOptions:
    """What an artist chooses about the mapping."""

    keep: Keep = "similarity"
    single: tuple[tuple[int, Limits], ...] = ()
    """Limits of single features, by number, in place of what `keep` says."""
    method: Method = "exact"
    weight: float = 10.0
    """w_F of FAT sec. 2.1."""
    falloff: float = 2.0
    """ρ, in cells."""
    lines: Lines | None = None
    """What is to stay straight beside features."""
    frame: Frame = "held"
    """Whether handles leave the outline where W has it, or draw it along."""

    def limits_of(self, number: int) -> Limits:
        """Return the limits of a feature."""
        return dict(self.single).get(number, RIGID if self.keep == "rigid" else FREE)


DEFAULT_OPTIONS = MappingOptions()
