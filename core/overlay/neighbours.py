"""Steps from a place on a grid to those beside it."""

import numpy as np

STEPS = np.array([(1, 0), (0, 1), (1, 1), (1, -1)])
"""To the eight neighbours, one of each two opposite ones."""
