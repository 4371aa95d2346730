"""From a part of a cloth to all of it: what was found goes on over what stands out where it was found."""

from collections.abc import Callable
from typing import Protocol, TypeVar

from core.arrays import Bools, InputError
from core.imaging.image import Image
from core.masks.object_masks import whole_object
from core.progress import Job, part

WORTH = 0.5
"""How much what is covered beyond a find explains at least, a pixel, over what the find does: less is other ground."""
NO_BETTER = "no more of the pattern is found on the whole cloth"


class Explanation(Protocol):
    """What the whole cloth is told from, and compared by."""

    @property
    def covered(self) -> Bools:
        """Pixels (H, W) of cloth."""

    @property
    def area_px(self) -> int:
        """Pixels that it covers in the end, of the photo as it was searched."""

    @property
    def explained(self) -> float:
        """What speaks for it beside another one of the same photo."""


F = TypeVar("F", bound=Explanation)


def widen(image: Image, found: F, find_on: Callable[[Bools], Job[F]]) -> Job[F]:
    """Return what `find_on` finds on the object (H, W) that is cut out of the `image` around what is `found`.

    Raises `InputError` where `found` is all of the object, or where what is covered beyond it explains little.
    """
    cloth = yield from part(whole_object(image, found.covered), 0.0, 0.1)
    wider = yield from part(find_on(cloth), 0.1, 1.0)
    growth = wider.area_px / max(found.area_px, 1) - 1
    if wider.explained < found.explained * (1 + WORTH * max(growth, 0)):
        raise InputError(NO_BETTER)
    return wider
