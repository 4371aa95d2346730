"""Marking parts of the picture: what becomes of a selection, and of the numbers of features."""
