"""Cloth on which the model cannot be trusted: its light is the photo's, its pattern is looked for again."""

import cv2
import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.filling import solid
from core.overlay.mesh import around
from core.overlay.regaining import shifts_where_lost
from core.overlay.texel import Texel
from core.overlay.trust import local_light, trust_in

TURN = 2 * np.pi
EVERY, MARGIN = 2, 8
"""Pixels from one place to the next at which the pattern is looked for, and around where it is lost."""
BRIGHTEST = 99
"""Per cent of the light on cloth that is followed, over which that on the rest is not: it is ground that shines."""
HALF = 0.5
"""Trust under which the pattern is lost."""
LEAST = 0.1
"""Radius of a disc that fits into cloth where it is lost, over the side of a texel: a rim is held by what is inside."""


def recovered(
    photo: Floats, layers: tuple[Singles, Singles], texel: Texel, basis: Floats, followed: Bools, *, scale: int = 1
) -> tuple[Singles, Singles]:
    """Return coordinates (H, W, 2) and shading (H, W) that suit the photo (H, W, 3) also where the model does not.

    `layers` are the model's, NaN outside the cloth; `followed` (H, W) has been registered; `basis` (2, 2) is pixels of
    undeformed cloth a texel. Every `scale`-th pixel is looked at.
    """
    few, (uv, shading) = slice(None, None, scale), layers
    seen, basis = photo[few, few].astype(np.float32), basis / scale
    small, light, held = uv[few, few], shading[few, few], followed[few, few]
    covered, side = np.isfinite(light), float(np.sqrt(abs(np.linalg.det(basis))))
    trust = trust_in(seen, small, light, texel, held, side)
    if trust[covered].min(initial=1) == 1:
        return layers
    own = local_light(seen, covered, texel, basis)
    if (covered & held).any():
        own = np.minimum(own, np.float32(np.percentile(light[covered & held], BRIGHTEST)))
    lost = solid(np.asarray(covered & (~held | (trust < HALF)), np.bool_), LEAST * side)
    light = trust * light + (1 - trust) * own
    shift = shifts_of((seen, small, light), texel, basis, lost)
    trust, own, shift = (spread(plane, shading.shape) for plane in (trust, own, shift))
    return uv + shift, np.asarray(trust * shading + (1 - trust) * own, np.float32)


def shifts_of(seen: tuple[Singles, Singles, Singles], texel: Texel, basis: Floats, lost: Bools) -> Singles:
    """Return by how many texels (H, W, 2) the coordinates move where the pattern is `lost` (H, W).

    `seen` are the photo (H, W, 3), coordinates (H, W, 2) and shading (H, W).
    """
    out = np.zeros((*lost.shape, 2), np.float32)
    if lost.any():
        box, few = around(lost, MARGIN), slice(None, None, EVERY)
        photo, uv, shading = (plane[box][few, few] for plane in seen)
        shift = shifts_where_lost(photo, uv, shading, texel, basis / EVERY, lost[box][few, few])
        inside = out[box]
        # A shift of nearly a texel forth is one of a little back: what is between both is neither.
        parts = [
            spread(part.astype(np.float32), inside.shape[:2]) for part in (np.cos(TURN * shift), np.sin(TURN * shift))
        ]
        inside[lost[box]] = (np.arctan2(parts[1], parts[0]) / TURN)[lost[box]]
    return out


def spread(plane: Singles, shape: tuple[int, ...]) -> Singles:
    """Return a plane (h, w) or (h, w, C) at a larger `shape` (H, W)."""
    return np.asarray(cv2.resize(plane, shape[1::-1], interpolation=cv2.INTER_LINEAR), np.float32)
