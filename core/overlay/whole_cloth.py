"""From a part of a cloth to all of it: the lattice that was found goes on over what stands out where it was found."""

from collections.abc import Callable

from core.arrays import Bools, InputError, Singles
from core.imaging.image import Image
from core.masks.object_masks import whole_object
from core.overlay.composition import finite
from core.overlay.decomposition import Decomposition
from core.overlay.detection.corrections import lattices_of
from core.overlay.laying.compositing import searchable
from core.progress import Job, part

Finding = Callable[..., Job[Decomposition]]
"""`decompose` of a photo, but for its region and its lattice."""


def decompose_whole_cloth(image: Image, region: Bools | Singles | None, finding: Finding) -> Job[Decomposition]:
    """Return the decomposition of all of the cloth of which the pattern is found in `region` (H, W).

    `finding` is called with the given region, then with the object that was cut out of the `image` around what the
    first call covered, and the lattice found there. Of the two finds the one that explains more of the photo is kept.
    """
    found = yield from part(finding(region=region), 0.0, 0.6)
    try:
        cloth = yield from part(whole_object(image, finite(found.uv)), 0.6, 0.65)
        lattice = lattices_of(found.lattice.keys, found.lattice.frames.points)
        wider = yield from part(finding(region=searchable(image, cloth), lattice=lattice), 0.65, 1.0)
    except InputError:  # It is all of the cloth, or the lattice does not hold on all of it.
        return found
    return max(found, wider, key=lambda result: result.explained)
