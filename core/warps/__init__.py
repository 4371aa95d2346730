"""Warps W: R2 -> R2, by name, by outline or by expression."""
