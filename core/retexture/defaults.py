"""What a document and the engine both take where nothing else is asked for."""

VARIETY = 0.8
"""Cost of showing a place of the picture once more."""
