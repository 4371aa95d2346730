"""Passes: the picture, the marks over it, drafts and thumbnails."""
