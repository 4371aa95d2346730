"""Segmentation of what lies on the cloth or before it."""
