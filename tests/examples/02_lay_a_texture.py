"""Take a part of the sample's cloth apart, recombine it to the photo, and lay stripes into its folds."""

import numpy as np

from assets import asset
from core.imaging.color import unit
from core.imaging.images import load
from core.overlay.composition import compose
from core.overlay.decomposition import decompose
from core.progress import run

photo = unit(load(asset("folded_print.png")).pixels[250:480, 300:560, :3]).astype(np.float64)
parts = run(decompose(photo, seed=0))
inside = parts.covered
print(f"{len(parts.lattice)} vertices, {inside.mean():.0%} covered, in {sum(parts.seconds.values()):.1f} s")

again = parts.reconstruction + parts.detail
assert np.abs(again - photo)[inside].max() < 1e-5

stripes = np.ones((64, 64, 3))
stripes[:, ::32] = stripes[:, 1::32] = (0.1, 0.2, 0.6)
uv, shading, detail = (layer.astype(np.float64) for layer in (parts.uv, parts.shading, parts.detail))
new, opacity = compose(stripes, uv, shading, detail, parts.basis, alpha=0.0)
shown = np.where((opacity > 0)[..., None], new, photo).clip(0, 1)
assert np.array_equal(shown[~inside], photo[~inside])
