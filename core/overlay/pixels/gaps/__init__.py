"""Cloth between the parts whose pattern was surely followed: these are moved by whole texels, and sewn together."""
