"""Texture grown patch by patch, joined by graph cuts (DPD sec. 3.3 and 3.4)."""
