"""What counts as the same, as near and as little in all of Overlay: light, stretch, lengths, noise."""

SHADES = (0.4, 1.6)
"""Light at a place over that of the cloth around it: a fold is no darker, and no brighter."""
STRETCH = 2.5
"""Times by which cloth may seem longer, or shorter, than it lies flat: in perspective, and beside a fold."""
LEAST_LIGHT = 0.5
"""Light under which the error of a colour is no smaller for it."""
SMOOTH_PX = 0.7
"""Blur under which single pixels are judged together."""
RIM_PX = 2
"""Pixels at a border that may be mixed with what is beside it."""
NEARBY_PX = 3.0
"""Width of the neighbourhood that tells what is usual beside a pixel."""
MOTIF, MOTIF_PX = 0.05, 1.5
"""Width that is small beside a motif: over the side of a texel, and in pixels at least."""
LEAST_NOISE = 0.005
"""Least standard deviation of a channel of a photo."""
DRAWN, TYPICAL = 1_500_000, 10_000
"""Pixels, drawn by chance, that tell what is estimated of a large photo, and the usual error of one within 1 %."""
