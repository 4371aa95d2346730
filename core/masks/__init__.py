"""Masks: painting, objects, and the files that hold them."""
