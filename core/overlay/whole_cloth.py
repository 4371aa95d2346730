"""From a part of a cloth to all of it: the lattice that was found goes on over what stands out where it was found."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, TypeAlias, TypeVar

from core.arrays import Bools, InputError, Singles
from core.imaging.image import Image
from core.masks.object_masks import whole_object
from core.overlay.detection.corrections import lattices_of
from core.overlay.laying.compositing import searchable
from core.progress import Job, part

if TYPE_CHECKING:
    from core.overlay.decomposition import Decomposition

Finding: TypeAlias = "Callable[..., Job[Decomposition]]"
"""`decompose` of a photo, but for its region and its lattice."""
WORTH = 0.5
"""How much what is covered beyond a find explains at least, a pixel, over what the find does: less is other ground."""
NO_BETTER = "no more of the pattern is found on the whole cloth"


class Explanation(Protocol):
    """What the whole cloth is told from, and compared by."""

    @property
    def covered(self) -> Bools:
        """Pixels (H, W) of cloth."""

    @property
    def explained(self) -> float:
        """What speaks for it (`Evidence`)."""


F = TypeVar("F", bound=Explanation)


def widen(image: Image, found: F, find_on: Callable[[Bools], Job[F]]) -> Job[F]:
    """Return what `find_on` finds on the object (H, W) that is cut out of the `image` around what is `found`.

    Raises `InputError` where `found` is all of the object, or where what is covered beyond it explains little.
    """
    cloth = yield from part(whole_object(image, found.covered), 0.0, 0.1)
    wider = yield from part(find_on(cloth), 0.1, 1.0)
    area, wider_area = (max(int(find.covered.sum()), 1) for find in (found, wider))
    if wider.explained < found.explained * (1 + WORTH * max(wider_area / area - 1, 0)):
        raise InputError(NO_BETTER)
    return wider


def decompose_whole_cloth(image: Image, region: Bools | Singles | None, finding: Finding) -> "Job[Decomposition]":
    """Return the decomposition of all of the cloth of which the pattern is found in `region` (H, W).

    `finding` is called with the given region, then with the whole object and the lattice found by the first call; where
    that is no better the first find is returned.
    """
    found = yield from part(finding(region=region), 0.0, 0.6)

    def find_on(cloth: Bools) -> "Job[Decomposition]":
        lattice = lattices_of(found.lattice.keys, found.lattice.frames.points)
        return finding(region=searchable(image, cloth), lattice=lattice)

    try:
        return (yield from part(widen(image, found, find_on), 0.6, 1.0))
    except InputError:
        return found
