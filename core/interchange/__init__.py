"""Warps as files of other programs: ST maps and meshes."""
