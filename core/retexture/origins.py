"""The places from which patches are grown: what placement finds, synthesis uses and a result keeps."""

from dataclasses import dataclass

from core.arrays import Bools, Floats, Ints, Points


@dataclass(frozen=True, eq=False)
class Origins:
    """Places to grow n patches from, in the order of their synthesis."""

    target: Points
    heading: Points
    """(n, 2) unit tangents at the target."""
    source: Points
    source_heading: Points
    source_turn: Floats
    """(n,) angle between the source grid and the source's directions, radians."""
    offset: Floats
    """(n,) signed distances from the target curve, px."""
    curve: Ints
    """(n,) which curve is nearest."""
    free: Floats
    """(n,) how far candidates may lie off the corresponding place, see `region.Region`."""
    scale: Floats
    """(n,) by how much the patch is smaller than others (DPD sec. 3.5)."""

    def __len__(self) -> int:
        return len(self.target)

    def taken(self, which: Bools | Ints | slice) -> "Origins":
        """Return the origins that `which` picks."""
        return Origins(*(part[which] for part in self.__dict__.values()))
