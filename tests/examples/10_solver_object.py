"""A solver object: factor once per grid and mask, then one pair of substitutions per frame.

Bends the same grid a little further in every frame, as a slider would, and keeps two discs round.
"""

import cv2
import numpy as np

from core.grid import Grid, find_features
from core.mapping.features.feature_mapping import FeatureMapping
from core.warps.presets import make_warp

WIDTH, HEIGHT = 640, 480

mask = np.zeros((HEIGHT, WIDTH), np.uint8)
cv2.circle(mask, (200, 220), 70, 255, -1)
cv2.circle(mask, (460, 260), 50, 255, -1)

grid = Grid(WIDTH, HEIGHT)
mapping = FeatureMapping(grid, find_features(grid, mask), keep="rigid")
print(mapping.factor)

for bend in np.linspace(0, 40, 9):
    plain = make_warp("wave", WIDTH, HEIGHT, bend=float(bend))(grid.nodes)
    positions = mapping.solve(plain)
    moved_px = np.linalg.norm(positions - grid.nodes, axis=-1).max()
    print(f"bend {bend:4.0f}: the furthest node moves by {moved_px:5.1f} px")

assert moved_px > 1
