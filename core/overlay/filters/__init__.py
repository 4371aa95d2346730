"""Sampling, smoothing and distances of pictures."""
