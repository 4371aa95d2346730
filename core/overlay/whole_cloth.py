"""From a part of a cloth to all of it: the pattern is looked for again in what stands out where it was found."""

from collections.abc import Callable

from core.arrays import Bools, InputError, Singles
from core.imaging.image import Image
from core.masks.object_masks import whole_object
from core.overlay.composition import finite
from core.overlay.decomposition import Decomposition
from core.overlay.laying.compositing import searchable
from core.progress import Job, part

Finding = Callable[..., Job[Decomposition]]
"""`decompose` of a photo, but for its region."""


def decompose_whole_cloth(image: Image, region: Bools | Singles | None, finding: Finding) -> Job[Decomposition]:
    """Return the decomposition of all of the cloth of which the pattern is found in `region` (H, W).

    `finding` is called with a region: first the given one, then the object that was cut out of the `image` around what
    the first call covered. Of the two finds the one that explains more of the photo is kept.
    """
    found = yield from part(finding(region=region), 0.0, 0.5)
    try:
        cloth = yield from part(whole_object(image, finite(found.uv)), 0.5, 0.55)
        again = yield from part(finding(region=searchable(image, cloth)), 0.55, 1.0)
    except InputError:  # It is all of the cloth, or too little of a pattern is seen there.
        return found
    return max(found, again, key=lambda result: result.explained)
