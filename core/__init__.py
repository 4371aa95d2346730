"""Numerics and data of Weft: solvers, synthesis and decomposition. Never sees a window."""
