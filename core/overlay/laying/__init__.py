"""A new texture on the cloth."""
