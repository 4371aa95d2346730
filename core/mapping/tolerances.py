"""What counts as nothing in all of the mapping, and what is too little to hold anything."""

ROUNDING = 1e-9
"""Share of the size of the whole up to which lengths, scales and weights are equal."""
SINGULAR = 1e-12
"""Share of the largest eigenvalue up to which another one is 0: points that nobody can tell apart are held as one."""
MET_PX = 1e-4
"""Pixels within which a point is on its target, and has not been moved."""
SEEN_PX = 0.1
"""Pixels within which nobody sees that it is not."""
TIE = 1e-7
"""Weight of what decides only where nothing else does."""
LEAST_SHARE = 0.25
"""Share of its bilinear weight that a point needs on nodes that are to hold it: one corner's, in the mean of four."""
LITTLE = 0.1
"""Share of a whole that is little: of a size, of a step of a cell, of the room that a corner or what glides had."""
UNSEEN_PX = SEEN_PX / 40
"""Pixels that a part of what moves may be off to save time: of all that adds up, less than a tenth of that is seen."""
