"""One call: regrow the fur of the sample's tail along a curve that is bent elsewhere.

What comes back is a place of the source for every pixel, so that a further layer of the same size goes along.
"""

import numpy as np

from assets import asset
from core.curves import feature_curves
from core.imaging.images import load
from core.progress import run
from core.retexture.job import Settings, retexture

picture = load(asset("fox_tail.png"))
curves = feature_curves.read(asset("fox_tail_curves.json"))

found = run(retexture(picture.pixels, curves, Settings(seed=1), previews=False))
fur = found.apply(picture.pixels)
light_and_dark = found.apply(picture.pixels.mean(axis=2, keepdims=True).astype(np.float32), linear=True)

print(f"{found.patches} patches out of {found.candidates} candidates for {fur.shape[1]}x{fur.shape[0]} pixels")
assert fur.shape == picture.pixels.shape
assert light_and_dark.shape == (*fur.shape[:2], 1)
