"""Ground that a mesh has gone on over, told from the cloth by colour and contrast in windows of a part of a texel.

Where ground has the cloth's colour, little contradicts a mesh whose motifs fold away. What is covered, and what lies
further from that than its border is looked for, are a Gaussian and a mixture of them, of the windows' colours and
contrasts; how much likelier a window is under the second one speaks for ground, and the outline is the cheapest one,
along edges in the photo (GrabCut, Rother et al. 2004). Windows hold pixels of one side only, so that they do not tell
of the other one beside a border that is right.
"""

from dataclasses import dataclass

import numpy as np

from core.arrays import Bools, Floats, Singles
from core.overlay.filters.k_means import find_groups
from core.overlay.filters.smoothing import mean
from core.overlay.pixels.graph_cut import MOST, cut_out
from core.overlay.pixels.outline import from_outside
from core.overlay.texel import draw_sample

WIDTH = 0.25
"""Width of a window, over the side of a texel: wider ones tell more, and less of where a border is."""
GROUPS, SAMPLES = 3, 2000
"""Gaussians that what surrounds a cloth is a mixture of, and windows that tell them."""
UNEVEN = 0.05
"""Ratio of colours and of contrasts, as its logarithm, by which a surface differs from itself by light at least."""
LEAST_COLOUR, LEAST_CONTRAST = 0.02, 0.01
"""Of a channel, 0 to 1, and over the brightness: less is noise."""
LEAST_PX = 100
"""Pixels of cloth, and of ground, that tell how they look; a window at least."""
PRIOR, SURELY = 3.0, 20.0
"""What speaks for cloth where a mesh was registered, so that cloth beyond it says nothing, and most that a window
counts: natural logarithms of ratios."""
EVIDENCE = 2.0
"""How much a window counts over what its outline costs where the photo has no edge, both of the size of its width."""


@dataclass(frozen=True)
class GaussianMixture:
    """Shares (k,), means (k, d) and covariances (k, d, d) of Gaussians."""

    shares: Floats
    means: Floats
    covariances: Floats

    def log_likelihood(self, values: Singles) -> Floats:
        """Return the logarithm of the density (n,) at values (n, d), but for a constant."""
        away = values[:, None] - self.means
        squares = np.einsum("nki,kij,nkj->nk", away, np.linalg.inv(self.covariances), away, optimize=True)
        scale = np.log(self.shares) - np.linalg.slogdet(self.covariances)[1] / 2
        return np.asarray(np.logaddexp.reduce(scale - squares / 2, axis=1), np.float64)


def find_surroundings(photo: Floats | Singles, covered: Bools, followed: Bools, beyond: Bools, side_px: float) -> Bools:
    """Return which covered pixels (H, W) show what surrounds the cloth of a photo (H, W, 3), and are connected with it.

    A mesh was registered where cloth was `followed` (H, W); elsewhere it was carried on to what has its colours, which
    says nothing for it. What lies `beyond` (H, W) is surely none; nearer there may be cloth that is not covered.
    `side_px` is the side of a texel.
    """
    width_px = WIDTH * side_px
    least_px, off = max(4 * np.pi * width_px**2, LEAST_PX), np.zeros(covered.shape, bool)
    if min(covered.sum(), beyond.sum()) < least_px:
        return off
    prior = np.where(followed, PRIOR, 0.0)
    speaks = speaks_for_ground(photo, covered, covered, beyond, width_px, prior)
    ground = from_outside(covered & (speaks > 0), covered)
    cloth = covered & ~ground
    if cloth.sum() < least_px:
        return off
    speaks = EVIDENCE / width_px**2 * speaks_for_ground(photo, covered, cloth, beyond | ground, width_px, prior)
    speaks[~covered] = MOST
    found = cut_out(photo, covered, speaks) & covered
    return from_outside(found, covered)


def speaks_for_ground(
    photo: Floats | Singles, covered: Bools, cloth: Bools, ground: Bools, width_px: float, prior: Floats
) -> Floats:
    """Return how much likelier (H, W), as a logarithm, covered pixels show what `ground` (H, W) does than `cloth`.

    `prior` (H, W) is the logarithm of what speaks for cloth whatever is seen.
    """
    seen = look(np.asarray(photo, np.float32), cloth, width_px)
    # A cloth looks alike throughout.
    of_cloth = find_mixture(seen[draw_sample(cloth, SAMPLES)], 1)
    of_ground = find_mixture(seen[draw_sample(ground, SAMPLES)], GROUPS)
    out = np.zeros(covered.shape)
    odds = of_ground.log_likelihood(seen[covered]) - of_cloth.log_likelihood(seen[covered]) - prior[covered]
    out[covered] = np.clip(odds, -SURELY, SURELY)
    return out


def look(photo: Singles, mask: Bools, width_px: float) -> Singles:
    """Return the logarithms (H, W, 4) of green, red and blue over green, and contrast, in windows of a photo (H, W, 3).

    A window holds those pixels alone that are on the same side of a mask (H, W) as its middle.
    """
    inside = mask[..., None]
    colours = np.concatenate([photo, (photo**2).sum(-1, keepdims=True)], -1)
    middle = np.where(inside, *(mean(colours, side.astype(np.float32), width_px) for side in (inside, ~inside)))
    variance = np.maximum(middle[..., 3] - (middle[..., :3] ** 2).sum(-1), 0)
    contrast = np.log(variance / np.maximum(middle[..., :3].mean(-1), 1e-3) ** 2 + LEAST_CONTRAST**2) / 2
    red, green, blue = np.moveaxis(np.log(middle[..., :3] + LEAST_COLOUR), -1, 0)
    return np.stack([green, red - green, blue - green, contrast], -1)


def find_mixture(values: Singles, count: int) -> GaussianMixture:
    """Return the Gaussians of the `count` groups that values (n, d) fall into."""
    labels = find_groups(values, count)[0]
    groups = [values[labels == number] for number in range(count)]
    large = [group for group in groups if len(group) > values.shape[1]]
    even = UNEVEN**2 * np.eye(values.shape[1])
    shares = np.array([len(group) for group in large]) / sum(map(len, large))
    return GaussianMixture(
        shares, np.stack([group.mean(0) for group in large]), np.stack([np.cov(group.T) + even for group in large])
    )
