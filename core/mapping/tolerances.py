"""What counts as nothing in all of the mapping."""

ROUNDING = 1e-9
"""Share of the size of the whole up to which lengths, scales and weights are equal."""
SINGULAR = 1e-12
"""Share of the largest eigenvalue up to which another one is 0: points that nobody can tell apart are held as one."""
